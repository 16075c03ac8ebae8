// A volume in the caller's memory, on its way to the board.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "gicube/vector.h"

namespace gicube {

// Samples are in the machine's byte order; kUint12 holds 0..4095 in 16 bits.
enum class SampleType { kUint8, kUint12, kUint16, kInt16, kFloat32 };

constexpr std::size_t bytes_per_sample(SampleType type) {
  switch (type) {
    case SampleType::kUint8: return 1;
    case SampleType::kUint12:
    case SampleType::kUint16:
    case SampleType::kInt16: return 2;
    case SampleType::kFloat32: return 4;
  }
  return 0;
}

// The map from values to the board's 12-bit density: round(4095 (v - low) / (high - low)), clamped. Low < high, both
// finite.
struct ValueRange {
  double low = 0;
  double high = 1;

  friend constexpr bool operator==(ValueRange, ValueRange) = default;
};

// A box of voxels: low[axis] .. low[axis] + size[axis] - 1.
struct VoxelBox {
  Dims low{};
  Dims size{};  // at least 1 each
};

// Does not own its memory: everything pointed to must live until load_volume() returns.
struct VolumeView {
  // dims[0] * dims[1] * dims[2] samples of `type`, x fastest: of a std::vector<float>,
  // std::as_bytes(std::span(values)).
  std::span<const std::byte> samples;
  SampleType type = SampleType::kUint8;
  Dims dims{};            // voxels, 2..1024 each; see Board::load_volume()
  Vec3 spacing{1, 1, 1};  // physical voxel edge, each within 64 of the smallest; the ratios count, and for
                          // line integrals and backprojection the lengths too
  // Unset: 0..255 for kUint8, 0..4095 for kUint12, the least and the greatest sample for the others. If all of these
  // are one value v, v..v + 1 (beyond 2^53: to the next larger number), so that every sample has density 0.
  std::optional<ValueRange> range{};
  // Empty: by a 3x3x3 Sobel filter. Else 3 floats per voxel, x fastest: the physical direction in which the value
  // grows; lengths are ignored, a zero vector is "no gradient".
  std::span<const float> gradients{};
  // Empty: tag 0 everywhere. Else one material tag, 0..3, per voxel.
  std::span<const std::uint8_t> tags{};
  // Empty: no colours. Else red, green and blue of each voxel, 255 = 1, for a card whose voxels have colours
  // (BoardInfo::voxel_format): factors of the transfer function's, by which the samples still give opacity. With
  // VoxelFormat::kRgba the samples are the colours' alpha, and colours are premultiplied by it before they are
  // interpolated.
  std::span<const std::uint8_t> colours{};
  // False, without `gradients`: no voxel gets a gradient, and nothing of the volume is shaded. For pictures with no
  // View::shade, where a third of load_volume()'s time would go into gradients.
  bool find_gradients = true;
};

// Reads the planes z = first .. first + planes - 1 into `out`: dims[0] * dims[1] * planes samples, or colours of three
// bytes, x fastest, in the machine's byte order. If it throws, the board keeps its volume.
using PlaneReader = std::function<void(int first, int planes, std::span<std::byte> out)>;

// A volume that is read while it is loaded: for one that is larger than the host's memory. Fields are those of
// VolumeView.
struct VolumeStream {
  PlaneReader read;  // called for all planes in order; twice for 16 bits and floats without a range
  SampleType type = SampleType::kUint8;
  Dims dims{};
  Vec3 spacing{1, 1, 1};
  std::optional<ValueRange> range{};
  bool find_gradients = true;
  PlaneReader read_colours{};  // empty: no colours. Else it is asked after `read`, for the same planes: 3 bytes a voxel
};

}  // namespace gicube
