#include "radix_k.h"

#include <algorithm>
#include <cstring>

#include "gicube/error.h"

namespace gicube {
namespace {

struct Region {
  std::size_t begin = 0, end = 0;  // pixels
  Region part(int i, int k) const {
    const auto at = [&](int j) {
      return begin + (end - begin) * static_cast<std::size_t>(j) / static_cast<std::size_t>(k);
    };
    return {at(i), at(i + 1)};
  }
};

// Before `count` pixels of a message.
struct Run {
  std::uint32_t begin = 0, count = 0;
};

bool active(const FloatPixel& pixel) {
  return pixel.alpha != 0 || pixel.red != 0 || pixel.green != 0 || pixel.blue != 0;
}

std::vector<std::uint8_t> encode(std::span<const FloatPixel> pixels, const Region& region) {
  std::vector<std::uint8_t> message;
  const auto put = [&message](const void* data, std::size_t bytes) {
    const auto* const from = static_cast<const std::uint8_t*>(data);
    message.insert(message.end(), from, from + bytes);
  };
  for (std::size_t i = region.begin; i < region.end;) {
    if (!active(pixels[i])) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < region.end && active(pixels[end])) ++end;
    const Run run{static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(end - i)};
    put(&run, sizeof run);
    put(&pixels[i], (end - i) * sizeof(FloatPixel));
    i = end;
  }
  return message;
}

// Calls use(number, pixel) of each.
template <typename Use>
void decode(std::span<const std::uint8_t> message, const Region& region, const Use& use) {
  while (!message.empty()) {
    Run run;
    if (message.size() < sizeof run) throw Error("a picture's part from another rank is cut off");
    std::memcpy(&run, message.data(), sizeof run);
    message = message.subspan(sizeof run);
    if (run.begin < region.begin || std::size_t{run.begin} + run.count > region.end ||
        message.size() / sizeof(FloatPixel) < run.count) {
      throw Error("a picture's part from another rank has pixels beyond its own: do all ranks render the same view?");
    }
    for (std::uint32_t i = 0; i < run.count; ++i) {
      FloatPixel pixel;
      std::memcpy(&pixel, message.data() + i * sizeof pixel, sizeof pixel);
      use(run.begin + i, pixel);
    }
    message = message.subspan(run.count * sizeof(FloatPixel));
  }
}

void add_behind(FloatPixel& front, const FloatPixel& back, float threshold) {
  if (front.alpha >= threshold) return;
  const float clear = 1 - front.alpha;
  front.red += clear * back.red;
  front.green += clear * back.green;
  front.blue += clear * back.blue;
  front.alpha += clear * back.alpha;
}

}  // namespace

std::vector<int> radices(int ranks) {
  constexpr int kMost = 8;  // chosen: more messages at a time in fewer rounds
  std::vector<int> out;
  for (int left = ranks; left > 1; left /= out.back()) {
    int k = kMost;
    while (k > 1 && left % k != 0) --k;
    out.push_back(k > 1 ? k : left);
  }
  return out;
}

std::vector<FloatPixel> composite(RayExchange& exchange, std::span<const int> order, std::vector<FloatPixel> pixels,
                                  float threshold, std::uint64_t& bytes_sent) {
  const auto ranks = static_cast<std::size_t>(exchange.ranks()), me = static_cast<std::size_t>(exchange.rank());
  const int place = static_cast<int>(std::ranges::find(order, exchange.rank()) - order.begin());
  const auto rank_at = [&](int at) { return static_cast<std::size_t>(order[static_cast<std::size_t>(at)]); };
  const Region whole{0, pixels.size()};
  Region own = whole;
  int stride = 1;  // of the group's places; each of its members has what `stride` places from its own on see of `own`
  for (const int k : radices(exchange.ranks())) {
    const int member = place / stride % k, first = place - member * stride;
    std::vector<std::vector<std::uint8_t>> to(ranks);
    for (int i = 0; i < k; ++i) {
      auto& message = to[rank_at(first + i * stride)];
      message = encode(pixels, own.part(i, k));
      if (i != member) bytes_sent += message.size();
    }
    const auto from = exchange.exchange(std::move(to));
    own = own.part(member, k);
    std::fill(pixels.begin() + static_cast<std::ptrdiff_t>(own.begin),
              pixels.begin() + static_cast<std::ptrdiff_t>(own.end), FloatPixel{});
    for (int i = 0; i < k; ++i) {
      decode(from[rank_at(first + i * stride)], own,
             [&](std::size_t at, const FloatPixel& pixel) { add_behind(pixels[at], pixel, threshold); });
    }
    stride *= k;
  }
  std::vector<std::vector<std::uint8_t>> to(ranks);
  if (me != 0) to[0] = encode(pixels, own);
  const auto from = exchange.exchange(std::move(to));
  if (me != 0) return {};
  std::fill(pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(own.begin), FloatPixel{});
  std::fill(pixels.begin() + static_cast<std::ptrdiff_t>(own.end), pixels.end(), FloatPixel{});
  for (const auto& message : from) {
    decode(message, whole, [&](std::size_t at, const FloatPixel& pixel) { pixels[at] = pixel; });
  }
  return pixels;
}

}  // namespace gicube
