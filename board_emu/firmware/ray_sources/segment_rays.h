// The viewing rays of an image in segments: each processor's part of a ray is a ray of its own, so that all parts of a ray are cast at the
// same time. The DSP keeps what comes back in its SDRAM and composites the parts of a ray in their order [P §5.4, untested there].
//
// Parts lie between slabs. Without jitter a part's samples are those that the whole ray takes there; it is composited in words, so
// that a pixel may differ by roundings from that of whole rays. A part does not know what lies before it, so that opaque parts
// end no others. With jitter each part begins at a place where the ray would be without.
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

// A part of a ray: the increment to the next border times a reciprocal gives the steps (1 product of 32 by 16 bits), three products the
// place (each 2 multiplications and 2 operations); 12 operations put the packet together, 8 accesses send it.
inline constexpr DspLoop kMakePart{"segment of a viewing ray", 2 + 3 * 2, 4 + 3 * 2 + 12, 8};
// A part that comes back: its 60 bits of colour and opacity are put together and kept.
inline constexpr DspLoop kKeepPart{"returned segment", 0, 12, 4 + 2};
// The last of a ray: each part is read, and is weighted by what the ones before let through (4 products of 24 by 24 bits, each 4
// multiplications and 4 operations).
inline constexpr DspLoop kCompositePart{"segment into its ray", 16, 16 + 8, 2};

class SegmentRays : public RaySource {
 public:
  static constexpr std::uint64_t kBytesPerPart = 8;

  // Clears the framebuffer, unless it `goes_on` with an image that was begun. `borders`: where slabs meet along x, in position units, rising. All must outlive this.
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

  // Of all samples of pixels in rows from the top.
  std::vector<Part> parts_of(std::uint64_t sample) const;
  std::uint64_t sample_of(std::uint64_t part) const;
  std::size_t slab_of(std::int32_t x) const;
  // A part has come back, or there is none.
  void keep(std::uint64_t sample, std::uint64_t part, const wire::Ray& ray);
  void composite(std::uint64_t sample);
  std::uint16_t place(std::uint64_t sample) const {
    return static_cast<std::uint16_t>(sample * spacing_ + spacing_ / 2);
  }

  const wire::RenderCommand& command_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  std::uint64_t across_;             // samples in a row
  std::uint64_t spacing_;            // between samples, in sub-pixels
  std::vector<std::uint16_t> rows_;  // of samples
  std::vector<std::int32_t> borders_;
  std::vector<Frame> frames_;  // by slab: rays end at its borders
  std::vector<std::uint64_t>
      first_;  // by sample, of its parts; a ray that misses the volume has one, which is never made
  std::vector<std::uint64_t> kept_;      // by part: colour and opacity
  std::vector<std::uint8_t> waits_for_;  // by sample: parts
  std::size_t batch_samples_ = 1;
};

}  // namespace gicube::emu
