#include "firmware/viewing_runs.h"

#include <algorithm>
#include <cmath>

namespace gicube::emu {

namespace {

// The maximum deviation of three points from equal spacing, along an axis.
double second_difference(const std::array<double, 3>& a, const std::array<double, 3>& b,
                         const std::array<double, 3>& c) {
  double most = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) most = std::max(most, std::abs(a[axis] - 2 * b[axis] + c[axis]));
  return most;
}

std::int64_t quotient(std::int64_t difference, std::int64_t steps) {
  return std::llround(std::ldexp(static_cast<double>(difference), ViewingRun::kFractionBits) /
                      static_cast<double>(steps));
}

std::int64_t sum(std::int64_t first, std::int64_t step, std::int64_t steps) {
  constexpr std::int64_t kHalf = std::int64_t{1} << (ViewingRun::kFractionBits - 1);
  return first + ((step * steps + kHalf) >> ViewingRun::kFractionBits);
}

// Makes the runs of a row one after the other.
class RunMaker {
 public:
  RunMaker(const RunRules& rules, const std::function<Line(std::uint64_t)>& line, const Point& extent,
           std::span<const Plane> planes)
      : rules_(rules), line_(line), extent_(extent), planes_(planes) {}

  ViewingRun make(std::uint64_t begin, std::uint64_t end) const {
    end = std::min(end, begin + std::max(1u, rules_.rays));
    ViewingRun run;
    run.begin = begin;
    run.end = begin + 1;
    const auto first = at(begin);
    if (!first) {
      run.misses = true;
      while (run.end < end && !at(run.end)) ++run.end;
      return run;
    }
    run.first = *viewing_ray(line_(begin), 0, 0, extent_, planes_);
    run.end = std::min(end, begin + longest(begin, begin + 1, begin + 2));
    while (!reaches(run, first->face)) run.end -= (run.end - begin) / 2;
    if (run.end - begin < kLeast) run.end = begin + 1;
    set_steps(run);
    return run;
  }

 private:
  static constexpr std::uint64_t kLeast = 4;  // a shorter run costs the DSP more than its single rays

  std::optional<Entry> at(std::uint64_t i) const { return entry(line_(i), extent_, planes_); }
  // Diagonal of the volume in voxels: the maximum length of a ray.
  double diagonal() const { return std::hypot(extent_[0], extent_[1], extent_[2]) / wire::kVoxel; }

  // Maximum number of rays in a run whose increments change as at the samples a, b and c. A chord of n steps deviates
  // from its curve by the second difference times n^2 / 8.
  std::uint64_t longest(std::uint64_t a, std::uint64_t b, std::uint64_t c) const {
    const auto first = at(a), second = at(b), third = at(c);
    if (!second || second->face != first->face) return 1;
    if (!third || third->face != first->face) return 2;
    const double bend = second_difference(first->position, second->position, third->position) +
                        diagonal() * second_difference(first->direction, second->direction, third->direction);
    const double error = rules_.error / double{wire::kVoxel};
    return 1 + static_cast<std::uint64_t>(std::min(std::sqrt(8 * error / bend), 1e6));
  }

  // Whether the run's last ray enters by this face, and the increments there also change little enough. In between they
  // do not change more, because along a face the change is monotonic.
  bool reaches(const ViewingRun& run, int face) const {
    const std::uint64_t rays = run.end - run.begin;
    if (rays == 1) return true;
    const auto last = at(run.end - 1);
    if (!last || last->face != face) return false;
    return rays < kLeast || rays <= longest(run.end - 1, run.end - 2, run.end - 3);
  }

  void set_steps(ViewingRun& run) const {
    const auto steps = static_cast<std::int64_t>(run.end - 1 - run.begin);
    if (steps == 0) return;
    const wire::Ray last = *viewing_ray(line_(run.end - 1), 0, 0, extent_, planes_);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      run.position_step[axis] = quotient(std::int64_t{last.position[axis]} - run.first.position[axis], steps);
      run.direction_step[axis] = quotient(last.direction[axis] - run.first.direction[axis], steps);
    }
  }

  const RunRules& rules_;
  const std::function<Line(std::uint64_t)>& line_;
  const Point& extent_;
  std::span<const Plane> planes_;
};

}  // namespace

std::optional<wire::Ray> ViewingRun::ray(std::uint64_t i, const Point& extent) const {
  if (misses) return std::nullopt;
  wire::Ray ray = first;
  const auto steps = static_cast<std::int64_t>(i - begin);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t position = sum(first.position[axis], position_step[axis], steps);
    ray.position[axis] = static_cast<std::uint32_t>(std::clamp<std::int64_t>(position, 0, extent[axis]));
    ray.direction[axis] = static_cast<std::int16_t>(sum(first.direction[axis], direction_step[axis], steps));
  }
  return ray;
}

std::vector<ViewingRun> viewing_runs(std::uint64_t begin, std::uint64_t end, const RunRules& rules,
                                     const std::function<Line(std::uint64_t)>& line, const Point& extent,
                                     std::span<const Plane> planes) {
  const RunMaker maker(rules, line, extent, planes);
  std::vector<ViewingRun> runs;
  while (begin < end) {
    runs.push_back(maker.make(begin, end));
    begin = runs.back().end;
  }
  return runs;
}

}  // namespace gicube::emu
