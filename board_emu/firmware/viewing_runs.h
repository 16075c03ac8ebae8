// Runs of viewing rays, the ray differentials of [P §3.6]. The DSP generates the first ray of a run and its increments.
// The processors generate the others, each with a product and a sum.
//
// Within a run the increments are constant; those of a perspective are not. Therefore a run ends before a ray would
// deviate too far, at its start or anywhere along it, from the ray that the DSP would have made alone, or before a ray
// enters by another face [H1301-H1304].
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "firmware/viewing_rays.h"
#include "gicube/wire/ray.h"
#include "levels/dsp_task.h"

namespace gicube::emu {

// The first ray; the last one, for the increments; and the length of the run, from second differences at both, which
// the row's increments give (8 products, and a root by table with one step: 12 operations). The increments are 6
// differences times a reciprocal (14 multiplications, 30 operations with their roundings).
inline constexpr DspLoop kMakeRun{"run of rays", 2 * (kMakeViewingRay.multiplies + 8) + 14,
                                  2 * (kMakeViewingRay.operations + 12) + 30, 2 * kMakeViewingRay.accesses + 8};

struct RunRules {
  std::uint32_t rays = 0;   // maximum per run; 0 and 1: no runs
  std::uint32_t error = 0;  // 2^-14 voxels
};

// The rays of a row's samples begin .. end - 1.
struct ViewingRun {
  static constexpr int kFractionBits = 10;  // more than a ray's words have, so that 1023 sums are within half a unit

  std::uint64_t begin = 0, end = 0;
  bool misses = false;  // all of them miss the volume
  wire::Ray first;      // without its image position
  std::array<std::int64_t, 3> position_step{}, direction_step{};

  // The ray of sample `i` without its image position; nothing if it misses.
  std::optional<wire::Ray> ray(std::uint64_t i, const Point& extent) const;
};

// Divides the samples begin .. end - 1 of a row into runs. Their lines are `line(sample)`.
std::vector<ViewingRun> viewing_runs(std::uint64_t begin, std::uint64_t end, const RunRules& rules,
                                     const std::function<Line(std::uint64_t)>& line, const Point& extent,
                                     std::span<const Plane> planes);

}  // namespace gicube::emu
