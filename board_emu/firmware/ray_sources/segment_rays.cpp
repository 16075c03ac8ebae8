#include "firmware/ray_sources/segment_rays.h"

#include <algorithm>
#include <utility>

#include "datapath/advance.h"
#include "datapath/composite.h"

namespace gicube::emu {

namespace {

// Planes with a normal of length one unit give exact positions: x >= from, and x < to.
Plane from_plane(std::int32_t from) { return {{1, 0, 0}, from}; }
Plane below_plane(std::int32_t to) { return {{-1, 0, 0}, 1 - std::int64_t{to}}; }

// The minimum number of steps after which x is beyond a border.
std::int64_t steps_past(std::int32_t x, std::int32_t step, std::int32_t border) {
  const std::int64_t way = std::int64_t{border} - x;
  return step > 0 ? (way + step - 1) / step : (x - std::int64_t{border}) / -step + 1;
}

std::uint64_t packed(const wire::Ray& ray) { return ray.colour_word() << 24 | ray.opacity; }

wire::Ray unpacked_part(std::uint64_t word) {
  wire::Ray ray;
  ray.set_colour_word(word >> 24);
  ray.opacity = static_cast<std::uint32_t>(word & wire::kOpacityOne);
  return ray;
}

}  // namespace

SegmentRays::SegmentRays(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
                         std::vector<std::int32_t> borders, bool goes_on)
    : command_(command),
      frame_(frame),
      framebuffer_(framebuffer),
      across_(std::uint64_t{command.width} * command.samples_per_axis),
      spacing_(static_cast<std::uint64_t>(kSubPixels) / command.samples_per_axis),
      rows_(ImageRows(command).sample_rows(command.samples_per_axis, command.filter)),
      borders_(std::move(borders)),
      frames_(borders_.size() + 1, frame) {
  framebuffer.begin(command, goes_on);
  for (std::size_t slab = 0; slab < frames_.size(); ++slab) {
    if (slab > 0) frames_[slab].cut_planes.push_back(from_plane(borders_[slab - 1]));
    if (slab < borders_.size()) frames_[slab].cut_planes.push_back(below_plane(borders_[slab]));
  }
  const std::uint64_t samples = across_ * rows_.size();
  first_.reserve(static_cast<std::size_t>(samples) + 1);
  first_.push_back(0);
  waits_for_.reserve(static_cast<std::size_t>(samples));
  for (std::uint64_t sample = 0; sample < samples; ++sample) {
    const std::size_t parts = std::max<std::size_t>(1, parts_of(sample).size());
    waits_for_.push_back(static_cast<std::uint8_t>(parts));
    first_.push_back(first_.back() + parts);
  }
  kept_.resize(static_cast<std::size_t>(count()));
}

std::size_t SegmentRays::slab_of(std::int32_t x) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(borders_, x) - borders_.begin());
}

std::vector<SegmentRays::Part> SegmentRays::parts_of(std::uint64_t sample) const {
  const std::uint16_t u = place(sample % across_), v = place(rows_[sample / across_]);
  const Line line = viewing_line(command_, u / double{kSubPixels}, v / double{kSubPixels});
  std::optional<wire::Ray> whole = viewing_ray(line, u, v, frame_.extent, frame_.cut_planes);
  if (!whole) return {};
  whole->u = u;
  whole->v = v;
  whole->lifetime = frame_.lifetime;
  const Point step = step_vector(whole->direction, frame_.step);
  Point start{};
  for (std::size_t axis = 0; axis < 3; ++axis) start[axis] = static_cast<std::int32_t>(whole->position[axis]);
  std::vector<Part> parts{{slab_of(start[0]), *whole}};
  if (step[0] == 0) return parts;
  for (;;) {
    const std::size_t slab = parts.back().slab;
    if (step[0] > 0 ? slab == borders_.size() : slab == 0) return parts;
    const std::int64_t steps = steps_past(start[0], step[0], borders_[step[0] > 0 ? slab : slab - 1]);
    Part next{0, *whole};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t at = start[axis] + steps * step[axis];
      if (at < 0 || at > frame_.extent[axis]) return parts;
      next.ray.position[axis] = static_cast<std::uint32_t>(at);
    }
    next.slab = slab_of(static_cast<std::int32_t>(next.ray.position[0]));
    parts.push_back(next);
  }
}

std::uint64_t SegmentRays::sample_of(std::uint64_t part) const {
  return static_cast<std::uint64_t>(std::ranges::upper_bound(first_, part) - first_.begin()) - 1;
}

