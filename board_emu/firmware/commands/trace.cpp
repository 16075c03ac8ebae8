// Host rays [P §3.5, §3.6]: their types, and how they are returned.
#include <algorithm>
#include <cstdlib>

#include "command_fault.h"
#include "datapath/interaction.h"
#include "each_command.h"
#include "firmware/ray_sources/host_rays.h"
#include "gicube/wire/command.h"

namespace gicube::emu {

namespace {

using wire::RayType;

constexpr std::uint64_t kMaxMoved = std::uint64_t{1} << 34;

bool comes_back(RayType type) { return type != RayType::kDeposit && type != RayType::kBackproject; }

// Checks a header byte that only one ray type uses: 0 or 1, or 0 for other types.
void check_choice(const char* name, unsigned value, bool has) {
  expect(value <= (has ? 1u : 0u), name, has ? "0 or 1" : "0", value);
}

}  // namespace

void set_type(Frame& frame, const wire::TraceHeader& header) {
  frame.type = header.type;
  if (header.type == RayType::kIntegrate) return;
  frame.opacity_threshold = frame.to_the_hit() ? header.opacity : wire::kOpacityOne;
  frame.scatter = frame.high_albedo = false;
  if (header.type != RayType::kSegment) frame.lit_by_irradiance = false;
  if (!frame.segments()) return;
  frame.jitter = false;
  frame.cut_planes.clear();
  if (frame.integral() || frame.backprojects()) frame.skip_empty = false;  // blocks without opacity may have density
}

void check_trace_header(const wire::TraceHeader& header) {
  expect(header.type <= RayType::kBackproject, "type", "0..6", static_cast<std::uint64_t>(header.type));
  const bool deposit = header.type == RayType::kDeposit, threshold = wire::has_threshold(header.type);
  check_choice("albedo", static_cast<unsigned>(header.albedo), deposit);
  check_choice("rules", static_cast<unsigned>(header.rules), deposit);
  check_choice("words", static_cast<unsigned>(header.words), header.type == RayType::kBackproject);
  expect(threshold || header.opacity == 0, "opacity", "0", header.opacity);
  expect(!threshold || (header.opacity >= 1 && header.opacity <= wire::kOpacityOne), "opacity", "1..2^24 - 1",
         header.opacity);
}

namespace {

std::uint8_t flags_of(const wire::TraceHeader& header) {
  if (header.type != RayType::kDeposit) return wire::kHostRay;
  return static_cast<std::uint8_t>(wire::kHostRay | wire::kLightingRay |
                                   (header.albedo == wire::Albedo::kHigh ? wire::kHighAlbedo : 0));
}

// Limited by the bits of a ray's energy [P §4.2].
std::uint64_t max_energy_of(const wire::TraceHeader& header, bool wide) {
  const unsigned bits = wide ? 24 : header.albedo == wire::Albedo::kHigh ? 4 : 8;
  return ((std::uint64_t{1} << bits) - 1) << kEnergyFractionBits;
}

void check_words(const wire::Ray& ray, const wire::TraceHeader& header, std::uint64_t max_energy) {
  const std::uint64_t word = ray.colour_word();
  const bool segment = wire::is_segment(header.type);
  expect(!segment || word <= wire::kMaxLength, "length", "0..4096 voxels in 16.16", word);
  if (header.type == RayType::kBackproject) {
    const std::int32_t amount = wire::sign_extend(ray.opacity, 24);
    const bool whole = header.words == wire::SumWords::kWhole;
    expect(amount <= wire::kMaxAmount && amount >= (whole ? -wire::kMaxAmount : 0), "opacity",
           whole ? "an amount of at least -(2^23 - 1)" : "an amount of 0..2^23 - 1", ray.opacity);
    return;
  }
  expect(!segment || ray.opacity == 0, "opacity", "0 of a segment", ray.opacity);
  if (header.type == RayType::kDeposit && (word == 0 || word > max_energy)) {
    refuse("energy", "1.." + std::to_string(max_energy) + " (24.12)", word);
  }
}

// Maximum change of one accumulator by these rays.
std::uint64_t max_moved(std::span<const wire::Ray> rays, const Frame& frame) {
  std::uint64_t sum = 0;
  for (const wire::Ray& ray : rays) {
    const auto size = static_cast<std::uint32_t>(std::abs(wire::sign_extend(ray.opacity, 24)));
    sum += wire::max_moved(size, static_cast<std::uint32_t>(ray.colour_word()), frame.step);
  }
  return sum;
}

// The completion of a backprojection. `overflow`: the excess that was clipped from the accumulators.
void add_deposits(CommandResult& result, const RayCounters& counts, const Overflow& overflow) {
  wire::DepositLedger ledger;
  ledger.rays = counts.rays;
  ledger.samples = counts.samples;
  ledger.kept = static_cast<std::int64_t>(counts.energy.deposited.kept) - overflow.clipped;
  ledger.clipped = static_cast<std::int64_t>(counts.energy.deposited.clipped) + overflow.clipped;
  ledger.overflowed = overflow.words;
  result.payload = wire::encoded(ledger);
  result.up_bytes = result.payload.size();
}

// Adds the rays to those in the DSP's memory, for an out-of-core volume. Deposit rays are not kept.
std::span<wire::Ray> take_in(Card& card, const wire::TraceHeader& header, std::span<wire::Ray> rays) {
  std::vector<wire::Ray>& all = card.aperture.host_rays();
  const bool stay = comes_back(header.type);
  if (!card.goes_on) {
    if (!card.waiting_rays.go_on_with(header)) {
      card.drop_rays();
      card.waiting_rays.begin(WaitingKind::kHostRays, header);
    }
    const std::uint64_t sum = stay ? all.size() + rays.size() : 0;
    expect(sum <= wire::kMaxHostRays, "rays", "at most 2^24 in all trace commands of a series", sum);
    card.waiting_rays.number(rays.size());
    if (stay) all.insert(all.end(), rays.begin(), rays.end());
  }
  if (!stay) return rays;
  expect(all.size() >= rays.size(), "rays", "those of the checkpoint's command", all.size());
  return std::span(all).last(rays.size());
}

}  // namespace

CommandResult trace_rays(Card& card, Payload payload, Progress& work) {
  const auto header = header_of<wire::TraceHeader>(payload);
  if (payload.size() != wire::kTraceHeaderBytes + std::uint64_t{header.count} * wire::kRayBytes) {
    refuse("payload", "16 + 32 bytes for each of its " + std::to_string(header.count) + " rays", payload.size());
  }
  check_trace_header(header);
  card.check_volume();
  const bool deposit = header.type == RayType::kDeposit, back = comes_back(header.type), waits = card.in_bricks();
  if (!waits) card.check_all_there();
  expect(!waits || header.type != RayType::kBackproject, "type",
         "0..5 of a volume with more blocks than the card stores", static_cast<std::uint64_t>(header.type));
  Frame frame = card.trace_frame(header);
  if (frame.scatter || deposit) card.check_materials(false);
  if (frame.backprojects() && frame.accumulators == nullptr) {
    expect(frame.light_words == 1, "words", "1 (sums) on a card of three irradiance words", 0);
    card.aperture.expect_deposits();
  }
  const std::size_t count = header.count;
  const std::uint64_t max_energy = max_energy_of(header, frame.wide);
  std::vector<wire::Ray>& rays = card.host_ray_room;
  rays.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    rays[i] = wire::decode<wire::Ray>(payload.subspan(wire::kTraceHeaderBytes + i * wire::kRayBytes));
    check_part("ray", i, [&] {
      if (rays[i].flags != flags_of(header)) refuse("flags", std::to_string(flags_of(header)), rays[i].flags);
      check_ray(rays[i], frame.extent);
      check_words(rays[i], header, max_energy);
    });
  }
  if (frame.accumulators != nullptr) {
    frame.max_moved = max_moved(rays, frame);
    expect(frame.max_moved <= kMaxMoved, "rays", "at most 2^34 as the largest possible change of one accumulator",
           frame.max_moved);
  }
  std::span<wire::Ray> traced(rays);
  if (waits) traced = take_in(card, header, rays);
  if (waits) card.set_bricks(frame);
  card.expect_memory(frame);
  if (!frame.backprojects()) card.aperture.decode(card.threads, reads(frame));
  HostRays source(traced, frame, back);
  const RunResult ran = card.run_level(source, frame, work);
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  card.host_rays += count;
  result.takes_rays = count > 0;
  if (deposit) {
    card.lighting_rays += count;
    card.add_ledger(result, ran.rays, false);
    card.add_waiting(result);
    return result;
  }
  if (waits) {
    card.add_waiting(result);
    return result;
  }
  if (frame.backprojects()) {
    add_deposits(result, ran.rays, frame.accumulators != nullptr ? frame.accumulators->settle() : Overflow{});
    return result;
  }
  result.payload.resize(count * wire::kRayBytes);
  for (std::size_t i = 0; i < count; ++i) {
    wire::encode(rays[i], std::span(result.payload).subspan(i * wire::kRayBytes));
  }
  result.up_bytes = std::max<std::uint64_t>(result.payload.size(), 4);
  result.returns_rays = count > 0;
  result.leaves_nothing = true;
  return result;
}

}  // namespace gicube::emu
