// The framebuffer in the DSP's SDRAM: sums of returned rays, resolved to 36-bit pixels [P §2.1, §3.6].
//
// Sums are integers, so the order in which rays return does not matter. add() may be called from several threads.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/image_rows.h"
#include "gicube/archive.h"
#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"
#include "levels/dsp_task.h"

namespace gicube::emu {

// A ray into the sums of one pixel: 4 words of the ray are read, the pixel's 6 are read and written. Its address takes a product;
// 8 operations check and form it, 6 take the fields apart, 6 add.
inline constexpr DspLoop kAddToPixel{"pixel", 2, 8 + 6 + 6, 4 + 6 + 6};
// A ray that is its pixel's only one: the pixel's 36 bits are put together, and written in a word of 8 bytes. Nothing is read or added.
inline constexpr DspLoop kStorePixel{"finished pixel", 2, 8 + 6, 4 + 2};

class Framebuffer {
 public:
  // Sums of one pixel: three colours, a weight (32 bits each) and an opacity (64 bits).
  static constexpr std::uint64_t kBytesPerPixel = 24;

  // A black, transparent image; what was there is gone.
  void clear(int width, const ImageRows& rows, wire::Filter filter);
  // Clears it for the rows that a card makes, unless the image `goes_on` that was begun before.
  void begin(const wire::RenderCommand& command, bool goes_on);
  // Whether it was begun for such a command.
  bool is_of(const wire::RenderCommand& command) const {
    return width_ == command.width && filter_ == command.filter && rows_ == ImageRows(command);
  }

  std::uint64_t bytes() const { return std::uint64_t{kBytesPerPixel} * sums_.size(); }  // of the SDRAM
  std::uint64_t memory_bytes() const { return sums_.capacity() * sizeof(Sum); }         // of the host's

  int width() const { return width_; }
  int height() const { return rows_.count(); }  // rows that are here

  // Adds a returned ray, or one that missed the volume (zero colour and opacity), at its image point (u, v). Of an image whose rows
  // are dealt to several cards, others' pixels are left out.
  void add(const wire::Ray& ray);
  // The same, from a thread that alone adds to the pixel of (u, v). Atomic sums would cost as much as making the ray.
  void add_alone(const wire::Ray& ray);

  // What adding a ray at (u, v) costs. `alone`: no other ray has a part in its pixel, if the filter is a box.
  DspTask task(int u, int v, bool alone) const;

  wire::Pixel pixel(int x, int y) const { return resolve(sums_[index(x, y)]); }
  // All pixels in rows from the top, packed 36 bits each: the host's view of the framebuffer. Made on `threads` threads.
  std::vector<std::uint8_t> packed(unsigned threads = 1) const;
  void state(Archive& archive) {
    archive.at_most("width", width_, 0xFFFF);
    rows_.state(archive);
    archive.at_most("filter", filter_, wire::Filter::kTent);
    archive.list("sums", sums_, ~std::uint64_t{0});
    const auto pixels = static_cast<std::uint64_t>(width_) * static_cast<std::uint64_t>(height());
    archive.expect(sums_.size() == pixels, "sums", "those of " + std::to_string(pixels) + " pixels", sums_.size());
  }
  // How many of them a thread packs at a time: even, since two pixels share a byte.
  static std::size_t pixels_at_once(std::size_t pixels, unsigned threads) { return pixels / threads / 2 * 2 + 2; }

 private:
  struct Sum {
    std::uint32_t colour[3] = {0, 0, 0};
    std::uint32_t weight = 0;
    std::uint64_t opacity = 0;

    void state(Archive::Record& record) { record(colour, weight, opacity); }
  };

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  void add(int x, int y, std::uint32_t weight, const wire::Ray& ray);
  static wire::Pixel resolve(const Sum& sum);

  int width_ = 0;
  ImageRows rows_;
  wire::Filter filter_ = wire::Filter::kBox;
  std::vector<Sum> sums_;
};

}  // namespace gicube::emu
