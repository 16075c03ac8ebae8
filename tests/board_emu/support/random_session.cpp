#include "random_session.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gicube/wire/checksum.h"
#include "gicube/wire/counter_list.h"
#include "gicube/wire/forwarded_ray.h"
#include "gicube/wire/pair.h"

namespace gicube::emu {

namespace {

using wire::FrameType;
namespace reg = wire::reg;

constexpr std::array<int, 3> kSize{21, 18, 25};

std::string text_of(const char* what, std::uint64_t id, wire::ErrorCode error, std::uint64_t time_ps,
                    const std::vector<std::uint8_t>& payload) {
  const std::string text = error == wire::ErrorCode::kNone ? "" : std::string(payload.begin(), payload.end());
  return std::string(what) + ' ' + std::to_string(id) + " error " + std::to_string(static_cast<int>(error)) + " at " +
         std::to_string(time_ps) + ": " + std::to_string(payload.size()) + " bytes " +
         std::to_string(wire::crc32c(payload)) + ' ' + text;
}

// Counters without those of the emulator, which depend on observers and checkpoints.
std::vector<std::uint8_t> of_the_card(const std::vector<std::uint8_t>& payload) {
  auto counters = wire::decode_counters(payload);
  if (!counters) return payload;
  for (wire::Counter& counter : *counters) {
    if (counter.name.starts_with("emulator.")) counter.value = 0;
  }
  return wire::encode(*counters);
}

}  // namespace

TransactionResult RandomHost::send(Board& board, FrameType type, std::vector<std::uint8_t> payload) {
  wire::FrameHeader header;
  header.type = type;
  header.id = next_id_++;
  header.time_ps = now_ps_;
  Progress work;
  if (on_send_) on_send_(board, wire::kFrameHeaderBytes + payload.size());
  TransactionResult result = board.transact(header, payload, work);
  for (const Completion& completion : result.completions) {
    heard_.push_back(
        text_of("completion", completion.ticket, completion.error, completion.time_ps, completion.payload));
    std::erase(under_way_, completion.ticket);
    const bool light = std::ranges::find(lights_, completion.ticket) != lights_.end();
    if (completion.error == wire::ErrorCode::kNone) take_trapped(completion.payload, light);
  }
  if (result.reply) {
    const bool has_counters = type == FrameType::kCounters;
    heard_.push_back(text_of(has_counters ? "counters" : "reply", header.id, result.reply->error, result.reply->time_ps,
                             has_counters ? of_the_card(result.reply->payload) : result.reply->payload));
    now_ps_ = std::max(now_ps_, result.reply->time_ps);
  }
  return result;
}

void RandomHost::write_register(Board& board, std::uint32_t offset, std::uint32_t value) {
  std::vector<std::uint8_t> payload(8);
  wire::store(std::span(payload), 0, offset);
  wire::store(std::span(payload), 4, value);
  send(board, FrameType::kRegisterWrite, payload);
}

void RandomHost::write_memory(Board& board, std::uint64_t address, const std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint8_t> payload(8);
  wire::store(std::span(payload), 0, address);
  payload.insert(payload.end(), bytes.begin(), bytes.end());
  send(board, FrameType::kMemoryWrite, payload);
}

void RandomHost::read_memory(Board& board, std::uint64_t address, std::uint64_t length) {
  std::vector<std::uint8_t> payload(16);
  wire::store(std::span(payload), 0, address);
  wire::store(std::span(payload), 8, length);
  send(board, FrameType::kMemoryRead, payload);
}

void RandomHost::command(Board& board, const std::vector<std::uint8_t>& payload) {
  under_way_.push_back(next_id_);
  send(board, FrameType::kCommand, payload);
}

// The trap list is what is left at a completion's end; of other commands' completions nothing looks like one.
void RandomHost::take_trapped(const std::vector<std::uint8_t>& payload, bool light) {
  const std::size_t at = light ? wire::kLightingLedgerBytes : 0;
  if (payload.size() < at + wire::kTrapListHeaderBytes) return;
  const auto header = wire::decode<wire::TrapListHeader>(std::span(payload).subspan(at));
  const std::size_t first = at + wire::kTrapListHeaderBytes;
  if (payload.size() != first + header.count * wire::kTrappedRayBytes) return;
  for (std::size_t i = 0; i < header.count; ++i) {
    trapped_.push_back(wire::decode<wire::TrappedRay>(std::span(payload).subspan(first + i * wire::kTrappedRayBytes)));
  }
}

std::vector<std::uint8_t> RandomHost::block(Dice& dice) const {
  std::vector<std::uint8_t> bytes(wire::packed36_bytes(static_cast<std::size_t>(n_ * n_ * n_)));
  const int kind = dice.number(0, 3), peak = dice.number(300, 4095);
  for (int i = 0; i < n_ * n_ * n_; ++i) {
    const int x = i % n_ - n_ / 2, y = i / n_ % n_ - n_ / 2, z = i / n_ / n_ - n_ / 2;
    wire::Voxel voxel;
    voxel.density = static_cast<std::uint16_t>(std::clamp(peak - kind * 20 * (x * x + y * y + z * z), 0, 4095));
    voxel.gradient = static_cast<std::uint16_t>((x * 7 + y * 131 + z * 31 + 2048) % 2048);
    voxel.tag = static_cast<std::uint8_t>(kind);
    wire::store36(bytes, static_cast<std::size_t>(i), wire::to_word(voxel));
  }
  return bytes;
}

void RandomHost::begin(Board& board) {
  Dice dice(seed_);
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    write_register(board, reg::kVolumeX + 4 * axis, static_cast<std::uint32_t>(kSize[axis]));
  }
  std::vector<std::uint8_t> lut(wire::kSegmentationLut.bytes);
  const unsigned clear = static_cast<unsigned>(dice.number(200, 1500)),
                 slope = static_cast<unsigned>(dice.number(1, 16));
  for (unsigned i = 0; i < wire::kSegmentationEntries; ++i) {
    const unsigned density = i & 0xFFF;
    wire::SegmentationEntry entry;
    entry.opacity = static_cast<std::uint16_t>(density < clear ? 0 : std::min(65535u, (density - clear) * slope));
    entry.colour = {static_cast<std::uint16_t>(density), static_cast<std::uint16_t>(4095 - density), 1000};
    entry.ambient = 40;
    entry.knee = entry.reflect = 128;
    wire::encode(entry, std::span(lut).subspan(i * wire::kSegmentationEntryBytes));
  }
  write_memory(board, wire::kSegmentationLut.base, lut);
  std::vector<std::uint8_t> gradients(wire::kGradientLut.bytes);
  for (std::size_t i = 0; i < gradients.size(); ++i) gradients[i] = static_cast<std::uint8_t>(i * 37 + i / 256);
  write_memory(board, wire::kGradientLut.base, gradients);
  for (int tag = 1; tag < 4; ++tag) {
    wire::Material material;
    material.bsdf = dice.one_of({wire::Bsdf::kIsotropic, wire::Bsdf::kSpecular, wire::Bsdf::kTrap});
    material.flags = wire::kScattersRenderingRays;
    material.scattering = 40'000;
    material.gloss = 4096;
    material.routine = material.bsdf == wire::Bsdf::kTrap ? wire::kHostRoutine : std::uint8_t{0};
    std::vector<std::uint8_t> record(wire::kMaterialBytes);
    wire::encode(material, record);
    write_memory(board, wire::kMaterials.base + static_cast<std::uint64_t>(tag) * wire::kMaterialBytes, record);
  }
  write_register(board, reg::kLifetime, 4);
  for (std::uint64_t i = 0; i < 8; ++i) {
    if (dice.chance(80)) write_memory(board, wire::kVolume.base + i * block(dice).size(), block(dice));
    if (dice.chance(50)) {  // refused unless the card's voxels have colours, and the block is there
      const std::vector<std::uint8_t> colours(3u * static_cast<unsigned>(n_ * n_ * n_),
                                              static_cast<std::uint8_t>(dice.number(0, 255)));
      write_memory(board, wire::kColours.base + i * colours.size(), colours);
    }
  }
}

