// A machine with a volume and tables, without bus and board, for tests: the same scene through the functional level and
// through machines of any configuration.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cycle/machine.h"
#include "cycle/machine_counters.h"
#include "datapath/ray_interval.h"
#include "firmware/lamps.h"
#include "firmware/ray_sources/host_rays.h"
#include "firmware/viewing_runs.h"
#include "functional/functional_level.h"
#include "gicube/wire/registers.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {

// The resolved design point with assignments such as "asic.processors=2" applied.
v1::BoardConfig config_with(const std::vector<std::string>& assignments);

// A small scene in the frame's words. Tables live here, so a scene does not move.
struct Scene {
  Scene(const std::array<int, 3>& size, int block_voxels, wire::VoxelFormat format = wire::VoxelFormat::kDensity);
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  template <typename Field>
  void fill(const Field& voxel_at) {
    const auto n = static_cast<std::size_t>(volume.block_voxels());
    const std::size_t block_bytes = wire::packed36_bytes(n * n * n);
    for (std::size_t block = 0; block < volume.block_count(); ++block) {
      const std::size_t nx = static_cast<std::size_t>(volume.blocks()[0]),
                        ny = static_cast<std::size_t>(volume.blocks()[1]);
      const std::array<std::size_t, 3> low{block % nx * n, block / nx % ny * n, block / (nx * ny) * n};
      std::vector<std::uint8_t> bytes(block_bytes);
      for (std::size_t i = 0; i < n * n * n; ++i) {
        const std::array<int, 3> at{static_cast<int>(low[0] + i % n), static_cast<int>(low[1] + i / n % n),
                                    static_cast<int>(low[2] + i / (n * n))};
        if (at[0] >= volume.size()[0] || at[1] >= volume.size()[1] || at[2] >= volume.size()[2]) continue;
        wire::store36(bytes, i, wire::to_word(voxel_at(at[0], at[1], at[2])));
      }
      volume.write(block * block_bytes, bytes);
    }
    volume.decode(gradients, true, 1);
  }

  // The colours of all voxels of a volume that was filled and whose format has some.
  template <typename Field>
  void paint(const Field& colour_at) {
    const auto n = static_cast<std::size_t>(volume.block_voxels());
    const auto nx = static_cast<std::size_t>(volume.blocks()[0]), ny = static_cast<std::size_t>(volume.blocks()[1]);
    std::vector<std::uint8_t> bytes(volume.colours().block_bytes());
    for (std::size_t block = 0; block < volume.block_count(); ++block) {
      for (std::size_t i = 0; i < n * n * n; ++i) {
        const std::array<std::uint8_t, 3> colour =
            colour_at(static_cast<int>(block % nx * n + i % n), static_cast<int>(block / nx % ny * n + i / n % n),
                      static_cast<int>(block / (nx * ny) * n + i / (n * n)));
        std::copy(colour.begin(), colour.end(), bytes.begin() + static_cast<std::ptrdiff_t>(3 * i));
      }
      volume.write_colours(block * bytes.size(), bytes);
    }
    volume.decode(gradients, false, 1, {.colours = true});
  }

  // The wide datapath, for the segmentation as it is now.
  void widen() {
    wide_depths = emu::wide_depths(segmentation);
    frame.wide = true;
    frame.wide_depths = wide_depths;
  }

  // What lighting rays need of the segmentation as it is now.
  void set_depths();

  VolumeMemory volume;
  std::optional<DepthTable> depths;
  std::vector<wire::GradientEntry> gradients;
  std::vector<wire::SegmentationEntry> segmentation;
  std::vector<std::uint8_t> reflectance_map;
  std::vector<float> wide_depths;
  OpacityCorrection opacity_correction;
  Frame frame;
};

struct Picture {
  std::vector<std::uint8_t> pixels;
  RayCounters rays;
  RunResult ran;  // of the cycle level
};

// By the functional level, one ray after the other.
RunResult run_functional(RaySource& rays, const Frame& frame, unsigned threads = 1);
Picture functional_picture(const Scene& scene, const wire::RenderCommand& view, const RunRules& runs = {},
                           const Lamps& lamps = {});
Picture cycle_picture(const Scene& scene, const wire::RenderCommand& view, Machine& machine, const RunRules& runs = {},
                      const Lamps& lamps = {});
RunRules runs_of(const v1::BoardConfig& config);

// The same by a machine that has the values computed ahead, if the frame's can be; in mid run a checkpoint is taken if
// `saves`.
Picture ahead_picture(const Scene& scene, const wire::RenderCommand& view, Machine& machine, const RunRules& runs,
                      bool saves);

// Host rays, in place.
RayCounters trace_functional(std::span<wire::Ray> rays, const Frame& frame);
RunResult trace_cycle(std::span<wire::Ray> rays, const Frame& frame, Machine& machine);

}  // namespace gicube::emu
