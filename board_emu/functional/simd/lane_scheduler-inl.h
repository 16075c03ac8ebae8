// Assigns rays to lanes: takes a ray that has ended off its lane, packs it, and puts the next one there.

#include "functional/simd/march-inl.h"

constexpr std::int32_t kNoLimit = std::int32_t{1} << 29;

// Whether the ray is still in the volume after `steps` steps.
inline bool inside_after(const RayState& ray, std::int32_t steps, const Frame& frame) {
  const FinePoint at = moved(ray.fine_position(), ray.fine_step(), steps), most = fine_extent(frame.extent);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (at[axis] < 0 || at[axis] > most[axis]) return false;
  }
  return true;
}

// Number of equal steps, at most `most`, that take the ray out of the volume or beyond a cut plane.
inline std::int32_t steps_inside(const RayState& ray, const Frame& frame, std::int32_t most) {
  if (most <= 0 || !inside(ray.position, frame.extent)) return 0;
  std::int32_t least = most;
  // Segments usually end inside, which takes no division.
  if (most == kNoLimit || !inside_after(ray, most - 1, frame)) {
    least = frame.wide ? emu::steps_inside(ray.fine_position(), ray.fine_step(), fine_extent(frame.extent), most)
                       : emu::steps_inside(ray.position, ray.step, frame.extent, most);
  }
  for (const Plane& plane : frame.cut_planes) {
    const std::int64_t a_step = frame.wide ? fine_slope(plane, ray.fine_step()) : dot(plane.normal, ray.step);
    const std::int64_t above =
        frame.wide ? fine_height(plane, ray.fine_position()) : dot(plane.normal, ray.position) - plane.offset;
    if (a_step >= 0) continue;
    if (above < 0) return 0;
    least = static_cast<std::int32_t>(std::min<std::int64_t>(least, above / -a_step + 1));
  }
  return least;
}

// Puts `count` rays on the lanes, one after the other. `Scheduler`, derived from it, has
//   bool begin(i)                 prepares ray i for a lane; false if it needs none, because it has ended or was traced
//                                 alone
//   void put(lanes, lane, i)      puts it there
//   bool stopped(lanes, lane)     whether the lane's ray has ended, or scalar code must take its sample
//   bool resume(lanes, lane)      takes such a ray off its lane; true: it has put it back, since it continues
//   void idle(lanes, lane)        for lanes without a ray
template <class Scheduler>
class LaneSlots {
 public:
  LaneSlots(std::size_t count, bool gathers_colour) : seen_(gathers_colour ? count : 0), count_(count) {}

  ShadingQueue& seen() { return seen_; }

  // Traces all rays. `march(lanes, enough)` advances them until at least `enough` lanes have stopped.
  template <class LaneWords, class March>
  void run(const March& march) {
    const std::size_t all = hn::Lanes(D32());
    LaneWords lanes{};
    while (true) {
      for (std::size_t lane = 0; lane < all; ++lane) serve(lanes, lane);
      if (busy_ == 0) return;
      // A few idle lanes cost less than an exchange for each; without new rays, one of the busy lanes must end.
      march(lanes, next_ < count_ ? std::max<std::size_t>(all / 4, 1) : all - busy_ + 1);
    }
  }

 protected:
  ShadingQueue seen_;

 private:
  template <class LaneWords>
  void serve(LaneWords& lanes, std::size_t lane) {
    auto& scheduler = static_cast<Scheduler&>(*this);
    if (has_ray_[lane]) {
      if (!scheduler.stopped(lanes, lane) || scheduler.resume(lanes, lane)) return;
      has_ray_[lane] = false;
      --busy_;
    }
    while (next_ < count_) {
      const std::size_t i = next_++;
      if (!scheduler.begin(i)) continue;
      scheduler.put(lanes, lane, i);
      has_ray_[lane] = true;
      ++busy_;
      return;
    }
    scheduler.idle(lanes, lane);
  }

  std::array<bool, 16> has_ray_{};
  std::size_t count_, next_ = 0, busy_ = 0;
};

// Rays of a frame that gathers.
class LaneScheduler : public LaneSlots<LaneScheduler> {
 public:
  LaneScheduler(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters, std::span<std::int32_t> steps)
      : LaneSlots(rays.size(), gathers_colour(frame)), rays_(rays), frame_(frame), counters_(counters), steps_(steps) {}

