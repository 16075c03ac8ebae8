// The viewing rays of an image, which end in the framebuffer: in rows of samples from the top, or in tiles of pixels
// for batches.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "firmware/framebuffer.h"
#include "firmware/lamps.h"
#include "firmware/viewing_rays.h"
#include "firmware/viewing_runs.h"
#include "gicube/wire/command.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class ImageRays : public RaySource {
 public:
  // Clears the framebuffer, unless `goes_on` continues an image. All parameters must outlive this object.
  ImageRays(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
            const RunRules& rules = {}, const Lamps& lamps = {}, bool goes_on = false)
      : command_(command),
        frame_(frame),
        framebuffer_(framebuffer),
        across_(std::uint64_t{command.width} * command.samples_per_axis),
        spacing_(kSubPixels / command.samples_per_axis),
        rows_(ImageRows(command).sample_rows(command.samples_per_axis, command.filter)),
        tiles_across_((command.width + kTile - 1) / kTile),
        rules_(rules),
        lamps_(lamps) {
    if (!goes_on) framebuffer.clear(command.width, ImageRows(command), command.filter);
  }

  std::uint64_t count() const override { return across_ * rows_.size(); }
  std::uint64_t run_end(std::uint64_t i) const override {
    return in_runs() ? i / across_ * across_ + run_at(timed_, i).end : i + 1;
  }
  std::uint64_t max_under_way() const override { return kViewingRaysUnderWay; }
  DspTask making(std::uint64_t i) const override {
    const bool run = in_runs() && run_end(i) > i + 1;
    DspTask task{.loop = run ? &kMakeRun : &kMakeViewingRay};
    task.more_cycles = static_cast<std::uint32_t>(frame_.cut_planes.size()) * kCutRay.interval() * (run ? 2 : 1);
    if (i % across_ == 0) task.more_cycles += kBeginRowCycles;
    return task;
  }
  DspTask taking(std::uint64_t i) const override {
    return framebuffer_.task(place(i % across_), place_of_row(i / across_), command_.samples_per_axis == 1);
  }
  DspTask looking(const wire::Ray& ray) const override { return lamps_.task(ray); }
  std::uint64_t dsp_cycles(std::uint64_t made, std::uint64_t taken) const override {
    return RaySource::dsp_cycles(in_runs() ? runs_in_batches_.load() : made, taken) +
           (across_ > 1 ? made / across_ * kBeginRowCycles : 0);
  }

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters&) override {
    wire::Ray miss;
    const std::uint16_t u = place(i % across_), v = place_of_row(i / across_);
    const auto ray = in_runs() ? extrapolated(run_at(made_, i), i % across_, v, miss) : viewing_ray_at(u, v, miss);
    if (!ray) framebuffer_.add(miss);
    return ray;
  }
  void take(std::uint64_t, const wire::Ray& ray) override { framebuffer_.add(lamps_.seen_by(ray)); }

  std::size_t divide(std::size_t) override {
    const std::size_t rows = tile_rows();
    return static_cast<std::size_t>(tiles_across_) * ((rows_.size() + rows - 1) / rows);
  }
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override {
    auto batch = std::make_unique<RayBatch>();
    const int left = static_cast<int>(b) % tiles_across_ * kTile;
    const int right = std::min(left + kTile, int{command_.width});
    const std::size_t top = b / static_cast<std::size_t>(tiles_across_) * tile_rows();
    const std::size_t bottom = std::min(top + tile_rows(), rows_.size());
    const int samples = command_.samples_per_axis;
    batch->room.reserve(static_cast<std::size_t>((right - left) * samples) * (bottom - top));
    const auto keep = [&](const std::optional<wire::Ray>& ray, const wire::Ray& miss) {
      if (ray) {
        batch->room.push_back(*ray);
      } else {
        framebuffer_.add_alone(miss);  // tiles share no pixels
      }
    };
    for (std::size_t row = top; row < bottom; ++row) {
      wire::Ray miss;
      const std::uint16_t v = place_of_row(row);
      const auto begin = static_cast<std::uint64_t>(left * samples), end = static_cast<std::uint64_t>(right * samples);
      if (in_runs()) {
        for_each_of_runs(v, begin, end,
                         [&](const ViewingRun& run, std::uint64_t i) { keep(extrapolated(run, i, v, miss), miss); });
        continue;
      }
      for (std::uint64_t i = begin; i < end; ++i) keep(viewing_ray_at(place(i), v, miss), miss);
    }
    batch->rays = batch->room;
    return batch;
  }
  void take_batch(RayBatch& batch) override {
    for (const wire::Ray& ray : batch.rays) framebuffer_.add_alone(lamps_.seen_by(ray));
  }

 private:
  static constexpr std::uint32_t kBeginRowCycles = kBeginRow.setup() + kBeginRow.interval();
  static constexpr int kTile = 16;  // pixels per edge; chosen: the voxels of a tile's rays fit into a core's cache

  // Runs for a range of samples in a row. No run crosses its ends.
  struct Runs {
    std::uint64_t row = ~std::uint64_t{0};
    std::uint64_t begin = 0, end = 0;
    std::vector<ViewingRun> runs;
  };

  // Rows of samples in a tile.
  std::size_t tile_rows() const { return static_cast<std::size_t>(kTile) * command_.samples_per_axis; }

  bool in_runs() const { return rules_.rays > 1; }

  // New runs start at each multiple of their maximum length, so that a tile does not depend on the rest of the row.
  std::vector<ViewingRun> runs_of(std::uint16_t v, std::uint64_t begin) const {
    const std::uint64_t end = std::min(across_, begin + rules_.rays);
    const auto line = [&](std::uint64_t i) {
      return viewing_line(command_, place(i) / double{kSubPixels}, v / double{kSubPixels});
    };
    return viewing_runs(begin, end, rules_, line, frame_.extent, frame_.cut_planes);
  }
  const ViewingRun& run_at(Runs& known, std::uint64_t i) const {
    const std::uint64_t row = i / across_, at = i % across_;
    if (row != known.row || at < known.begin || at >= known.end) {
      known.row = row;
      known.begin = at / rules_.rays * rules_.rays;
      known.runs = runs_of(place_of_row(row), known.begin);
      known.end = known.runs.back().end;
    }
    return *std::ranges::find_if(known.runs, [at](const ViewingRun& run) { return at < run.end; });
  }
  template <typename Use>
  void for_each_of_runs(std::uint16_t v, std::uint64_t begin, std::uint64_t end, const Use& use) {
    for (std::uint64_t at = begin / rules_.rays * rules_.rays; at < end; at += rules_.rays) {
      for (const ViewingRun& run : runs_of(v, at)) {
        runs_in_batches_ += run.begin >= begin && run.begin < end ? 1 : 0;
        for (std::uint64_t i = std::max(begin, run.begin); i < std::min(end, run.end); ++i) use(run, i);
      }
    }
  }

  // Position of a sample along u or v, 12.4 pixels.
  std::uint16_t place(std::uint64_t sample) const {
    return static_cast<std::uint16_t>(sample * static_cast<unsigned>(spacing_) + static_cast<unsigned>(spacing_) / 2);
  }

  std::uint16_t place_of_row(std::uint64_t row) const { return place(rows_[row]); }

  // The ray for an image position, 12.4 pixels. If there is none, `miss` is what the framebuffer receives.
  std::optional<wire::Ray> viewing_ray_at(std::uint16_t u, std::uint16_t v, wire::Ray& miss) const {
    const Line line = viewing_line(command_, u / double{kSubPixels}, v / double{kSubPixels});
    return placed(viewing_ray(line, u, v, frame_.extent, frame_.cut_planes), u, v, miss);
  }
  std::optional<wire::Ray> extrapolated(const ViewingRun& run, std::uint64_t sample, std::uint16_t v,
                                        wire::Ray& miss) const {
    return placed(run.ray(sample, frame_.extent), place(sample), v, miss);
  }
  std::optional<wire::Ray> placed(std::optional<wire::Ray> ray, std::uint16_t u, std::uint16_t v,
                                  wire::Ray& miss) const {
    wire::Ray& at = ray ? *ray : miss;
    at.u = u;
    at.v = v;
    if (ray) ray->lifetime = frame_.lifetime;
    return ray;
  }

  const wire::RenderCommand& command_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  std::uint64_t across_;             // rays per row
  int spacing_;                      // distance between samples, in sub-pixels
  std::vector<std::uint16_t> rows_;  // sample rows
  int tiles_across_;
  RunRules rules_;
  Lamps lamps_;
  Runs made_;           // for make(), which may run ahead
  mutable Runs timed_;  // for run_end()
  std::atomic<std::uint64_t> runs_in_batches_ = 0;
};

}  // namespace gicube::emu
