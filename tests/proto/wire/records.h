// Random records for property tests, every field within its width.
#pragma once

#include <rapidcheck.h>

#include <array>
#include <cstdint>

#include "gicube/wire/command.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"

namespace gicube::wire {

// An unsigned number of `width` bits; its ends are as likely as all between.
template <typename T>
T any_bits(unsigned width) {
  const std::uint64_t top = width == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << width) - 1;
  const auto middle = rc::gen::map(rc::gen::arbitrary<std::uint64_t>(), [top](std::uint64_t v) { return v & top; });
  return static_cast<T>(*rc::gen::weightedOneOf<std::uint64_t>(
      {{6, rc::gen::noShrink(middle)}, {1, rc::gen::just(top)}, {1, rc::gen::just(std::uint64_t{0})}}));
}

inline Ray any_ray() {
  Ray ray;
  ray.u = any_bits<std::uint16_t>(16);
  ray.v = any_bits<std::uint16_t>(16);
  for (auto& p : ray.position) p = any_bits<std::uint32_t>(24);
  for (auto& d : ray.direction) d = any_bits<std::int16_t>(16);
  for (auto& c : ray.colour) c = any_bits<std::uint16_t>(12);
  ray.opacity = any_bits<std::uint32_t>(24);
  ray.contribution = any_bits<std::uint16_t>(12);
  ray.lifetime = any_bits<std::uint16_t>(10);
  ray.generation = any_bits<std::uint8_t>(4);
  ray.interaction = any_bits<std::uint16_t>(12);
  ray.flags = any_bits<std::uint8_t>(6);
  return ray;
}

inline Voxel any_voxel() {
  return {any_bits<std::uint16_t>(12), any_bits<std::uint16_t>(11), any_bits<std::uint8_t>(2),
          any_bits<std::uint16_t>(11)};
}

inline SegmentationEntry any_segmentation() {
  SegmentationEntry entry;
  for (auto& c : entry.colour) c = any_bits<std::uint16_t>(12);
  entry.opacity = any_bits<std::uint16_t>(16);
  entry.ambient = any_bits<std::uint8_t>(8);
  entry.reflect = any_bits<std::uint8_t>(8);
  entry.knee = any_bits<std::uint8_t>(8);
  return entry;
}

inline FrameHeader any_header() {
  FrameHeader header;
  header.type = static_cast<FrameType>(*rc::gen::inRange(1, 17));
  header.flags = any_bits<std::uint16_t>(16);
  header.id = any_bits<std::uint32_t>(32);
  header.size = any_bits<std::uint32_t>(32);
  header.error = static_cast<ErrorCode>(*rc::gen::inRange(0, 15));
  header.credit_slots = any_bits<std::uint32_t>(32);
  header.time_ps = any_bits<std::uint64_t>(64);
  header.credit_bytes = any_bits<std::uint64_t>(64);
  header.sequence = any_bits<std::uint32_t>(32);
  header.checksum = any_bits<std::uint32_t>(32);
  return header;
}

inline VersionInfo any_version() {
  return {any_bits<std::uint16_t>(16), any_bits<std::uint16_t>(16), any_bits<std::uint32_t>(32),
          any_bits<std::uint32_t>(32), any_bits<std::uint64_t>(64), any_bits<std::uint64_t>(64),
          any_bits<std::uint32_t>(32), any_bits<std::uint64_t>(64), any_bits<std::uint32_t>(32),
          any_bits<std::uint32_t>(32), any_bits<std::uint32_t>(32)};
}

inline Lamp any_lamp() {
  Lamp lamp{.kind = static_cast<LightKind>(any_bits<std::uint8_t>(8)),
            .colour = {any_bits<std::uint32_t>(32), any_bits<std::uint32_t>(32), any_bits<std::uint32_t>(32)}};
  for (auto* vector : {&lamp.position, &lamp.u, &lamp.v}) {
    for (double& x : *vector) x = *rc::gen::arbitrary<double>();
  }
  return lamp;
}

inline RenderCommand any_render() {
  RenderCommand command;
  command.width = any_bits<std::uint16_t>(16);
  command.height = any_bits<std::uint16_t>(16);
  command.projection = static_cast<Projection>(any_bits<std::uint8_t>(1));
  command.samples_per_axis = any_bits<std::uint8_t>(8);
  command.filter = static_cast<Filter>(any_bits<std::uint8_t>(1));
  command.lamps = any_bits<std::uint8_t>(8);
  command.strip_rows = any_bits<std::uint16_t>(16);
  command.part = any_bits<std::uint8_t>(8);
  command.parts = any_bits<std::uint8_t>(8);
  for (auto* vector : {&command.origin, &command.forward, &command.du, &command.dv}) {
    for (double& x : *vector) x = *rc::gen::arbitrary<double>();
  }
  return command;
}

}  // namespace gicube::wire
