// The viewing rays of an image in segments. The segment of each processor is a separate ray, so that all segments of a
// ray are traced at the same time. The DSP stores the results in its SDRAM and composites the segments of a ray in
// order [P §5.4, untested there].
//
// Segments lie between slab boundaries. Without jitter, a segment takes the same samples as the whole ray there.
// Compositing uses words, so that a pixel may differ from that of whole rays by rounding. A segment cannot be ended by
// opaque segments in front of it. With jitter, each segment begins at a position that the ray would have without
// jitter.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "asic/partition.h"
#include "firmware/framebuffer.h"
#include "firmware/viewing_rays.h"
#include "gicube/wire/command.h"
#include "levels/ray_source.h"

namespace gicube::emu {

// One segment. The distance to the next border times a reciprocal gives the steps (1 product of 32 by 16 bits). The
// position takes three products (each 2 multiplications and 2 operations). 12 operations assemble the packet, 8
// accesses send it.
inline constexpr DspLoop kMakePart{"segment of a viewing ray", 2 + 3 * 2, 4 + 3 * 2 + 12, 8};
// A returned segment: its 60 bits of colour and opacity are assembled and stored.
inline constexpr DspLoop kKeepPart{"returned segment", 0, 12, 4 + 2};
// The last segment of a ray. Each segment is read and weighted by the transmittance of those before it (4 products of
// 24 by 24 bits, each 4 multiplications and 4 operations).
inline constexpr DspLoop kCompositePart{"segment into its ray", 16, 16 + 8, 2};

class SegmentRays : public RaySource {
 public:
  static constexpr std::uint64_t kBytesPerPart = 8;

  // Clears the framebuffer, unless `goes_on` continues an image. `borders`: slab boundaries along x, in position units,
  // ascending. All parameters must outlive this object.
  SegmentRays(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
              std::vector<std::int32_t> borders, bool goes_on = false);

  std::uint64_t count() const override { return first_.back(); }
  std::uint64_t samples() const { return first_.size() - 1; }
  std::uint64_t max_under_way() const override { return kViewingRaysUnderWay; }
  DspTask making(std::uint64_t i) const override;
  DspTask taking(std::uint64_t i) const override;
  std::uint64_t dsp_cycles(std::uint64_t made, std::uint64_t taken) const override;
  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override;
  const Frame* frame_of(const wire::Ray& made) const override {
    return &frames_[slab_of(static_cast<std::int32_t>(made.position[0]))];
  }
  void take(std::uint64_t i, const wire::Ray& ray) override;
  void state(Archive::Record& record, std::uint64_t /*begin*/) override { record(kept_, waits_for_); }
  std::size_t divide(std::size_t rays) override;
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override;
  void take_batch(RayBatch& batch) override;

 private:
  struct Part {
    std::size_t slab = 0;
    wire::Ray ray;
  };

  // Segments of a sample. Samples are numbered in rows from the top.
  std::vector<Part> parts_of(std::uint64_t sample) const;
  std::uint64_t sample_of(std::uint64_t part) const;
  std::size_t slab_of(std::int32_t x) const;
  // Stores the result of a segment, or of a sample that misses.
  void keep(std::uint64_t sample, std::uint64_t part, const wire::Ray& ray);
  void composite(std::uint64_t sample);
  std::uint16_t place(std::uint64_t sample) const {
    return static_cast<std::uint16_t>(sample * spacing_ + spacing_ / 2);
  }

  const wire::RenderCommand& command_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  std::uint64_t across_;             // samples per row
  std::uint64_t spacing_;            // distance between samples, in sub-pixels
  std::vector<std::uint16_t> rows_;  // sample rows
  std::vector<std::int32_t> borders_;
  std::vector<Frame> frames_;  // per slab: rays end at its borders
  std::vector<std::uint64_t>
      first_;  // per sample: its first segment; a ray that misses the volume has one, which is never made
  std::vector<std::uint64_t> kept_;      // per segment: colour and opacity
  std::vector<std::uint8_t> waits_for_;  // per sample: segments that have not returned
  std::size_t batch_samples_ = 1;
};

}  // namespace gicube::emu
