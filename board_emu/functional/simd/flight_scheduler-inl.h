// Assigns flights to lanes: takes a ray off its masked lane for a scalar iteration, then puts it back, or the next one.

// Included once for each instruction set.
#if defined(GICUBE_FLIGHT_SCHEDULER) == defined(HWY_TARGET_TOGGLE)
#ifdef GICUBE_FLIGHT_SCHEDULER
#undef GICUBE_FLIGHT_SCHEDULER
#else
#define GICUBE_FLIGHT_SCHEDULER
#endif

#include <algorithm>
#include <span>

#include "datapath/interaction.h"
#include "datapath/random_stream.h"
#include "flight_march-inl.h"
#include "functional/flight.h"
#include "lane_scheduler-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR

inline FlightKind kind_of(const RayState& ray, const Frame& frame) {
  if (!ray.is(wire::kLightingRay)) return FlightKind::kRendering;
  if (ray.is(wire::kHighAlbedo)) return FlightKind::kPhoton;
  return frame.light_words == 1 ? FlightKind::kBundle : FlightKind::kColouredBundle;
}

class FlightScheduler {
 public:
  // Flights of another kind than `kind` are traced by scalar code.
  FlightScheduler(std::span<Flight> flights, FlightKind kind, const Frame& frame, RayCounters& counters)
      : flights_(flights),
        kind_(kind),
        frame_(frame),
        counters_(counters),
        seen_(kind == FlightKind::kRendering ? flights.size() : 0) {}

  bool has_more() const { return next_ < flights_.size(); }
  std::size_t busy() const { return busy_; }
  ShadingQueue& seen() { return seen_; }

  // To be called when all flights have stopped: adds the colours that rendering rays have gathered on lanes.
  void finish_colours(const PacketField& field) {
    if (kind_ != FlightKind::kRendering || field.wide) return;
    seen_.finish<false>(field);
    for (std::size_t i = 0; i < flights_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint16_t& colour = flights_[i].ray_state.colour[c];
        const auto sum = static_cast<std::uint32_t>(colour + seen_.sum(i).channel[c]);
        colour = static_cast<std::uint16_t>(std::min(sum, wire::kColourOne));
      }
    }
  }

  void serve(FlightLanes& lanes, std::size_t count) {
    for (std::size_t lane = 0; lane < count; ++lane) {
      Slot& slot = slots_[lane];
      if (slot.flight != nullptr) {
        if (lanes.left.lane[lane] > 0 && lanes.stands.lane[lane] == 0) continue;
        take(lanes, lane);
        if (goes_on(*slot.flight)) {
          put(lanes, lane);
          continue;
        }
        slot.flight = nullptr;
        --busy_;
      }
      if (Flight* const next = next_for_lanes()) {
        slot.flight = next;
        slot.fresh = true;
        ++busy_;
        put(lanes, lane);
      } else {
        lanes.left.lane[lane] = 0;
      }
    }
  }

 private:
  struct Slot {
    Flight* flight = nullptr;
    bool fresh = false;  // the words of the path segment must be set
  };

  // The scalar iteration of a ray, if it has not ended. Returns whether the ray continues.
  bool goes_on(Flight& flight) {
    RayState& ray = flight.ray_state;
    flight.how = end(ray, frame_);
    if (flight.how != Termination::kActive) return false;
    flight.how = take_pass(ray, frame_, counters_);
    if (flight.how == Termination::kActive) flight.how = end(ray, frame_);
    return flight.how == Termination::kActive;
  }

  Flight* next_for_lanes() {
    while (has_more()) {
      Flight& flight = flights_[next_++];
      if (kind_of(flight.ray_state, frame_) != kind_) {
        fly(flight, frame_, counters_);
        continue;
      }
      flight.how = end(flight.ray_state, frame_);
      if (flight.how == Termination::kActive) return &flight;
    }
    return nullptr;
  }

  void put(FlightLanes& lanes, std::size_t lane) {
    Slot& slot = slots_[lane];
    const RayState& ray = slot.flight->ray_state;
    if (slot.fresh || !ray.under_way) put_flight(lanes, lane, ray);
    slot.fresh = false;
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
    lanes.stands.lane[lane] = 0;
    for (std::size_t word = 0; word < words_of(kind_); ++word) {
      const std::uint64_t energy = ray.energy(word);
      lanes.energy[word][0].lane[lane] = static_cast<std::int32_t>(energy & 0xFF'FFFF);
      lanes.energy[word][1].lane[lane] = static_cast<std::int32_t>(energy >> 24);
    }
    lanes.interacted.lane[lane] = static_cast<std::int32_t>(ray.interacted);
    lanes.opacity.lane[lane] = static_cast<std::int32_t>(ray.opacity);
  }

  // Sets the words that are constant until the ray is scattered.
  void put_flight(FlightLanes& lanes, std::size_t lane, const RayState& ray) const {
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
    lanes.ray.lane[lane] = static_cast<std::int32_t>(slots_[lane].flight - flights_.data());
    if (kind_ == FlightKind::kRendering) return;
    lanes.phase.lane[lane] = static_cast<std::int32_t>(energy_phase(ray, frame_));
    const std::uint64_t loss = draw(RandomStream::kLoss, ray.u, ray.v, ray.lifetime, frame_.seed);
    lanes.loss[0].lane[lane] = static_cast<std::int32_t>(loss);
    lanes.loss[1].lane[lane] = static_cast<std::int32_t>(loss >> 32);
  }

  void take(const FlightLanes& lanes, std::size_t lane) {
    Flight& flight = *slots_[lane].flight;
    RayState& ray = flight.ray_state;
    const std::int32_t taken = lanes.taken.lane[lane];
    if (taken == 0) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ray.position[axis] = lanes.position[axis].lane[lane];
      if (frame_.wide) ray.rest[axis] = static_cast<std::uint16_t>(lanes.rest[axis].lane[lane]);
    }
    ray.under_way = true;
    if (lanes.trapped.lane[lane] == 0) leave_surface(ray);
    ray.interacted = static_cast<std::uint32_t>(lanes.interacted.lane[lane]);
    if (kind_ == FlightKind::kRendering) {
      ray.opacity = static_cast<std::uint32_t>(lanes.opacity.lane[lane]);
      return;
    }
    for (std::size_t word = 0; word < words_of(kind_); ++word) {
      ray.set_energy(word, static_cast<std::uint64_t>(lanes.energy[word][0].lane[lane]) |
                               static_cast<std::uint64_t>(lanes.energy[word][1].lane[lane]) << 24);
    }
  }

  std::span<Flight> flights_;
  FlightKind kind_;
  const Frame& frame_;
  RayCounters& counters_;
  std::array<Slot, 16> slots_{};
  std::size_t next_ = 0, busy_ = 0;
  ShadingQueue seen_;
};

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
