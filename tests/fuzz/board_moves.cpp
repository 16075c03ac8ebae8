#include "board_moves.h"

#include "gicube/wire/forwarded_ray.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/material.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/registers.h"

namespace gicube::fuzz {
namespace {

using wire::FrameType;
namespace reg = wire::reg;

template <typename... Numbers>
std::vector<std::uint8_t> packed(Numbers... numbers) {
  std::vector<std::uint8_t> bytes((sizeof(Numbers) + ... + 0));
  std::size_t at = 0;
  ((wire::store(std::span(bytes), at, numbers), at += sizeof(Numbers)), ...);
  return bytes;
}

Move move_of(FrameType type, std::uint32_t id, std::vector<std::uint8_t> payload) {
  Move move;
  move.header.type = type;
  move.header.id = id;
  const bool posted =
      type == FrameType::kRegisterWrite || type == FrameType::kMemoryWrite || type == FrameType::kCommand;
  move.header.flags = posted ? std::uint16_t{wire::kPosted} : std::uint16_t{0};
  move.payload = std::move(payload);
  return move;
}

Move write_register(std::uint32_t id, std::uint32_t offset, std::uint32_t value) {
  return move_of(FrameType::kRegisterWrite, id, packed(offset, value));
}

Move write_memory(std::uint32_t id, std::uint64_t address, const std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint8_t> payload = packed(address);
  payload.insert(payload.end(), bytes.begin(), bytes.end());
  return move_of(FrameType::kMemoryWrite, id, std::move(payload));
}

// Values near the ends of what registers take, and some between.
std::uint32_t register_value(Input& input) {
  static constexpr std::array<std::uint32_t, 12> kTelling{
      0, 1, 2, 8, 12, 31, 32, 33, wire::kStepOne, wire::kStepMin, wire::kStepMax, ~0u};
  const std::uint8_t kind = input.u8();
  return kind < kTelling.size() ? kTelling[kind] : kind == 255 ? input.u32() : kind * (wire::kStepOne / 64);
}

Move any_register(Input& input, std::uint32_t id) {
  const wire::RegisterInfo& which = wire::kRegisterTable[input.u8() % wire::kRegisterTable.size()];
  std::uint32_t value = register_value(input);
  if (which.offset == reg::kLifetime) value %= 8;  // longer lives are only longer
  return write_register(id, which.offset, value);
}

std::uint64_t address_of(Input& input) {
  const wire::MemoryRegion& region = wire::kMemoryMap[input.u8() % wire::kMemoryMap.size()];
  return region.base + (input.u8() == 255 ? input.u64() : std::uint64_t{input.u16()});
}

// All visible, in steps of opacity from density to density.
std::vector<std::uint8_t> segmentation(std::uint8_t slope) {
  std::vector<std::uint8_t> bytes(wire::kSegmentationLut.bytes);
  for (unsigned i = 0; i < wire::kSegmentationEntries; ++i) {
    const unsigned density = i & 0xFFF;
    wire::SegmentationEntry entry;
    entry.colour = {static_cast<std::uint16_t>(density), 4095, static_cast<std::uint16_t>(4095 - density)};
    entry.opacity = static_cast<std::uint16_t>(std::min(density * (slope + 1u) / 16, 65535u));
    wire::encode(entry, std::span(bytes).subspan(i * wire::kSegmentationEntryBytes));
  }
  return bytes;
}

// One block of 8^3 voxels.
std::vector<std::uint8_t> block(std::uint8_t seed) {
  std::vector<std::uint8_t> bytes(512 * 9 / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 37 + seed * 101 + (i >> 5));
  return bytes;
}

Move material(Input& input, std::uint32_t id) {
  wire::Material record;
  record.bsdf = static_cast<wire::Bsdf>(input.u8() % 8);
  record.flags = input.u8();
  record.scattering = input.u16();
  record.gloss = input.u16();
  record.routine = static_cast<std::uint8_t>(input.below(10) == 9 ? wire::kHostRoutine : input.u8() % 9);
  record.parameter_count = static_cast<std::uint8_t>(input.u8() % 34);
  for (std::size_t i = 0; i < record.parameter_count && i < record.parameters.size(); ++i) {
    record.parameters[i] = static_cast<float>(std::clamp(input.number(), -3e38, 3e38));
  }
  std::vector<std::uint8_t> bytes(wire::kMaterialBytes);
  wire::encode(record, bytes);
  return write_memory(id, wire::kMaterials.base + wire::kMaterialBytes * input.below(wire::kTags), bytes);
}

void put_vector(Input& input, std::array<double, 3>& vector) {
  for (double& component : vector) component = input.number();
}

wire::RenderCommand known_view() {
  wire::RenderCommand view;
  view.width = view.height = 4;
  view.origin = {4, 4, -12};
  view.forward = {-0.5, -0.5, 1};
  view.du = {0.25, 0, 0};
  view.dv = {0, 0.25, 0};
  return view;
}

std::vector<std::uint8_t> payload_of(const wire::RenderCommand& view) {
  std::vector<std::uint8_t> payload(wire::kRenderCommandBytes);
  wire::encode(view, payload);
  return payload;
}

std::vector<std::uint8_t> payload_of(const wire::IlluminateCommand& light) {
  std::vector<std::uint8_t> payload(wire::kIlluminateCommandBytes);
  wire::encode(light, payload);
  return payload;
}

std::vector<std::uint8_t> render(Input& input) {
  wire::RenderCommand view = known_view();
  const std::uint8_t kind = input.u8();
  if (kind & 1) view.width = input.u8() == 255 ? input.u16() : static_cast<std::uint16_t>(input.u8() % 12);
  if (kind & 2) {
    view.height = static_cast<std::uint16_t>(input.u8() % 12);
    view.parts = input.u8() % 4;
    view.part = input.u8() % 4;
    view.strip_rows = input.u8() % 8;
  }
  if (kind & 4) view.projection = static_cast<wire::Projection>(input.u8() % 3);
  if (kind & 8) view.samples_per_axis = static_cast<std::uint8_t>(input.u8() % 5);
  if (kind & 8) view.filter = static_cast<wire::Filter>(input.u8() % 3);
  const std::uint8_t lamps = kind & 16 ? input.u8() : std::uint8_t{0};  // from 200 on: a count without records
  view.lamps = lamps % 40;
  if (kind & 16) put_vector(input, view.origin);
  if (kind & 32) put_vector(input, view.forward);
  if (kind & 64) put_vector(input, view.du);
  if (kind & 128) put_vector(input, view.dv);
  std::vector<std::uint8_t> payload = payload_of(view);
  for (int i = 0; lamps < 200 && i < view.lamps; ++i) {
    wire::Lamp lamp{.kind = static_cast<wire::LightKind>(1 + input.u8() % 4), .colour = {input.u32(), 65536, 0}};
    put_vector(input, lamp.position);
    put_vector(input, lamp.u);
    put_vector(input, lamp.v);
    wire::append(payload, lamp);
  }
  return payload;
}

std::vector<std::uint8_t> illuminate(Input& input) {
  wire::IlluminateCommand light;
  light.kind = static_cast<wire::LightKind>(input.u8() % 5);
  light.albedo = static_cast<wire::Albedo>(input.u8() % 3);
  light.rules = static_cast<wire::EnergyRules>(input.u8() % 3);
  light.rays_per_voxel = input.u8() == 255 ? input.u32() : 1;
  light.first = input.u8() == 255 ? input.u32() : 0;
  light.count = input.u8() == 255 ? input.u32() : 1;
  light.energy = input.number() * 1000;
  put_vector(input, light.position);
  put_vector(input, light.u);
  put_vector(input, light.v);
  return payload_of(light);
}

// A command's head as it stands in the input, with ray packets behind it that are a host's own.
std::vector<std::uint8_t> rays(Input& input, wire::Opcode opcode) {
  const std::uint32_t count = input.below(6);
  const std::size_t head = opcode == wire::Opcode::kTrace ? wire::kTraceHeaderBytes : wire::kResumeHeaderBytes;
  std::vector<std::uint8_t> payload = input.bytes(head);
  payload.resize(head);
  wire::store(std::span(payload), 0, static_cast<std::uint32_t>(opcode));
  wire::store(std::span(payload), 4, count);
  if (opcode == wire::Opcode::kTrace && head > 11) {
    payload[8] %= 8;  // ray types
    payload[9] %= 3;
    payload[10] %= 3;
    const bool backprojects = payload[8] == static_cast<std::uint8_t>(wire::RayType::kBackproject);
    payload[11] = backprojects ? payload[11] % 3 : payload[11] == 255 ? 1 : 0;  // which words
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    std::vector<std::uint8_t> packet = input.bytes(wire::kRayBytes);
    packet.resize(wire::kRayBytes);
    wire::Ray ray = wire::decode<wire::Ray>(packet);
    if (input.u8() != 255) {
      ray.flags =
          opcode == wire::Opcode::kTrace && payload[8] == 4 ? wire::kHostRay | wire::kLightingRay : wire::kHostRay;
      for (std::uint32_t& coordinate : ray.position) coordinate %= 8 * wire::kVoxel;
    }
    wire::encode(ray, packet);
    payload.insert(payload.end(), packet.begin(), packet.end());
  }
  return payload;
}

// Rays of another card, of which some could go on.
std::vector<std::uint8_t> given_rays(Input& input) {
  wire::GiveRaysHeader header{.rays = input.below(4), .of = static_cast<wire::RaysOf>(input.u8() % 4)};
  header.trace.type = static_cast<wire::RayType>(input.u8() % 8);
  header.trace.rules = static_cast<wire::EnergyRules>(input.u8() % 3);
  std::vector<std::uint8_t> payload = wire::encoded(header);
  for (std::uint32_t i = 0; i < header.rays; ++i) {
    std::vector<std::uint8_t> record = input.bytes(wire::kForwardedRayBytes);
    record.resize(wire::kForwardedRayBytes);
    auto ray = wire::decode<wire::ForwardedRay>(record);
    if (input.u8() != 255) {
      ray.block %= 8;
      for (std::int32_t& coordinate : ray.position) coordinate &= 8 * wire::kVoxel - 1;
      ray.opacity &= wire::kOpacityOne;
      ray.generation &= 15;
      ray.under_way &= 1;
      ray.trapped &= 1;
      for (std::uint16_t& colour : ray.colour) colour &= wire::kColourOne;
      ray.wide = {};
    }
    wire::append(payload, ray);
  }
  return payload;
}

std::vector<std::uint8_t> any_command(Input& input) {
  switch (input.u8() % 6) {
    case 0: return render(input);
    case 1: return illuminate(input);
    case 2: return rays(input, wire::Opcode::kTrace);
    case 3: return rays(input, wire::Opcode::kResume);
    case 4: {
      std::vector<std::uint8_t> payload = input.bytes(input.u8());
      if (payload.size() < 4) return payload;
      const std::uint32_t opcode = payload[0] % 11u;
      if (opcode == static_cast<std::uint32_t>(wire::Opcode::kGiveRays)) return given_rays(input);
      wire::store(std::span(payload), 0, opcode);
      return payload;
    }
    default: return payload_of(known_view());
  }
}

}  // namespace

Move next_move(Input& input, std::uint32_t id) {
  switch (input.u8() % 18) {
    case 0:
    case 1: return any_register(input, id);
    case 2: return write_memory(id, address_of(input), input.bytes(input.u8()));
    case 3: return move_of(FrameType::kMemoryRead, id, packed(address_of(input), std::uint64_t{input.u16()}));
    case 4:
    case 5:
    case 6: return move_of(FrameType::kCommand, id, any_command(input));
    case 7: return move_of(FrameType::kWait, id, packed(id - input.below(4)));
    case 8: return move_of(FrameType::kWait, id, packed(id - 1, input.u64()));  // with a deadline
    case 9: return move_of(FrameType::kPoll, id, {});
    case 10: return move_of(FrameType::kCounters, id, {});
    case 11: return write_memory(id, wire::kSegmentationLut.base, segmentation(input.u8()));
    case 12: return write_memory(id, wire::kVolume.base + 2304 * std::uint64_t{input.below(9)}, block(input.u8()));
    case 13: return material(input, id);
    case 14: return write_register(id, reg::kVolumeX + 4 * input.below(3), 2 + input.below(15));
    case 15: return move_of(static_cast<FrameType>(3 + input.below(16)), id, packed(id - input.below(4)));
    case 16: {
      Move move = move_of(FrameType::kPoll, id, {});
      move.header.time_ps = input.u64();
      return move;
    }
    default: {
      Move move = move_of(static_cast<FrameType>(3 + input.below(16)), input.u32(), {});
      move.payload = input.bytes(input.u8());
      return move;
    }
  }
}

std::vector<Move> known_moves() {
  std::vector<Move> moves;
  std::uint32_t id = 1;
  for (const std::uint32_t edge : {reg::kVolumeX, reg::kVolumeY, reg::kVolumeZ}) {
    moves.push_back(write_register(id++, edge, 8));
  }
  moves.push_back(write_memory(id++, wire::kSegmentationLut.base, segmentation(3)));
  moves.push_back(write_memory(id++, wire::kVolume.base, block(1)));
  moves.push_back(move_of(FrameType::kCommand, id, payload_of(known_view())));
  moves.push_back(move_of(FrameType::kWait, id + 1, packed(id)));
  id += 2;
  moves.push_back(move_of(FrameType::kMemoryRead, id++, packed(wire::kFramebuffer.base, std::uint64_t{16 * 9 / 2})));
  wire::IlluminateCommand light;
  light.energy = 10'000;
  light.position = {3.5, 3.5, -5};
  moves.push_back(move_of(FrameType::kCommand, id, payload_of(light)));
  moves.push_back(move_of(FrameType::kWait, id + 1, packed(id)));
  moves.push_back(move_of(FrameType::kMemoryRead, id + 2, packed(wire::kIrradiance.base, std::uint64_t{512 * 4})));
  moves.push_back(move_of(FrameType::kRegisterRead, id + 3, packed(std::uint32_t{reg::kStatus})));
  return moves;
}

}  // namespace gicube::fuzz