  // To be called when all rays have ended: writes their colours into their packets.
  void finish_colours() {
    if (!gathers_colour(frame_)) return;
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) rays_[i].colour[c] = colour_word(seen_.sum(i).channel[c]);
    }
  }

  // A lit ray that was scattered before is traced by scalar code, because it may have to leave a surface first.
  bool begin(std::size_t i) {
    wire::Ray& ray = rays_[i];
    if (!frame_.lit_by_irradiance || (ray.generation == 0 && (ray.flags & wire::kTrapped) == 0)) return true;
    integrate(ray, frame_, counters_);
    set_colour(i, ray);
    return false;
  }

  bool stopped(const Lanes& lanes, std::size_t lane) const {
    return lanes.left.lane[lane] <= 0 ||
           lanes.opacity.lane[lane] >= static_cast<std::int32_t>(frame_.opacity_threshold);
  }

  void idle(Lanes& lanes, std::size_t lane) const {
    lanes.left.lane[lane] = 0;
    lanes.position[0].lane[lane] = -1;  // outside, where jittered rays end
  }

  void put(Lanes& lanes, std::size_t lane, std::size_t i) {
    Slot& slot = slots_[lane];
    slot.ray = &rays_[i];
    // Constructed in place: a copy would read in wide words what was just written in narrow ones, and stall.
    new (&slot.ray_state) RayState(unpack(*slot.ray, frame_));
    set_colour(i, slot.ray_state);
    lanes.ray.lane[lane] = static_cast<std::int32_t>(i);
    const RayState& ray = slot.ray_state;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lanes.position[axis].lane[lane] = ray.position[axis];
      lanes.step[axis].lane[lane] = ray.step[axis];
      lanes.direction[axis].lane[lane] = ray.direction[axis];
      if (!wide_) continue;
      lanes.rest[axis].lane[lane] = ray.rest[axis];
      lanes.step_rest[axis].lane[lane] = ray.step_rest[axis];
    }
    for (Word& word : lanes.sum) word.lane[lane] = 0;
    const std::int32_t segment = frame_.segments() ? ray.steps_left() : kNoLimit;
    slot.steps = frame_.jitter ? 1 : steps_inside(ray, frame_, segment);
    lanes.left.lane[lane] = slot.steps;
    lanes.more.lane[lane] = segment - slot.steps;
    lanes.taken.lane[lane] = 0;
    lanes.length.lane[lane] = static_cast<std::int32_t>(ray.length);
    lanes.destination.lane[lane] = static_cast<std::int32_t>(ray.u | std::uint32_t{ray.v} << 16);
    lanes.exponent.lane[lane] = static_cast<std::int32_t>(ray.exponent);
    lanes.opacity.lane[lane] = static_cast<std::int32_t>(ray.opacity);
    if (wide_) lanes.wide_opacity.lane[lane] = std::bit_cast<std::int32_t>(ray.wide.opacity);
  }

  // Packs the ray, which has ended.
  bool resume(const Lanes& lanes, std::size_t lane) {
    Slot& slot = slots_[lane];
    RayState& ray = slot.ray_state;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ray.position[axis] = lanes.position[axis].lane[lane];
      ray.step[axis] = lanes.step[axis].lane[lane];
      if (!wide_) continue;
      ray.rest[axis] = static_cast<std::uint16_t>(lanes.rest[axis].lane[lane]);
      ray.step_rest[axis] = static_cast<std::uint16_t>(lanes.step_rest[axis].lane[lane]);
    }
    if (frame_.integral()) {
      const auto low = static_cast<std::uint64_t>(lanes.sum[0].lane[lane]);
      ray.set_density_sum(low | static_cast<std::uint64_t>(lanes.sum[1].lane[lane]) << kSumBits);
    }
    const std::int32_t steps = frame_.jitter ? lanes.taken.lane[lane] : slot.steps - lanes.left.lane[lane];
    if (frame_.segments()) ray.set_steps_left(ray.steps_left() - steps);
    ray.opacity = static_cast<std::uint32_t>(lanes.opacity.lane[lane]);
    count_end(ray, end(ray, frame_), frame_, counters_);
    pack(ray, frame_, *slot.ray);
    if (!steps_.empty()) steps_[static_cast<std::size_t>(slot.ray - rays_.data())] = steps;
    return false;
  }

 private:
  struct Slot {
    RayState ray_state;
    wire::Ray* ray = nullptr;
    std::int32_t steps = 0;  // at its start
  };

  static bool gathers_colour(const Frame& frame) { return !frame.colourless() && !frame.integral(); }

  template <typename Ray>
  void set_colour(std::size_t index, const Ray& ray) {
    if (!gathers_colour(frame_)) return;
    for (std::size_t c = 0; c < 3; ++c) {
      const float wide = ray.colour[c];
      seen_.sum(index).channel[c] = wide_ ? std::bit_cast<std::int32_t>(wide) : ray.colour[c];
    }
  }

  std::uint16_t colour_word(std::int32_t sum) const {
    return wide_ ? to_colour_word(std::bit_cast<float>(sum))
                 : static_cast<std::uint16_t>(std::min(sum, static_cast<std::int32_t>(wire::kColourOne)));
  }

  std::span<wire::Ray> rays_;
  const Frame& frame_;
  RayCounters& counters_;
  std::span<std::int32_t> steps_;
  const bool wide_ = frame_.wide;
  std::array<Slot, 16> slots_{};
};
