// The framebuffer in the DSP's SDRAM: sums of returned rays, resolved to 36-bit pixels [P §2.1, §3.6].
//
// Sums are integers, so the order in which rays return does not matter. add() may be called from several threads.
#pragma once

#include <cstdint>
#include <vector>

#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {

class Framebuffer {
 public:
  // Sums of one pixel: three colours, a weight (32 bits each) and an opacity (64 bits).
  static constexpr std::uint64_t kBytesPerPixel = 24;

  // A black, transparent image; what was there is gone.
  void clear(int width, int height, wire::Filter filter);

  std::uint64_t memory_bytes() const { return sums_.capacity() * sizeof(Sum); }  // of the host's

  int width() const { return width_; }
  int height() const { return height_; }

  // Adds a returned ray, or one that missed the volume (zero colour and opacity), at its image point (u, v).
  void add(const wire::Ray& ray);
  // The same, from a thread that alone adds to the pixel of (u, v). Atomic sums would cost as much as making the ray.
  void add_alone(const wire::Ray& ray);

  wire::Pixel pixel(int x, int y) const { return resolve(sums_[index(x, y)]); }
  // All pixels in rows from the top, packed 36 bits each: the host's view of the framebuffer. Made on `threads` threads.
  std::vector<std::uint8_t> packed(unsigned threads = 1) const;
  // How many of them a thread packs at a time: even, since two pixels share a byte.
  static std::size_t pixels_at_once(std::size_t pixels, unsigned threads) { return pixels / threads / 2 * 2 + 2; }

 private:
  struct Sum {
    std::uint32_t colour[3] = {0, 0, 0};
    std::uint32_t weight = 0;
    std::uint64_t opacity = 0;
  };

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  void add(int x, int y, std::uint32_t weight, const wire::Ray& ray);
  static wire::Pixel resolve(const Sum& sum);

  int width_ = 0;
  int height_ = 0;
  wire::Filter filter_ = wire::Filter::kBox;
  std::vector<Sum> sums_;
};

}  // namespace gicube::emu
