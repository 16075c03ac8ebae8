// Assigns paths to lanes: takes a ray off its masked lane for a scalar iteration, then puts it back, or the next one.

#include "functional/simd/path_march-inl.h"

inline PathKind kind_of(const RayState& ray, const Frame& frame) {
  if (!ray.is(wire::kLightingRay)) return PathKind::kRendering;
  if (ray.is(wire::kHighAlbedo)) return PathKind::kPhoton;
  return frame.light_words == 1 ? PathKind::kWeighted : PathKind::kColouredWeighted;
}

class PathScheduler : public LaneSlots<PathScheduler> {
 public:
  // Paths of another kind than `kind` are traced by scalar code.
  PathScheduler(std::span<TracedPath> paths, PathKind kind, const Frame& frame, RayCounters& counters)
      : LaneSlots(paths.size(), kind == PathKind::kRendering),
        paths_(paths),
        kind_(kind),
        frame_(frame),
        counters_(counters) {}

  // To be called when all paths have stopped: adds the colours that rendering rays have gathered on lanes.
  void finish_colours(const PacketField& field) {
    if (kind_ != PathKind::kRendering || field.frame->wide) return;
    seen_.finish<false>(field);
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint16_t& colour = paths_[i].ray_state.colour[c];
        const auto sum = static_cast<std::uint32_t>(colour + seen_.sum(i).channel[c]);
        colour = static_cast<std::uint16_t>(std::min(sum, wire::kColourOne));
      }
    }
  }

  bool begin(std::size_t i) {
    TracedPath& path = paths_[i];
    if (kind_of(path.ray_state, frame_) != kind_) {
      trace_path(path, frame_, counters_);
      return false;
    }
    path.how = end(path.ray_state, frame_);
    return path.how == Termination::kActive;
  }

  void put(PathLanes& lanes, std::size_t lane, std::size_t i) {
    path_[lane] = &paths_[i];
    put_segment(lanes, lane);
    put_on(lanes, lane);
  }

  bool stopped(const PathLanes& lanes, std::size_t lane) const {
    return lanes.left.lane[lane] <= 0 || lanes.masked.lane[lane] != 0;
  }

  // The scalar iteration of a ray, if it has not ended.
  bool resume(PathLanes& lanes, std::size_t lane) {
    take(lanes, lane);
    TracedPath& path = *path_[lane];
    RayState& ray = path.ray_state;
    path.how = end(ray, frame_);
    if (path.how != Termination::kActive) return false;
    if (lanes.masked.lane[lane] != 0 && lanes.known.found.lane[lane] != 0) {
      const KnownInterval known = lanes.known.of_lane(lane);
      path.how = take_iteration(ray, frame_, counters_, &known);
    } else {
      path.how = take_iteration(ray, frame_, counters_, nullptr);
    }
    if (path.how == Termination::kActive) path.how = end(ray, frame_);
    if (path.how != Termination::kActive) return false;
    if (!ray.under_way) put_segment(lanes, lane);
    put_on(lanes, lane);
    return true;
  }

  void idle(PathLanes& lanes, std::size_t lane) const { lanes.left.lane[lane] = 0; }

 private:
  void put_on(PathLanes& lanes, std::size_t lane) const {
    const RayState& ray = path_[lane]->ray_state;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lanes.position[axis].lane[lane] = ray.position[axis];
      lanes.rest[axis].lane[lane] = ray.rest[axis];
    }
    const std::int32_t left = steps_inside(ray, frame_, kNoLimit);
    lanes.left.lane[lane] = left;
    lanes.more.lane[lane] = kNoLimit - left;
    lanes.taken.lane[lane] = 0;
    lanes.begun.lane[lane] = ray.under_way != 0 ? -1 : 0;
    lanes.trapped.lane[lane] = ray.is(wire::kTrapped) ? -1 : 0;
    lanes.masked.lane[lane] = 0;
    for (std::size_t word = 0; word < words_of(kind_); ++word) {
      const std::uint64_t energy = ray.energy(word);
      lanes.energy[word][0].lane[lane] = static_cast<std::int32_t>(energy & 0xFF'FFFF);
      lanes.energy[word][1].lane[lane] = static_cast<std::int32_t>(energy >> 24);
    }
    lanes.interacted.lane[lane] = static_cast<std::int32_t>(ray.interacted);
    lanes.opacity.lane[lane] = static_cast<std::int32_t>(ray.opacity);
  }

  // Sets the words that are constant until the ray is scattered.
  void put_segment(PathLanes& lanes, std::size_t lane) const {
    const RayState& ray = path_[lane]->ray_state;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lanes.step[axis].lane[lane] = ray.step[axis];
      lanes.step_rest[axis].lane[lane] = ray.step_rest[axis];
      const double slope = ray.slope(axis);
      lanes.slope[axis].lane[lane] = slope;
      lanes.inverse[axis].lane[lane] = slope == 0 ? 0 : 1.0 / slope;
    }
    lanes.exponent.lane[lane] = static_cast<std::int32_t>(ray.exponent);
    for (std::size_t axis = 0; axis < 3; ++axis) lanes.direction[axis].lane[lane] = ray.direction[axis];
    lanes.scattered.lane[lane] = ray.generation != 0 ? -1 : 0;
    lanes.value.lane[lane] = static_cast<std::int32_t>(interaction_value(ray, frame_));
    lanes.ray.lane[lane] = static_cast<std::int32_t>(path_[lane] - paths_.data());
    if (kind_ == PathKind::kRendering) return;
    lanes.phase.lane[lane] = static_cast<std::int32_t>(energy_phase(ray, frame_));
    const std::uint64_t loss = draw(RandomStream::kLoss, ray.u, ray.v, ray.lifetime, frame_.seed);
    lanes.loss[0].lane[lane] = static_cast<std::int32_t>(loss);
    lanes.loss[1].lane[lane] = static_cast<std::int32_t>(loss >> 32);
  }

  void take(const PathLanes& lanes, std::size_t lane) {
    RayState& ray = path_[lane]->ray_state;
    const std::int32_t taken = lanes.taken.lane[lane];
    if (taken == 0) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ray.position[axis] = lanes.position[axis].lane[lane];
      if (frame_.wide) ray.rest[axis] = static_cast<std::uint16_t>(lanes.rest[axis].lane[lane]);
    }
    ray.under_way = true;
    if (lanes.trapped.lane[lane] == 0) leave_surface(ray);
    ray.interacted = static_cast<std::uint32_t>(lanes.interacted.lane[lane]);
    if (kind_ == PathKind::kRendering) {
      ray.opacity = static_cast<std::uint32_t>(lanes.opacity.lane[lane]);
      return;
    }
    for (std::size_t word = 0; word < words_of(kind_); ++word) {
      ray.set_energy(word, static_cast<std::uint64_t>(lanes.energy[word][0].lane[lane]) |
                               static_cast<std::uint64_t>(lanes.energy[word][1].lane[lane]) << 24);
    }
  }

  std::span<TracedPath> paths_;
  PathKind kind_;
  const Frame& frame_;
  RayCounters& counters_;
  std::array<TracedPath*, 16> path_{};
};
