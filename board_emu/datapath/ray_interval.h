// The integration interval of a lighting ray's sample, and the opacity of the media in it, with the conserving rules
// [H910-H912]. The eight voxels of the sample's cell define densities and tags in the whole interval,
// so that a medium may begin or end anywhere between two samples.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "datapath/ray_step.h"
#include "gicube/wire/lut.h"

namespace gicube::emu {

inline constexpr std::size_t kTagEntries =
    wire::kSegmentationEntries / wire::kTags;  // of the segmentation LUT, of each tag

// The segmentation LUT's optical depths, summed over the densities: pre-integrated classification [Engel, Kraus and
// Ertl, "High-quality pre-integrated volume rendering", Graphics Hardware 2001], without colours.
class DepthTable {
 public:
  explicit DepthTable(std::span<const wire::SegmentationEntry> entries);

  struct Depth {
    double depth = 0;   // optical depth up to the opaque part, natural units
    double opaque = 2;  // from this fraction of the path on, 0..1, nothing passes; 2: nowhere opaque
  };
  // Depth of a path of `length` voxel lengths; the density changes linearly from `from` to `to` (12 bits and a
  // fraction).
  Depth between(unsigned tag, double from, double to, double length) const;
  // The fraction of such a path after which the fraction `share` of its depth is behind the ray, both 0..1.
  double way_to(double share, unsigned tag, double from, double to) const;
  // Whether all densities of the range have one opacity.
  bool uniform(unsigned tag, const DensityRange& range) const {
    return run_[segmentation_index(range.least, tag)] == run_[segmentation_index(range.greatest, tag)];
  }
  // For lanes of rays (functional/simd). By entry: number of changes of the opacity before it; the next opaque entry at
  // or above it with its tag, or all ones; sum of the depths before it, with one more entry.
  std::span<const std::uint32_t> runs() const { return run_; }
  std::span<const std::uint32_t> opaque_up() const { return opaque_up_; }
  std::span<const double> sums() const { return sum_; }

 private:
  std::vector<double> sum_;                             // depths of all entries before; opaque ones add nothing
  std::vector<std::uint32_t> run_;                      // number of changes of the opacity
  std::vector<std::uint32_t> opaque_up_, opaque_down_;  // the next opaque entry at or above, at or below
};

// Opacity of an optical depth, 24 bits.
inline std::uint32_t opacity_of_depth(double depth) {
  return static_cast<std::uint32_t>(std::lround(-std::expm1(-depth) * wire::kOpacityOne));
}

// The interval of a sample in one medium that is nowhere opaque, as lanes of rays have computed it (functional/simd).
struct KnownInterval {
  std::size_t entry = 0;         // of the segmentation LUT: of the sample
  std::uint32_t opacity = 0;     // 24 bits
  bool even = false;             // one opacity; of the following, only the first and the last end are then set
  std::array<double, 5> ends{};  // its begin; where the ray enters the cell; middle; where it leaves the cell; its end
  std::array<double, 3> density{};  // at the three ends in between
  std::array<double, 4> depth{};    // between the ends
};

// Iterates over the media of the interval, if the voxels around the sample have several tags. Begins with the first.
class RayInterval {
 public:
  // A medium of one opacity.
  static RayInterval even(double begin, double end, std::uint32_t opacity, unsigned tag);
  static RayInterval of(const KnownInterval& known);
  // The interval of a lighting ray's sample at `site` with this material and opacity. `first`: of its path segment.
  static RayInterval of(const RayState& ray, const SampleSite& site, unsigned tag, std::uint16_t opacity, bool first,
                        const Frame& frame);
  // True only if the interval has no opacity. Fast, because most samples are in empty space.
  static bool is_clear(const SampleSite& site, unsigned tag, std::uint16_t opacity, const Frame& frame) {
    return opacity == 0 && has_one_tag(site) &&
           frame.depths->uniform(tag, density_range(site.view.densities, around(site)));
  }

  // Properties of the present medium.
  unsigned tag() const { return tag_; }
  std::uint32_t opacity() const { return opacity_; }  // 24 bits
  // The position at which the fraction `share` of its depth, 0..1, is behind the ray, in steps from the sample.
  double place(double share, const Frame& frame) const;

  // Moves to the next medium; false if there is none.
  bool next();

 private:
  void add(double begin, double end, double depth, double from, double to, unsigned tag) {
    piece_[pieces_++] = {begin, end, depth, from, to, tag};
  }

  struct Piece {
    double begin, end, depth;
    double from, to;  // densities; equal: the depth is distributed evenly
    unsigned tag;
  };
  unsigned tag_ = 0;
  std::uint32_t opacity_ = 0;
  double depth_ = 0;
  std::size_t first_ = 0, last_ = 0, pieces_ = 0;  // the medium's pieces end before last_
  std::array<Piece, 8> piece_;                     // two beyond the cell, five in it, and an opaque end
};

}  // namespace gicube::emu
