#include "plan/pilot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gicube {
namespace {

// chosen: four standard errors, and a quarter of the whole. Most of the error is in few pixels whose rays graze a
// surface: a pilot without the worst of them underestimates mean and variance.
constexpr double kStandardErrors = 4;
constexpr double kMargin = 1.25;
// A feature that none of n pixels shows is in fewer than 3 / n of all, with 95% confidence (rule of three).
constexpr double kRuleOfThree = 3;
constexpr double kLastBit = 1.0 / 255;  // of the framebuffer's colours

using Channels = std::array<double, 4>;

Channels channels(const Pixel& pixel, int channel) {
  Channels all{pixel.red / 255.0, pixel.green / 255.0, pixel.blue / 255.0, pixel.alpha / 4095.0};
  if (channel < 0) return all;
  Channels one{};
  one[static_cast<std::size_t>(channel)] = all[static_cast<std::size_t>(channel)];
  one[3] = all[3] / std::sqrt(3.0);
  return one;
}

struct Squares {
  double error = 0, picture = 0;
};

Squares squares_of(const Pixel& pixel, const Pixel& best, int channel) {
  const auto a = channels(pixel, channel), b = channels(best, channel);
  Squares out;
  for (std::size_t c = 0; c < a.size(); ++c) {
    out.error += (a[c] - b[c]) * (a[c] - b[c]);
    out.picture += b[c] * b[c];
  }
  return out;
}

}  // namespace

View pilot_view(View view, int edge) {
  const double pixels = double(view.width) * view.height;
  const double scale = std::min(1.0, edge / std::sqrt(pixels));
  view.width = std::clamp(static_cast<int>(std::lround(view.width * scale)), 1, view.width);
  view.height = std::clamp(static_cast<int>(std::lround(view.height * scale)), 1, view.height);
  view.samples_per_axis = 1;
  return view;
}

Pilot take_pilot(Board& board, const View& view) {
  const Counters before = board.counters();
  const Picoseconds begin = board.now();
  Pilot pilot;
  pilot.image = board.render(view);
  pilot.time = board.now() - begin;
  pilot.samples = static_cast<double>((board.counters() - before).value("pipeline.samples"));
  return pilot;
}

PilotError pilot_error(const Image& pilot, const Image& best, int channel) {
  const std::size_t count = best.pixels.size();
  const auto n = static_cast<double>(count);
  Squares sum;
  for (std::size_t i = 0; i < count; ++i) {
    const Squares of = squares_of(pilot.pixels[i], best.pixels[i], channel);
    sum.error += of.error;
    sum.picture += of.picture;
  }
  if (sum.picture <= 0) return {0, std::numeric_limits<double>::infinity()};
  const double ratio = sum.error / sum.picture;
  // The linearised variance of a ratio estimator.
  double variance = 0, worst = kLastBit * kLastBit * 4;
  for (std::size_t i = 0; i < count; ++i) {
    const Squares of = squares_of(pilot.pixels[i], best.pixels[i], channel);
    worst = std::max(worst, of.error);
    variance += std::pow(of.error - ratio * of.picture, 2) / std::max(1.0, n - 1);
  }
  const double unseen = kRuleOfThree * worst;
  const double upper = ratio + (kStandardErrors * std::sqrt(variance * n) + unseen) / sum.picture;
  return {std::sqrt(ratio), kMargin * std::sqrt(upper)};
}

PilotError noise_of(const Image& a, const Image& b, int channel) {
  const PilotError both = pilot_error(a, b, channel);
  return {both.estimate / std::sqrt(2.0), both.bound / std::sqrt(2.0)};
}

PilotError bias_of(const Image& a, const Image& b, const Image& best_a, const Image& best_b, int channel) {
  const std::size_t count = a.pixels.size();
  double sum = 0, squares = 0, picture = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Channels c1 = channels(a.pixels[i], channel), c2 = channels(b.pixels[i], channel);
    const Channels d1 = channels(best_a.pixels[i], channel), d2 = channels(best_b.pixels[i], channel);
    double product = 0;
    for (std::size_t c = 0; c < c1.size(); ++c) {
      product += (c1[c] - d1[c]) * (c2[c] - d2[c]);
      picture += d1[c] * d1[c];
    }
    sum += product;
    squares += product * product;
  }
  if (picture <= 0) return {0, std::numeric_limits<double>::infinity()};
  constexpr double kErrors = 2;  // chosen: standard errors
  const double mean = std::max(0.0, sum);
  return {std::sqrt(mean / picture), std::sqrt((mean + kErrors * std::sqrt(squares)) / picture)};
}

double extrapolated_time(const TimePoint& tiny, const TimePoint& small, const TimePoint& large, double rays) {
  const double a = std::min(tiny.time, small.time);
  const double each_small = (small.time - a) / small.rays;  // C + B / sqrt(r)
  if (large.rays <= small.rays) return a + rays * each_small;
  const double each_large = std::max(0.0, large.time - a) / large.rays;
  const double b = std::max(0.0, (each_small - each_large) / (1 / std::sqrt(small.rays) - 1 / std::sqrt(large.rays)));
  const double c = std::max(0.0, each_large - b / std::sqrt(large.rays));
  return a + b * std::sqrt(rays) + c * rays;
}

}  // namespace gicube
