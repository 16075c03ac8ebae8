#include "functional.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "pipeline/advance.h"
#include "pipeline/classify.h"
#include "pipeline/composite.h"
#include "pipeline/jitter.h"
#include "pipeline/resample.h"
#include "pipeline/shade.h"

namespace gicube::emu {

namespace {

constexpr std::uint32_t kFractionMask = static_cast<std::uint32_t>(wire::kVoxel) - 1;

// How many reference voxel lengths one voxel length along `direction` is, 16.16. Exactly one where spacing is one.
std::uint32_t physical_length(const std::array<std::int16_t, 3>& direction,
                              const std::array<std::uint32_t, 3>& spacing) {
  if (spacing[0] == spacing[1] && spacing[1] == spacing[2]) return spacing[0];
  double voxels = 0, physical = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double d = direction[axis], scaled = d * spacing[axis];
    voxels += d * d;
    physical += scaled * scaled;
  }
  return static_cast<std::uint32_t>(std::lround(std::sqrt(physical / voxels)));
}

// The block that a position lies in, in the form that the inner loop needs.
struct Block {
  std::size_t index = ~std::size_t{0};
  Point low{};
  BlockView view;
};

class March {
 public:
  March(wire::Ray& ray, const Frame& frame, RayCounters& counters)
      : ray_(ray),
        frame_(frame),
        counters_(counters),
        length_(physical_length(ray.direction, frame.spacing)),
        block_shift_(std::countr_zero(static_cast<unsigned>(frame.volume->block_voxels())) +
                     wire::kPositionFractionBits),
        edge_(static_cast<std::size_t>(frame.volume->block_voxels()) + 1) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position_[axis] = static_cast<std::int32_t>(ray.position[axis]);
      gathered_.colour[axis] = ray.colour[axis];
    }
    gathered_.opacity = ray.opacity;
    space(frame.step);
  }

  void run() {
    while (inside(position_, frame_.extent) && kept()) {
      if (gathered_.opacity >= frame_.opacity_threshold) {
        ++counters_.terminated;
        break;
      }
      if (frame_.jitter) space(round_step(jitter(position_, ray_.u, ray_.v)));
      enter_block();
      if (frame_.leap && frame_.empty[block_.index] != 0) {
        move(leap_steps(position_, step_, block_.low, std::int32_t{1} << block_shift_));
        ++counters_.leaps;
      } else {
        sample();
        move(1);
      }
    }
    finish();
  }

 private:
  std::uint32_t round_step(std::uint32_t factor) const {
    return static_cast<std::uint32_t>(round_shift<16>(std::int64_t{frame_.step} * factor));
  }

  // Sets the distance to the next sample, and what it means for opacity.
  void space(std::uint32_t distance) {
    step_ = step_vector(ray_.direction, distance);
    exponent_ =
        static_cast<std::uint32_t>(round_shift<16>(static_cast<std::int64_t>(std::uint64_t{distance} * length_)));
  }

  bool kept() const {
    return std::none_of(frame_.cut_planes.begin(), frame_.cut_planes.end(),
                        [this](const Plane& plane) { return beyond(plane, position_, step_); });
  }

  void enter_block() {
    const std::array<int, 3>& blocks = frame_.volume->blocks();
    const auto bx = static_cast<std::size_t>(position_[0] >> block_shift_),
               by = static_cast<std::size_t>(position_[1] >> block_shift_),
               bz = static_cast<std::size_t>(position_[2] >> block_shift_);
    const std::size_t index =
        bx + static_cast<std::size_t>(blocks[0]) * (by + static_cast<std::size_t>(blocks[1]) * bz);
    if (index == block_.index) return;
    block_.index = index;
    block_.view = frame_.volume->view(index);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      block_.low[axis] = position_[axis] >> block_shift_ << block_shift_;
    }
  }

  void move(std::int32_t steps) {
    for (std::size_t axis = 0; axis < 3; ++axis) position_[axis] += steps * step_[axis];
  }

  void sample() {
    ++counters_.samples;
    std::array<std::uint32_t, 3> local, fraction;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto offset = static_cast<std::uint32_t>(position_[axis] - block_.low[axis]);
      local[axis] = offset >> wire::kPositionFractionBits;
      fraction[axis] = offset & kFractionMask;
    }
    const std::size_t row = edge_, slice = edge_ * edge_;
    const std::size_t cell = local[0] + row * local[1] + slice * local[2];
    const Neighbourhood at{
        block_.view.voxels + cell, row, slice, {weight(fraction[0]), weight(fraction[1]), weight(fraction[2])}};
    unsigned tag = 0;
    if (block_.view.tags != nullptr) {
      constexpr std::uint32_t kHalf = wire::kVoxel / 2;
      tag = block_.view
                .tags[cell + (fraction[0] >= kHalf) + row * (fraction[1] >= kHalf) + slice * (fraction[2] >= kHalf)];
    }
    const wire::SegmentationEntry& entry = frame_.segmentation[segmentation_index(resample(at, 0), tag)];
    if (entry.opacity == 0) return;
    ++counters_.visible_samples;
    const Colour12 colour = frame_.shade ? shade(entry, resample_gradient(at), frame_.reflectance_map)
                                         : Colour12{entry.colour[0], entry.colour[1], entry.colour[2]};
    over(gathered_, colour, (*frame_.opacity_correction)(entry.opacity, exponent_));
  }

  void finish() {
    ++counters_.rays;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ray_.position[axis] = static_cast<std::uint32_t>(std::clamp(position_[axis], 0, frame_.extent[axis]));
      ray_.colour[axis] = static_cast<std::uint16_t>(gathered_.colour[axis]);
    }
    ray_.opacity = gathered_.opacity;
    ray_.contribution = contribution(gathered_.opacity);
  }

  wire::Ray& ray_;
  const Frame& frame_;
  RayCounters& counters_;
  std::uint32_t length_;
  int block_shift_;
  std::size_t edge_;
  Point position_{};
  Point step_{};
  std::uint32_t exponent_ = 0;
  Gathered gathered_;
  Block block_;
};

}  // namespace

void integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters) { March(ray, frame, counters).run(); }

}  // namespace gicube::emu
