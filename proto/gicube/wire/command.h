// DSP commands: the payload of kCommand frames, and of the completions that answer them.
//
// kRender: the DSP makes the viewing rays of one image and gathers them in the framebuffer; its completion is empty.
//
//   byte  size  field
//      0     4  opcode = 1
//      4     2  width, pixels        6  2  height, pixels
//      8     1  projection           0 orthographic, 1 perspective
//      9     1  samples_per_axis     1, 2 or 4: rays a pixel are its square
//     10     1  filter               0 box, 1 tent (two pixels wide)
//     11     1  reserved, 0
//     12     4  reserved, 0
//     16  4x24  origin, forward, du, dv: three doubles each, voxels
//
// Image point (x, y), pixels from the image's top left corner:
//   perspective   origin = origin,                 direction = forward + x du + y dv
//   orthographic  origin = origin + x du + y dv,   direction = forward
//
// kTrace: host rays in, host rays out in its completion, in the order in which they were sent.
//
//   byte  size  field
//      0     4  opcode = 2
//      4     4  count
//      8  32 n  ray packets (ray.h), kHostRay set
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

enum class Opcode : std::uint32_t { kRender = 1, kTrace = 2 };
enum class Projection : std::uint8_t { kOrthographic = 0, kPerspective = 1 };
enum class Filter : std::uint8_t { kBox = 0, kTent = 1 };

inline constexpr int kMaxImageSize = 4095;  // u, v are 12.4 pixels
inline constexpr std::size_t kRenderCommandBytes = 112;
inline constexpr std::size_t kTraceHeaderBytes = 8;

struct RenderCommand {
  std::uint16_t width = 0;
  std::uint16_t height = 0;
  Projection projection = Projection::kPerspective;
  std::uint8_t samples_per_axis = 1;
  Filter filter = Filter::kBox;
  std::array<double, 3> origin{};
  std::array<double, 3> forward{};
  std::array<double, 3> du{};
  std::array<double, 3> dv{};

  friend constexpr bool operator==(const RenderCommand&, const RenderCommand&) = default;
};

inline void encode(const RenderCommand& command, std::span<std::uint8_t, kRenderCommandBytes> out) {
  store(out, 0, static_cast<std::uint32_t>(Opcode::kRender));
  store(out, 4, command.width);
  store(out, 6, command.height);
  store(out, 8, static_cast<std::uint8_t>(command.projection));
  store(out, 9, command.samples_per_axis);
  store(out, 10, static_cast<std::uint8_t>(command.filter));
  store(out, 11, std::uint8_t{0});
  store(out, 12, std::uint32_t{0});
  const std::array<const std::array<double, 3>*, 4> vectors{&command.origin, &command.forward, &command.du,
                                                            &command.dv};
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) store_double(out, 16 + 24 * i + 8 * axis, (*vectors[i])[axis]);
  }
}

// The enumerations are taken as they come: the DSP checks every field's range and names the one that is wrong.
inline RenderCommand decode_render(std::span<const std::uint8_t, kRenderCommandBytes> in) {
  RenderCommand command;
  command.width = load<std::uint16_t>(in, 4);
  command.height = load<std::uint16_t>(in, 6);
  command.projection = static_cast<Projection>(load<std::uint8_t>(in, 8));
  command.samples_per_axis = load<std::uint8_t>(in, 9);
  command.filter = static_cast<Filter>(load<std::uint8_t>(in, 10));
  const std::array<std::array<double, 3>*, 4> vectors{&command.origin, &command.forward, &command.du, &command.dv};
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) (*vectors[i])[axis] = load_double(in, 16 + 24 * i + 8 * axis);
  }
  return command;
}

}  // namespace gicube::wire
