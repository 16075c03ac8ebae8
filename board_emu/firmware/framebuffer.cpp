#include "firmware/framebuffer.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>

#include "gicube/parallel_for.h"

namespace gicube::emu {

namespace {

template <typename T>
void add_atomically(T& sum, T value) {
  std::atomic_ref(sum).fetch_add(value, std::memory_order_relaxed);
}

// sum * to / (weight * from), rounded.
std::uint64_t rescale(std::uint64_t sum, std::uint64_t weight, std::uint64_t from, std::uint64_t to) {
  const std::uint64_t divisor = weight * from;
  return (sum * to + divisor / 2) / divisor;
}

// Calls use(x, y) for the four pixels of the tent filter whose centres, at 8/16, are less than a pixel away.
template <typename Use>
void for_each_in_tent(int u, int v, const Use& use) {
  const int left = (u + kSubPixels / 2) / kSubPixels - 1, top = (v + kSubPixels / 2) / kSubPixels - 1;
  for (const int y : {top, top + 1}) {
    for (const int x : {left, left + 1}) use(x, y);
  }
}

}  // namespace

void Framebuffer::clear(int width, const ImageRows& rows, wire::Filter filter) {
  width_ = width;
  rows_ = rows;
  filter_ = filter;
  sums_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height()), Sum{});
}

void Framebuffer::add(int x, int y, std::uint32_t weight, const wire::Ray& ray) {
  const int row = rows_.place(y);
  if (weight == 0 || x < 0 || x >= width_ || row < 0) return;
  Sum& sum = sums_[index(x, row)];
  for (std::size_t c = 0; c < 3; ++c) add_atomically(sum.colour[c], ray.colour[c] * weight);
  add_atomically(sum.weight, weight);
  add_atomically(sum.opacity, std::uint64_t{ray.opacity} * weight);
}

void Framebuffer::add(const wire::Ray& ray) {
  const int u = ray.u, v = ray.v;
  if (filter_ == wire::Filter::kBox) return add(u / kSubPixels, v / kSubPixels, 1, ray);
  for_each_in_tent(u, v, [&](int x, int y) {
    const int dx = std::abs(u - (x * kSubPixels + kSubPixels / 2));
    const int dy = std::abs(v - (y * kSubPixels + kSubPixels / 2));
    add(x, y, static_cast<std::uint32_t>((kSubPixels - dx) * (kSubPixels - dy)), ray);
  });
}

DspTask Framebuffer::task(int u, int v, bool alone) const {
  if (alone && filter_ == wire::Filter::kBox) {
    constexpr std::uint64_t kFinishedBytes = 8;
    return DspTask{.loop = &kStorePixel}.with(
        {sdram_map::kFramebuffer + index(u / kSubPixels, rows_.place(v / kSubPixels)) * kFinishedBytes, kFinishedBytes,
         SdramUse::Kind::kWrite});
  }
  DspTask task{.loop = &kAddToPixel};
  const auto change = [&](int x, int y) {
    const int row = rows_.place(y);
    if (x < 0 || x >= width_ || row < 0) return;
    task.with({sdram_map::kFramebuffer + index(x, row) * kBytesPerPixel, kBytesPerPixel, SdramUse::Kind::kChange});
  };
  if (filter_ == wire::Filter::kBox) {
    change(u / kSubPixels, v / kSubPixels);
    return task;
  }
  for_each_in_tent(u, v, change);
  if (task.use_count > 1) task.more_cycles = (task.use_count - 1u) * kAddToPixel.interval();
  return task;
}

void Framebuffer::add_alone(const wire::Ray& ray) {
  const int x = ray.u / kSubPixels, row = rows_.place(ray.v / kSubPixels);
  if (filter_ != wire::Filter::kBox || x >= width_ || row < 0) return add(ray);
  Sum& sum = sums_[index(x, row)];
  for (std::size_t c = 0; c < 3; ++c) sum.colour[c] += ray.colour[c];
  sum.weight += 1;
  sum.opacity += ray.opacity;
}

wire::Pixel Framebuffer::resolve(const Sum& sum) {
  if (sum.weight == 0) return {};
  // Most pixels have one ray. The divisor is then a constant, and the compiler avoids the division.
  const auto resolved = [&sum](std::uint64_t value, std::uint64_t from, std::uint64_t to) {
    return sum.weight == 1 ? rescale(value, 1, from, to) : rescale(value, sum.weight, from, to);
  };
  const auto colour = [&](std::size_t c) {
    return static_cast<std::uint8_t>(resolved(sum.colour[c], wire::kColourOne, 255));
  };
  return {colour(0), colour(1), colour(2),
          static_cast<std::uint16_t>(resolved(sum.opacity, wire::kOpacityOne, wire::kColourOne))};
}

std::vector<std::uint8_t> Framebuffer::packed(unsigned threads) const {
  std::vector<std::uint8_t> bytes(wire::packed36_bytes(sums_.size()));
  parallel_for_runs(sums_.size(), pixels_at_once(sums_.size(), threads), threads,
                    [&](std::size_t begin, std::size_t end) {
                      for (std::size_t i = begin; i < end; ++i)
                        wire::store36(bytes, i, wire::to_word(resolve(sums_[i])));
                    });
  return bytes;
}

}  // namespace gicube::emu
