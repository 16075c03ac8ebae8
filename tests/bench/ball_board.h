// The scene of the rendering benchmarks: a shaded ball in clear air, 256^3, by a board of either level.
#pragma once

#include <algorithm>
#include <cmath>

#include "bare_board.h"

namespace gicube::emu {

inline constexpr int kBallSize = 256;

// With gradients, so that most rays sample air and some gather; the shape of a usual scene.
inline wire::Voxel ball(int x, int y, int z) {
  const double dx = x - 127.5, dy = y - 127.5, dz = z - 127.5, r = std::sqrt(dx * dx + dy * dy + dz * dz);
  const double density = std::clamp((100 - r) / 4 + 0.5, 0.0, 1.0) * 4095;
  const auto code = static_cast<std::uint16_t>(1 + (x * 7 + y * 5 + z * 3) % 2000);
  return {static_cast<std::uint16_t>(density), density > 0 ? code : wire::kNoGradient, 0, 0};
}

class BallBoard : public BareBoard {
 public:
  explicit BallBoard(const v1::BoardConfig& config) : BareBoard(config) {
    load_volume({kBallSize, kBallSize, kBallSize}, ball);
    std::vector<std::uint8_t> gradients(wire::kGradientLut.bytes);
    for (std::size_t i = 1; i < wire::kGradientCodes; ++i) {
      const double a = static_cast<double>(i) * 2.4, z = 1 - static_cast<double>(i) / 1024, r = std::sqrt(1 - z * z);
      const wire::GradientEntry g{static_cast<std::int16_t>(511 * r * std::cos(a)),
                                  static_cast<std::int16_t>(511 * r * std::sin(a)), static_cast<std::int16_t>(511 * z)};
      wire::store(std::span(gradients), 4 * i, wire::to_word(g));
    }
    write_memory(wire::kGradientLut.base, gradients);
    write_memory(wire::kReflectanceMap.base, std::vector<std::uint8_t>(wire::kReflectanceBytes, 100));
    write_register(wire::reg::kStep, wire::kStepOne / 2);
    write_register(wire::reg::kOpacityThreshold, wire::kOpacityOne / 50 * 49);
    flag_empty_blocks(static_cast<int>(config.asic().block_voxels()));
  }

  void flag_empty_blocks(int n) {
    const int across = kBallSize / n;
    std::vector<std::uint8_t> flags(static_cast<std::size_t>(across * across * across) / 8);
    for (int block = 0; block < across * across * across; ++block) {
      // The voxel of the block, or of its +1 faces, that is nearest the centre.
      const auto nearest = [n](int low) { return std::clamp(127, low, low + n); };
      const wire::Voxel voxel = ball(nearest(block % across * n), nearest(block / across % across * n),
                                     nearest(block / (across * across) * n));
      if (voxel.density == 0) flags[static_cast<std::size_t>(block) / 8] |= static_cast<std::uint8_t>(1 << (block % 8));
    }
    write_memory(wire::kEmptyFlags.base, flags);
  }

  // `opacity` per voxel in 1/65535, above half density.
  void set_opacity(std::uint16_t opacity) {
    write_segmentation([opacity](unsigned, unsigned density) {
      return wire::SegmentationEntry{{4095, 3000, 2000}, density > 2048 ? opacity : std::uint16_t{0}};
    });
  }
};

}  // namespace gicube::emu
