#include "cycle/ray_watch.h"

#include "datapath/interaction.h"

namespace gicube::emu {

namespace {

// Recomputes the sample that the pipeline has taken.
RaySample sample_of(const RayState& ray, const Frame& frame, Termination how) {
  RaySample out;
  out.position = ray.position;
  const Sample at = sample_at(ray.position, frame);
  out.density = at.channels[0];
  out.gradient = at.gradient();
  out.tag = at.tag;
  out.end = how;
  if (frame.integral()) return out;
  RayState jittered = ray;
  jitter_step(jittered, frame);
  const wire::SegmentationEntry& entry = at.entry;
  out.colour = is_shaded(jittered, frame) ? shade(entry, out.gradient, frame.reflectance_map)
                                          : Colour12{entry.colour[0], entry.colour[1], entry.colour[2]};
  out.opacity =
      gathers_wide(frame)
          ? static_cast<double>(wide_alpha(frame.wide_depths[at.index], jittered.exponent))
          : static_cast<double>((*frame.opacity_correction)(entry.opacity, jittered.exponent)) / wire::kOpacityOne;
  return out;
}

}  // namespace

void RayWatch::made(Cycle now, std::uint32_t handle, std::uint64_t number, const wire::Ray& ray) {
  if (observer_ == nullptr || !observer_->watches(number, ray)) return;
  watched_[handle] = {.number = number};
  report({.step = RayStep::kMade, .cycle = now, .handle = handle});
}

void RayWatch::made_carrier(std::uint32_t from, std::uint32_t carrier) {
  watched_[carrier] = {.number = watched_[from].number, .is_carrier = true};
}

void RayWatch::after(const RayEvent& event, Termination how) {
  RayEvent whole = event;
  Watched& watched = watched_[event.handle];
  watched.missing = event.count;
  watched.waited = 0;
  whole.ray = watched.number;
  whole.is_carrier = watched.is_carrier;
  whole.block = before_.block;
  whole.state = &rays_[event.handle].ray_state;
  RaySample sample;
  if (event.step == RayStep::kSampled && !watched.is_carrier) {
    sample = sample_of(before_.ray_state, *frame_, how);
    whole.sample = &sample;
  }
  happened(whole);
}

void RayWatch::goes_on(const RayEvent& event) {
  const Watched& watched = watched_[event.handle];
  if (watched.missing == 0) return;
  RayEvent whole = event;
  whole.count = watched.waited;
  report(whole);
}

void RayWatch::report(const RayEvent& event) {
  const auto found = watched_.find(event.handle);
  if (found == watched_.end()) return;
  RayEvent whole = event;
  whole.ray = found->second.number;
  whole.is_carrier = found->second.is_carrier;
  whole.block = rays_[event.handle].block;
  whole.state = &rays_[event.handle].ray_state;
  happened(whole);
  using enum RayStep;
  if (event.step == kGone || event.step == kWaits || event.step == kTaken) watched_.erase(event.handle);
}

}  // namespace gicube::emu
