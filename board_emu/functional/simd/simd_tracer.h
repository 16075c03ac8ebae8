// Traces groups of rays, one ray per lane of the host's vectors: gathering rays from start to end, lighting and
// scattered rays between the samples after which they do more than continue. The bits are those of integrate() and of
// integrate_all() for each ray (tests/board_emu/functional/simd).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "datapath/frame.h"
#include "datapath/jitter.h"
#include "datapath/opacity_correction.h"
#include "functional/simd/cell_ranges.h"
#include "functional/simd/irradiance_copy.h"
#include "gicube/wire/ray.h"
#include "memory/large_array.h"

namespace gicube::emu {

struct TracedPath;

// The frame's tables in the form for lanes.
struct PacketTables {
  std::array<std::uint32_t, wire::kSegmentationEntries> depth{};  // per voxel length, 8.24 in base 2; all ones: opaque
  std::vector<std::uint32_t> alpha;  // 1 + the corrected opacity, 24 bits, or the bits of the wide one; 0: invisible
  std::array<std::uint64_t, wire::kSegmentationEntries>
      shading{};  // red, green 12 bits, ambient 8; in bits 32..: blue 12, reflect, knee 8
  std::array<std::uint64_t, OpacityCorrection::kSegments> exp2{};  // value, and in bits 32.. the decrease to the next
  std::vector<std::uint8_t> specular;                              // for lit samples; empty if all are 0
  std::array<std::int32_t, kJitterEntries> distance{};             // to the next sample, by entry of the jitter LUT
  std::vector<std::uint32_t> reflectance_map;                      // per texel: the square that begins there
  LargeArray<std::int32_t> first;  // per cell (CellRanges): its block's first decoded voxel; kSkipped, kUnseen
};

inline constexpr std::int32_t kSkipped = -1;  // in an empty block, which rays skip
inline constexpr std::int32_t kUnseen = -2;   // samples count but add nothing

// Parameters of frames whose rays deposit or are scattered.
struct LightField {
  static constexpr std::int32_t kMedium = 0, kStraight = 1, kSurface = 2,
                                kTrap = 3;           // kinds of materials; straight: no scattering
  const std::uint32_t* runs;                         // DepthTable::runs(); null: not the conserving rules
  const std::uint32_t* opaque_up;                    // DepthTable::opaque_up()
  const double* sums;                                // DepthTable::sums()
  bool cubes;                                        // all voxels' edges are equal
  bool scatters;                                     // some material scatters
  bool high_albedo;                                  // Frame::high_albedo
  std::array<std::int32_t, wire::kTags> kind, kept;  // kept: units of wire::kScatteringOne that are not scattered
  std::array<double, wire::kTags> scattering;        // Ks
};

enum class Gathers : std::uint8_t { kOpacity, kColour, kIntegral };

// Other inputs of lanes.
struct PacketField {
  const Frame* frame;
  const std::int16_t* densities;
  const std::uint16_t* codes;        // may be null: all are 0
  const DecodedGradient* gradients;  // by code
  bool tagged;                       // some code has a tag
  const DecodedColour* colours;      // null: none
  const PacketTables* tables;
  const void* opacities;  // 32 bits per entry of the segmentation LUT; 0: invisible
  bool corrected;         // they are tables->alpha, not tables->depth or Frame::wide_depths
  // For frames lit by irradiance; otherwise null.
  const std::int16_t* irradiance;
  std::size_t irradiance_plane;  // distance to green's words, and to blue's; 0: one word for all colours
  const std::int32_t* irradiance_first;
  const std::uint8_t* specular;
  std::int32_t threshold;
  std::int32_t edge;  // voxels of a block with its +1 face
  int block_shift;    // from position units to blocks
  std::int32_t across, slice;
  std::int32_t cells_across, cells_slice;
  const LightField* light;  // for lighting and scattered rays
  Gathers gathers;
  bool cut_faces, premultiplied;
};

class SimdTracer {
 public:
  explicit SimdTracer(const OpacityCorrection& correction);

  // Prepares for `rays` rays of this frame, whose segmentation LUT was written `lut_writes` times and whose volume is
  // decoded. Returns false if scalar code must trace them: they backproject, combine jitter or segments with other
  // features, are too few to justify the ranges of cells, or the volume is too large for offsets of 31 bits.
  bool prepare(std::uint64_t rays, const Frame& frame, std::uint64_t lut_writes, unsigned threads);
  // Frees the cached data.
  void clear();

  // Traces rays of a frame that gathers, at most 2^18, to their ends, in place, on the calling thread. `steps`: empty,
  // or receives each ray's number of steps.
  void trace(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters,
             std::span<std::int32_t> steps = {}) const;
  // Traces paths of other frames until they stop, on the calling thread.
  void trace_paths(std::span<TracedPath> paths, const Frame& frame, RayCounters& counters) const;

 private:
  void read(std::span<const wire::SegmentationEntry> segmentation);
  bool follow_irradiance(const Frame& frame);
  void correct(const Frame& frame, bool lut_changed);
  void find_seen(const Frame& frame, unsigned threads);
  void find_first(const Frame& frame);
  PacketField field_of(const Frame& frame) const;

  const OpacityCorrection& correction_;
  IrradianceCopy irradiance_;
  CellRanges ranges_;
  LargeArray<std::uint8_t> seen_;  // per cell: one of its densities has an opacity
  PacketTables tables_;
  std::uint32_t exponent_ = 0;  // tables_.alpha was made for this, and for:
  bool wide_ = false;
  std::uint64_t volume_ = 0;  // VolumeMemory::decodings()
  std::uint64_t rays_ = 0;    // rays since then
  std::uint64_t lut_writes_ = ~std::uint64_t{0};
};

}  // namespace gicube::emu
