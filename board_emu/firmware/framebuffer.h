// The framebuffer in the DSP's SDRAM: accumulators of returned rays, resolved to 36-bit pixels [P §2.1, §3.6].
//
// The accumulators are integers, so the order in which rays return does not matter. add() is thread-safe.
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

// Adds a ray to one pixel: 4 words of the ray are read, the pixel's 6 are read and written. The address takes a
// product. 8 operations check and form it, 6 extract the fields, 6 add.
inline constexpr DspLoop kAddToPixel{"pixel", 2, 8 + 6 + 6, 4 + 6 + 6};
// A ray that is the only one of its pixel: the pixel's 36 bits are assembled and written as a word of 8 bytes. Nothing
// is read or added.
inline constexpr DspLoop kStorePixel{"finished pixel", 2, 8 + 6, 4 + 2};

class Framebuffer {
 public:
  // Accumulators of one pixel: three colours, a weight (32 bits each) and an opacity (64 bits).
  static constexpr std::uint64_t kBytesPerPixel = 24;

  // Starts a black, transparent image and discards the previous one.
  void clear(int width, const ImageRows& rows, wire::Filter filter);
  // Whether the current image belongs to such a command.
  bool is_of(const wire::RenderCommand& command) const {
    return width_ == command.width && filter_ == command.filter && rows_ == ImageRows(command);
  }

  std::uint64_t memory_bytes() const { return sums_.capacity() * sizeof(Sum); }  // host memory

  int width() const { return width_; }
  int height() const { return rows_.count(); }  // rows on this card

  // Adds a returned ray, or one that missed the volume (zero colour and opacity), at its image point (u, v). If the
  // rows are distributed over several cards, pixels of other cards are ignored.
  void add(const wire::Ray& ray);
  // Like add(), for a thread that is the only one to write the pixel of (u, v). Atomic additions would cost as much as
  // making the ray.
  void add_alone(const wire::Ray& ray);

  // Cost of adding a ray at (u, v). `alone`: with a box filter, no other ray contributes to its pixel.
  DspTask task(int u, int v, bool alone) const;

  wire::Pixel pixel(int x, int y) const { return resolve(sums_[index(x, y)]); }
  // All pixels in rows from the top, packed to 36 bits, as the host reads them. Uses `threads` threads.
  std::vector<std::uint8_t> packed(unsigned threads = 1) const;
  void state(Archive& archive) {
    archive.at_most("width", width_, 0xFFFF);
    rows_.state(archive);
    archive.at_most("filter", filter_, wire::Filter::kTent);
    archive.list("sums", sums_, ~std::uint64_t{0});
    const auto pixels = static_cast<std::uint64_t>(width_) * static_cast<std::uint64_t>(height());
    archive.expect(sums_.size() == pixels, "sums", "those of " + std::to_string(pixels) + " pixels", sums_.size());
  }
  // Number of pixels that a thread packs at a time. It is even, because two pixels share a byte.
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
