// Rays of the host application, and pairs of elements: their rays are made by the board's DSP, or here and sent over the bus.
#include <algorithm>
#include <deque>
#include <ranges>
#include <string>

#include "encode/argument.h"
#include "encode/host_ray.h"
#include "encode/pairs.h"
#include "gicube/wire/command.h"
#include "gicube/wire/registers.h"
#include "state.h"

namespace gicube {
namespace {

constexpr std::size_t kRaysAtOnce = std::size_t{1} << 18;  // chosen: of a command, or of a batch
constexpr std::size_t kPairsAtOnce = 16'384;               // whose elements and answers fit a payload of 4 MB
constexpr std::size_t kUnderWay = 4;                       // chosen: so that bus and DSP don't wait for one another

std::size_t pairs_at_once(const PairRequest& request, std::size_t payload_bytes) {
  const std::size_t fitting = (payload_bytes - wire::kPairsHeaderBytes) / (wire::kPairBytes + 2 * wire::kElementBytes);
  return std::clamp<std::size_t>(kRaysAtOnce / request.rays, 1, std::min(kPairsAtOnce, fitting));
}

// The pairs that need no ray have their factors, the others are left.
struct Sorted {
  std::vector<PairFactor> factors;
  std::vector<ElementPair> left;
  std::vector<std::size_t> places;  // of those, among all
};

// Without leaping the board would look at voxels whose flags it was told to trust.
Sorted without_clear(std::span<const Element> elements, std::span<const ElementPair> pairs, const PairRequest& request,
                     const LoadedVolume& volume, int block_voxels, const View& sampling) {
  const BlockFlags flags{volume.blocks, block_voxels, volume.flags};
  const bool possible = sampling.leap && std::any_of(flags.empty.begin(), flags.empty.end(), [](auto f) { return f; });
  Sorted sorted;
  sorted.factors.resize(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (possible) {
      const wire::Element a = to_wire(elements[pairs[i].a]), b = to_wire(elements[pairs[i].b]);
      if (is_clear(a, b, flags, sampling.step)) {
        sorted.factors[i] = clear_factor(a, b, pairs[i].id, request, volume.relative_spacing);
        continue;
      }
    }
    sorted.left.push_back(pairs[i]);
    sorted.places.push_back(i);
  }
  return sorted;
}

// Has send(piece) begin the pairs piece by piece, which follow each other to the board while it works, and puts together the
// factors that take(sent) has of each. What was begun when something is thrown is given to forget(sent).
template <typename Send, typename Take, typename Forget>
std::vector<PairFactor> in_pieces(std::span<const ElementPair> pairs, std::size_t max_pairs, const Progress& progress,
                                  const Send& send, const Take& take, const Forget& forget) {
  const auto all = static_cast<std::uint32_t>(pairs.size());
  std::deque<std::invoke_result_t<Send, std::span<const ElementPair>>> sent;
  std::vector<PairFactor> factors;
  try {
    while (!pairs.empty() || !sent.empty()) {
      if (!pairs.empty()) {
        const auto piece = pairs.first(std::min(max_pairs, pairs.size()));
        pairs = pairs.subspan(piece.size());
        sent.push_back(send(piece));
        if (sent.size() <= kUnderWay) continue;
      }
      const std::vector<PairFactor> part = take(sent.front());
      sent.pop_front();
      factors.insert(factors.end(), part.begin(), part.end());
      if (progress) progress(static_cast<std::uint32_t>(factors.size()), all);
    }
  } catch (...) {
    for (const auto& left : sent) forget(left);
    throw;
  }
  return factors;
}

struct SentCommand {
  std::uint32_t command = 0;
  std::size_t pairs = 0;
};

std::vector<PairFactor> factors_of(Device& device, const SentCommand& sent) {
  const CommandResult result = device.finish(sent.command, {});
  if (result.error != wire::ErrorCode::kNone) throw_error(result.error, error_text(result.payload));
  if (result.payload.size() != sent.pairs * wire::kPairResultBytes) {
    device.give_up("the board returned " + std::to_string(result.payload.size()) + " bytes for " +
                   std::to_string(sent.pairs) + " pairs");
  }
  const std::span<const std::uint8_t> bytes(result.payload);
  std::vector<PairFactor> factors;
  for (std::size_t i = 0; i < sent.pairs; ++i) {
    factors.push_back(from_wire(wire::decode<wire::PairResult>(bytes.subspan(i * wire::kPairResultBytes))));
  }
  return factors;
}

}  // namespace

Ticket Board::State::submit(std::span<const std::span<const HostRay>> rays, const RayRequest& request,
                            std::vector<std::size_t> lines) {
  if (!info.host_rays) throw Unsupported("this board takes no host rays");
  check(request);
  const LoadedVolume& of = loaded("submit()");
  const bool deposits = request.type == RayType::kDeposit;
  if (deposits && irradiance_unit <= 0) {
    throw Rejected("rays that deposit need a unit of energy: clear_irradiance() or illuminate() first");
  }
  const bool backprojects = request.type == RayType::kBackproject, sums = request.words == SumWords::kSums;
  if (backprojects && (sums ? sum_unit : irradiance_unit) <= 0) {
    throw Rejected(std::string("rays that backproject need a unit of what they leave: ") +
                   (sums ? "clear_sums()" : "clear_irradiance()") + " first");
  }
  View sampled = sampling;
  if (request.step != 0) sampled.step = request.step;
  const RaySetup setup{request,
                       of.dims,
                       backprojects && sums ? sum_unit : irradiance_unit,
                       info.wide,
                       sampled,
                       sampling_towards_eye,
                       of.min_spacing * of.relative_spacing,
                       of.range};
  std::size_t index = 0;
  for (const HostRay& ray : rays | std::views::join) check(ray, index++, setup);
  set_sampling(sampled);
  if (deposits || backprojects) device.set_register(wire::reg::kSeed, sampling.seed);
  const bool gathers_colour = request.type == RayType::kIntegrate || request.type == RayType::kSegment;
  if (gathers_colour && sampling.shade) tables.send_reflectance(sampling_towards_eye);
  return batches.submit(rays, setup, std::move(lines));
}

Ticket Board::submit(std::span<const HostRay> rays, const RayRequest& request) {
  const auto lock = state_->begin();
  return state_->submit(std::span(&rays, 1), request, {});
}

Ticket Board::submit(std::span<const std::span<const HostRay>> rays, const RayRequest& request) {
  const auto lock = state_->begin();
  return state_->submit(rays, request, {});
}

Ticket Board::submit(std::span<const Polyline> lines) {
  const auto lock = state_->begin();
  const LoadedVolume& volume = state_->loaded("submit()");
  std::vector<HostRay> legs;
  std::vector<std::size_t> legs_of;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Polyline& line = lines[i];
    check(line, i, volume.dims);
    for (std::size_t p = 1; p < line.points.size(); ++p) {
      legs.push_back(ray_between(line.id, line.points[p - 1], line.points[p]));
    }
    legs_of.push_back(line.points.size() - 1);
  }
  const std::span<const HostRay> all(legs);
  return state_->submit(std::span(&all, 1), {.type = RayType::kSegment}, std::move(legs_of));
}