DspTask SegmentRays::making(std::uint64_t i) const {
  const std::uint64_t sample = sample_of(i);
  if (i != first_[sample]) return {.loop = &kMakePart};
  DspTask task{.loop = &kMakeViewingRay};
  task.more_cycles = static_cast<std::uint32_t>(frame_.cut_planes.size()) * kCutRay.interval();
  if (sample % across_ == 0) task.more_cycles += kBeginRow.setup() + kBeginRow.interval();
  return task;
}

// Called after take(): the last segment of a ray composites all of them.
DspTask SegmentRays::taking(std::uint64_t i) const {
  const std::uint64_t sample = sample_of(i), parts = first_[sample + 1] - first_[sample];
  const auto use = [&](std::uint64_t part, std::uint64_t of, SdramUse::Kind kind) {
    return SdramUse{sdram_map::kFramebuffer + framebuffer_.bytes() + part * kBytesPerPart,
                    static_cast<std::uint32_t>(of * kBytesPerPart), kind};
  };
  if (parts > 1 && waits_for_[sample] > 0) return DspTask{.loop = &kKeepPart}.with(use(i, 1, SdramUse::Kind::kWrite));
  DspTask task =
      framebuffer_.task(place(sample % across_), place(rows_[sample / across_]), command_.samples_per_axis == 1);
  if (parts > 1 && task.use_count < DspTask::kMaxUses) {
    task.with(use(first_[sample], parts, SdramUse::Kind::kRead));
    task.more_cycles += static_cast<std::uint32_t>(parts) * kCompositePart.interval();
  }
  return task;
}

std::uint64_t SegmentRays::dsp_cycles(std::uint64_t made, std::uint64_t taken) const {
  const std::uint64_t further = made > samples() ? made - samples() : 0;
  return RaySource::dsp_cycles(made - further, taken - std::min(taken, further)) +
         further * (kMakePart.interval() + kKeepPart.interval() + kCompositePart.interval());
}

std::optional<wire::Ray> SegmentRays::make(std::uint64_t i, RayCounters&) {
  const std::uint64_t sample = sample_of(i);
  const std::vector<Part> parts = parts_of(sample);
  if (parts.empty()) {
    keep(sample, i, {});
    return std::nullopt;
  }
  return parts[static_cast<std::size_t>(i - first_[sample])].ray;
}

void SegmentRays::take(std::uint64_t i, const wire::Ray& ray) { keep(sample_of(i), i, ray); }

void SegmentRays::keep(std::uint64_t sample, std::uint64_t part, const wire::Ray& ray) {
  kept_[part] = packed(ray);
  if (std::atomic_ref(waits_for_[sample]).fetch_sub(1, std::memory_order_acq_rel) == 1) composite(sample);
}

void SegmentRays::composite(std::uint64_t sample) {
  wire::Ray whole;
  for (std::uint64_t part = first_[sample]; part < first_[sample + 1]; ++part) {
    over_premultiplied(whole, unpacked_part(kept_[part]));
  }
  whole.u = place(sample % across_);
  whole.v = place(rows_[sample / across_]);
  framebuffer_.add(whole);
}

// A batch holds the segments of some samples in one slab.
std::size_t SegmentRays::divide(std::size_t rays) {
  batch_samples_ = rays;
  return (static_cast<std::size_t>(samples()) + rays - 1) / rays * frames_.size();
}

std::unique_ptr<RayBatch> SegmentRays::make_batch(std::size_t b) {
  auto batch = std::make_unique<RayBatch>();
  const std::size_t slab = b % frames_.size();
  batch->frame = &frames_[slab];
  const std::uint64_t begin = b / frames_.size() * batch_samples_, end = std::min(samples(), begin + batch_samples_);
  for (std::uint64_t sample = begin; sample < end; ++sample) {
    const std::vector<Part> parts = parts_of(sample);
    if (parts.empty() && slab == 0) keep(sample, first_[sample], {});
    for (std::size_t part = 0; part < parts.size(); ++part) {
      if (parts[part].slab != slab) continue;
      batch->room.push_back(parts[part].ray);
      batch->index.push_back(first_[sample] + part);
    }
  }
  batch->rays = batch->room;
  return batch;
}

void SegmentRays::take_batch(RayBatch& batch) {
  for (std::size_t k = 0; k < batch.rays.size(); ++k) take(batch.index[k], batch.rays[k]);
}

}  // namespace gicube::emu