std::vector<std::uint8_t> RandomHost::render(Dice& dice) {
  wire::RenderCommand view = corner_view(kSize, dice.number(3, 14));
  view.samples_per_axis = dice.chance(20) ? 2 : 1;
  view.filter = dice.chance(30) ? wire::Filter::kTent : wire::Filter::kBox;
  std::vector<wire::Lamp> lamps(static_cast<std::size_t>(dice.one_of({0, 0, 2})));
  for (wire::Lamp& lamp : lamps) {
    lamp.kind = wire::LightKind::kSphere;
    lamp.colour = {65536, 30'000, 65536};
    lamp.position = {dice.number(-60, 60) + 0.3, 70.2, dice.number(-60, 60) + 0.1};
    lamp.u = {dice.number(10, 400) / 10.0, 0, 0};
  }
  view.lamps = static_cast<std::uint8_t>(lamps.size());
  if (dice.chance(20)) {
    view.strip_rows = static_cast<std::uint16_t>(dice.number(1, view.height / 2));
    view.part = static_cast<std::uint8_t>(dice.number(0, 1));
    view.parts = 2;
  }
  std::vector<std::uint8_t> payload(wire::kRenderCommandBytes);
  wire::encode(view, payload);
  for (const wire::Lamp& lamp : lamps) wire::append(payload, lamp);
  trapped_.clear();
  last_was_light_ = false;
  return payload;
}

std::vector<std::uint8_t> RandomHost::illuminate(Dice& dice) {
  wire::IlluminateCommand light;
  light.energy = 20'000.0 * dice.number(1, 20);
  light.rules = dice.chance(50) ? wire::EnergyRules::kAsPrinted : wire::EnergyRules::kConserving;
  light.position = {dice.number(0, kSize[0] - 2) + 0.5, dice.number(0, kSize[1] - 2) + 0.25, -7.5};
  trapped_.clear();
  last_was_light_ = true;
  return wire::encoded(light);
}

std::vector<std::uint8_t> RandomHost::trace(Dice& dice) {
  using enum wire::RayType;
  wire::TraceHeader header;
  header.type = dice.one_of({kIntegrate, kIntegrate, kFirstHit, kSegment, kOpacity, kDeposit, kIntegral, kBackproject});
  const bool deposit = header.type == kDeposit, backprojects = header.type == kBackproject;
  if (wire::has_threshold(header.type)) header.opacity = wire::kOpacityOne / 2;
  if (backprojects && dice.chance(60)) header.words = wire::SumWords::kWhole;
  std::vector<wire::Ray> rays;
  for (int i = dice.number(0, 40); i > 0; --i) {
    std::array<double, 3> position{}, direction{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = dice.number(0, (kSize[axis] - 1) * 100) / 100.0;
      direction[axis] = dice.number(-100, 100) + 0.5;
    }
    wire::Ray ray = host_ray(static_cast<std::uint32_t>(dice.number(0, 1 << 20)), position, direction);
    if (deposit) ray.flags |= wire::kLightingRay;
    if (deposit) ray.set_colour_word(static_cast<std::uint64_t>(dice.number(1, 200)) << 12);
    if (wire::is_segment(header.type)) ray.set_colour_word(static_cast<std::uint64_t>(dice.number(0, 20)) << 16);
    if (backprojects) ray.opacity = static_cast<std::uint32_t>(dice.number(0, 1 << 18));
    rays.push_back(ray);
  }
  return BareBoard::trace_payload(rays, header);
}

// Between patches, and parts of the volume.
std::vector<std::uint8_t> RandomHost::pairs(Dice& dice) const {
  wire::PairsHeader header;
  header.elements = 3;
  header.pairs = static_cast<std::uint32_t>(dice.number(0, 5));
  header.rays = static_cast<std::uint32_t>(dice.number(1, 40));
  header.seed = seed_;
  std::vector<std::uint8_t> payload;
  wire::append(payload, header);
  for (std::uint32_t i = 0; i < header.elements; ++i) {
    wire::Element element;
    element.kind = i == 0 ? wire::ElementKind::kBox : wire::ElementKind::kPatch;
    for (float& axis : element.origin) axis = static_cast<float>(dice.number(0, 100)) / 10;
    element.u = {3, 0, 1};
    element.v = {0, 4, 0};
    if (i == 0) element.w = {0, 0, 5};
    wire::append(payload, element);
  }
  for (std::uint32_t i = 0; i < header.pairs; ++i) {
    wire::append(payload, wire::Pair{i % 3, static_cast<std::uint32_t>(dice.number(0, 2)), i});
  }
  return payload;
}

// Answers some of the rays that wait for the host, and asks for more.
std::vector<std::uint8_t> RandomHost::resume(Dice& dice) {
  const auto count =
      static_cast<std::uint32_t>(std::min<std::size_t>(trapped_.size(), static_cast<std::size_t>(dice.number(0, 30))));
  std::vector<std::uint8_t> payload;
  wire::append(payload, wire::ResumeHeader{count, static_cast<std::uint32_t>(dice.number(0, 20))});
  for (std::uint32_t i = 0; i < count; ++i) {
    wire::Ray ray = trapped_[i].ray;
    std::swap(ray.direction[0], ray.direction[2]);
    ray.lifetime = std::max<std::uint16_t>(ray.lifetime, 1);
    wire::set_dropped_share(ray, wire::kOpacityOne / 4);
    wire::append(payload, ray);
  }
  trapped_.erase(trapped_.begin(), trapped_.begin() + count);
  if (last_was_light_) lights_.push_back(next_id_);
  return payload;
}

void RandomHost::change_memory(Board& board, Dice& dice) {
  const std::uint64_t block_bytes = block(dice).size();
  switch (dice.number(0, 6)) {
    case 0:
    case 1:
      return write_memory(board, wire::kVolume.base + block_bytes * static_cast<unsigned>(dice.number(0, 8)),
                          block(dice));
    case 2: {
      std::vector<std::uint8_t> words(64);
      for (std::uint8_t& byte : words) byte = static_cast<std::uint8_t>(dice.number(0, 255));
      return write_memory(board, wire::kIrradiance.base + 4u * static_cast<unsigned>(dice.number(0, 2000)), words);
    }
    case 3: return write_memory(board, wire::kEmptyFlags.base, {static_cast<std::uint8_t>(dice.number(0, 255))});
    case 4: {
      const int absent = dice.chance(70) ? 0 : dice.number(0, 255);
      const auto& flags = dice.chance(30) ? wire::kDarkFlags : wire::kAbsentFlags;
      return write_memory(board, flags.base, {static_cast<std::uint8_t>(absent)});
    }
    case 5: {
      const MemoryError error{static_cast<std::uint32_t>(dice.number(0, 9)),
                              static_cast<std::uint32_t>(dice.number(0, 9999)), dice.chance(30)};
      return board.add_memory_error(error);
    }
    default: {
      if (dice.chance(30)) return write_register(board, reg::kDropBlock, static_cast<std::uint32_t>(dice.number(0, 9)));
      const auto bits = dice.one_of({wire::kControlClearIrradiance, wire::kControlClearSums, wire::kControlDropBlocks,
                                     wire::kControlDropRays, wire::kControlClearVolume});
      return write_register(board, reg::kControl, bits);
    }
  }
}

void RandomHost::wait_for_one(Board& board, Dice& dice) {
  if (under_way_.empty()) return static_cast<void>(send(board, FrameType::kPoll, {}));
  const auto which = static_cast<std::size_t>(dice.number(0, static_cast<int>(under_way_.size()) - 1));
  std::vector<std::uint8_t> payload(4);
  wire::store(std::span(payload), 0, under_way_[which]);
  send(board, dice.chance(15) ? FrameType::kCancel : FrameType::kWait, payload);
}

void RandomHost::end(Board& board) {
  while (!under_way_.empty()) {
    std::vector<std::uint8_t> payload(4);
    wire::store(std::span(payload), 0, under_way_.front());
    send(board, FrameType::kWait, payload);
  }
  send(board, FrameType::kCounters, {});
}

void RandomHost::read_memories(Board& board) {
  std::uint64_t voxels = 1;
  for (const int edge : kSize) voxels *= static_cast<std::uint64_t>((edge + n_ - 1) / n_ * n_);
  read_memory(board, wire::kVolume.base, voxels * 9 / 2);
  read_memory(board, wire::kSums.base, voxels * 9 / 2);
  for (std::size_t word = 0; word < 3; ++word) {
    read_memory(board, wire::irradiance_region(word).base, voxels * wire::kIrradianceBytes);
  }
  read_memory(board, wire::kFramebuffer.base, 36);
}

void RandomHost::step(Board& board) {
  Dice dice(seed_ * 1000 + ++steps_);
  now_ps_ += static_cast<std::uint64_t>(dice.number(0, 40)) * 1'000'000;
  switch (dice.number(0, 14)) {
    case 0:
    case 1: return command(board, render(dice));
    case 2: {
      lights_.push_back(next_id_);
      return command(board, illuminate(dice));
    }
    case 3:
    case 4: return command(board, trace(dice));
    case 5: return command(board, resume(dice));
    case 6: {
      if (dice.chance(60)) return command(board, wire::encoded(wire::ContinueCommand{}));
      const auto ended = static_cast<std::uint8_t>(dice.number(0, 1));
      return command(board, wire::encoded(wire::TakeRaysHeader{.max_rays = 50, .ended = ended}));
    }
    case 7: {
      const auto bits = static_cast<std::uint32_t>(dice.number(0, static_cast<int>(wire::kPipelineBits)));
      return write_register(board, reg::kPipeline, dice.chance(50) ? bits & 7 : bits);
    }
    case 8: {
      write_register(board, reg::kStep, static_cast<std::uint32_t>(dice.one_of({20'000, 65'536, 150'000})));
      return write_register(board, reg::kOpacityThreshold,
                            wire::kOpacityOne / static_cast<unsigned>(dice.number(1, 3)));
    }
    case 9:
    case 10: return change_memory(board, dice);
    case 11:
      return read_memory(board, dice.one_of({wire::kFramebuffer.base, wire::kSums.base, wire::kIrradiance.base}), 36);
    case 12: return static_cast<void>(send(board, FrameType::kCounters, {}));
    case 13: return command(board, pairs(dice));
    default: return wait_for_one(board, dice);
  }
}

}  // namespace gicube::emu
