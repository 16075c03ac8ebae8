// The viewing rays of an image, which end in the framebuffer: rows of samples from the top, or tiles of pixels in batches.
#pragma once

#include <cstdint>

#include "firmware/framebuffer.h"
#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/command.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class ImageRays : public RaySource {
 public:
  // Clears the framebuffer. All must outlive this.
  ImageRays(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer, const v1::DspConfig& dsp);

  std::uint64_t count() const override { return across_ * command_.height * command_.samples_per_axis; }
  std::uint64_t row_end(std::uint64_t i) const override { return (i / across_ + 1) * across_; }
  std::uint32_t make_cycles() const override { return dsp_.viewing_ray_cycles(); }
  std::uint32_t take_cycles() const override { return dsp_.returned_ray_cycles(); }

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override;
  void take(std::uint64_t, const wire::Ray& ray) override { framebuffer_.add(ray); }

  std::size_t divide(std::size_t rays) override;
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override;
  void take_batch(RayBatch& batch) override;

 private:
  // The ray of a place of the image, 12.4 pixels; else `miss` is what the framebuffer gets for it.
  std::optional<wire::Ray> viewing_ray_at(std::uint16_t u, std::uint16_t v, wire::Ray& miss) const;

  const wire::RenderCommand& command_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  const v1::DspConfig& dsp_;
  std::uint64_t across_;  // rays in a row
  int spacing_;           // between samples, in sub-pixels
  int tiles_across_;
};

}  // namespace gicube::emu