RayBatch Board::receive(Ticket ticket, Picoseconds deadline) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.receive(ticket, deadline);
}

BatchReport Board::receive(Ticket ticket, std::span<TracedRay> rays, Picoseconds deadline) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.receive(ticket, rays, deadline);
}

std::vector<RayBatch> Board::poll() {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.poll();
}

bool Board::cancel(Ticket ticket) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.cancel(ticket);
}

void Board::set_time_limit(Picoseconds limit) {
  const auto lock = state_->begin();
  state_->time_limit = limit;
}

std::vector<PairFactor> Board::pair_factors(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                            const PairRequest& request, const Progress& progress) {
  const auto lock = state_->begin();
  check(request);
  const LoadedVolume& volume = state_->loaded("pair_factors()");
  for (std::size_t i = 0; i < elements.size(); ++i) check(elements[i], i, volume.dims);
  for (std::size_t i = 0; i < pairs.size(); ++i) check(pairs[i], i, elements.size());
  Sorted sorted = without_clear(elements, pairs, request, volume, state_->info.block_voxels, state_->sampling);
  if (sorted.left.empty()) return std::move(sorted.factors);
  const auto clear = static_cast<std::uint32_t>(pairs.size() - sorted.left.size());
  const Progress given = state_->watched(progress);
  Progress of_all;
  if (given) of_all = [&](std::uint32_t done, std::uint32_t all) { given(done + clear, all + clear); };

  Device& device = state_->device;
  const std::size_t max_pairs = pairs_at_once(request, device.agreed().max_payload_bytes);
  std::vector<PairFactor> found;
  if (request.made == PairRays::kByBoard) {
    state_->set_sampling(state_->sampling);
    const auto send = [&](std::span<const ElementPair> piece) {
      return SentCommand{device.command(wire::share(pairs_command(elements, piece, request))), piece.size()};
    };
    found = in_pieces(
        sorted.left, max_pairs, of_all, send, [&](const SentCommand& sent) { return factors_of(device, sent); },
        [&](const SentCommand& sent) { device.forget(sent.command); });
  } else {
    using SentRays = std::pair<Ticket, std::vector<double>>;  // with their weights
    const auto send = [&](std::span<const ElementPair> piece) -> SentRays {
      PairRaysMade made = make_rays(elements, piece, request, volume.relative_spacing);
      const std::span<const HostRay> rays(made.rays);
      const RayRequest asked{.type = RayType::kOpacity, .opacity = request.opacity};
      return {state_->submit(std::span(&rays, 1), asked, {}), std::move(made.weights)};
    };
    const auto take = [&](const SentRays& sent) {
      return sum_up(sent.second, state_->batches.receive(sent.first, kNoDeadline).rays, request.rays);
    };
    found = in_pieces(sorted.left, max_pairs, of_all, send, take, [](const SentRays&) {});
  }
  for (std::size_t i = 0; i < found.size(); ++i) sorted.factors[sorted.places[i]] = found[i];
  return std::move(sorted.factors);
}

}  // namespace gicube
