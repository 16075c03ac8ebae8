#include "exchange.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "scene/program/input_error.h"

namespace gicube::samples {
namespace {

// chosen: share of the light between near parts that their rays may miss. It is taken from the parts' shapes and not from what
// the rays found: if those that found much were divided and those that found little kept, the sum would be too low.
constexpr double kUnseen = 0.05;

// About the mean of f f / (pi r^2) between two elements that touch, times the square of their radius.
double touching_factor(ElementKind a, ElementKind b) {
  if (a == ElementKind::kBox && b == ElementKind::kBox) return 4;
  return a == b ? 0.3 : 1.5;
}

Vec3 physical(Vec3 v, Vec3 edges) { return {v.x * edges.x, v.y * edges.y, v.z * edges.z}; }

// Area of a patch, volume of a box.
double measure_of(const Element& element, Vec3 edges) {
  const Vec3 across = cross(physical(element.u, edges), physical(element.v, edges));
  return element.kind == ElementKind::kPatch ? length(across) : std::abs(dot(across, physical(element.w, edges)));
}

// Half of the longest diagonal or more, and where its middle is.
struct Ball {
  Vec3 centre;
  double radius = 0;
};
Ball ball_of(const Element& element, Vec3 edges) {
  const Vec3 w = element.kind == ElementKind::kBox ? element.w : Vec3{};
  const auto half = [&](Vec3 side) { return 0.5 * length(physical(side, edges)); };
  return {physical(element.origin + 0.5 * (element.u + element.v + w), edges),
          half(element.u) + half(element.v) + half(w)};
}

// Across its longest side.
std::array<Element, 2> halves(const Element& element, Vec3 edges) {
  Vec3 Element::*longest = &Element::u;
  for (Vec3 Element::*side : {&Element::v, &Element::w}) {
    if (side == &Element::w && element.kind == ElementKind::kPatch) continue;
    if (length(physical(element.*side, edges)) > length(physical(element.*longest, edges))) longest = side;
  }
  Element first = element, second = element;
  first.*longest = second.*longest = 0.5 * element.*longest;
  second.origin = element.origin + first.*longest;
  return {first, second};
}

struct Part {
  Element a, b;
  double value = 0;
  double noise = 0;   // standard error from its rays
  double unseen = 0;  // what they may have missed, because its elements are near for their size

  double error() const { return std::max(noise, unseen); }
};

class Division {
 public:
  Division(Board& board, const ExchangeSettings& settings) : board_(board), settings_(settings) {}

  Exchange run(std::vector<Part> parts) {
    measure(parts);
    while (true) {
      const Exchange sum = sum_up();
      const double wished = settings_.error * sum.value;
      if (sum.value == 0 || sum.standard_error <= wished || sum.rays >= settings_.max_rays) return sum;
      divide_worst();
    }
  }

 private:
  // Adds them with their first rays.
  void measure(std::span<const Part> parts) {
    std::vector<Element> elements;
    std::vector<ElementPair> pairs;
    for (const Part& part : parts) {
      const auto at = static_cast<std::uint32_t>(elements.size());
      pairs.push_back({at, at + 1, next_id_++});
      elements.insert(elements.end(), {part.a, part.b});
    }
    const auto factors = board_.pair_factors(
        elements, pairs,
        {.rays = static_cast<std::uint32_t>(settings_.rays), .seed = settings_.seed, .made = settings_.made});
    rays_ += parts.size() * static_cast<std::uint64_t>(settings_.rays);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      Part part = parts[i];
      const double scale = measure_of(part.a, settings_.edges) * measure_of(part.b, settings_.edges);
      const Ball a = ball_of(part.a, settings_.edges), b = ball_of(part.b, settings_.edges);
      part.value = scale * factors[i].transported;
      part.noise = scale * factors[i].standard_error;
      if (length(a.centre - b.centre) <= a.radius + b.radius && factors[i].geometric > 0) {
        const double radius = std::max(a.radius, b.radius);
        part.unseen = kUnseen * scale * touching_factor(part.a.kind, part.b.kind) / (radius * radius);
        part.noise = std::min(part.noise, part.unseen);
      }
      parts_.push_back(part);
    }
  }

  Exchange sum_up() const {
    Exchange sum;
    double squares = 0, unseen = 0;
    for (const Part& part : parts_) {
      sum.value += part.value;
      squares += part.noise * part.noise;
      unseen += part.unseen;
    }
    sum.standard_error = std::hypot(std::sqrt(squares), unseen);
    sum.rays = rays_;
    sum.pairs = parts_.size();
    return sum;
  }

  // Those with the greatest errors, half of all errors together.
  void divide_worst() {
    std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) { return a.error() > b.error(); });
    double all = 0, done = 0;
    for (const Part& part : parts_) all += part.error();
    std::vector<Part> worst, kept, fresh;
    for (const Part& part : parts_) {
      (done < 0.5 * all ? worst : kept).push_back(part);
      done += part.error();
    }
    for (const Part& part : worst) {
      const bool first = ball_of(part.a, settings_.edges).radius >= ball_of(part.b, settings_.edges).radius;
      for (const Element& half : halves(first ? part.a : part.b, settings_.edges)) {
        fresh.push_back({first ? half : part.a, first ? part.b : half});
      }
    }
    parts_ = std::move(kept);
    measure(fresh);
  }

  Board& board_;
  const ExchangeSettings& settings_;
  std::vector<Part> parts_;
  std::uint32_t next_id_ = 0;
  std::uint64_t rays_ = 0;
};

void check(std::span<const Element> elements, const char* list, Vec3 edges) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const double measure = measure_of(elements[i], edges);
    if (measure > 0 && std::isfinite(measure)) continue;
    const bool patch = elements[i].kind == ElementKind::kPatch;
    throw InputError(fmt::format("{}[{}]", list, i), patch ? "a patch of some area" : "a box of some volume",
                     fmt::format("{}", measure));
  }
}

}  // namespace

Exchange exchange_between(Board& board, std::span<const Element> a, std::span<const Element> b,
                          const ExchangeSettings& settings) {
  if (!(settings.error > 0)) {
    throw InputError("settings.error", "a number above 0", fmt::format("{}", settings.error));
  }
  if (settings.rays < 8 || settings.rays > 65'536) {
    throw InputError("settings.rays", "8 to 65536", fmt::format("{}", settings.rays));
  }
  check(a, "a", settings.edges);
  check(b, "b", settings.edges);
  std::vector<Part> parts;
  for (const Element& first : a) {
    for (const Element& second : b) parts.push_back({first, second});
  }
  return Division(board, settings).run(std::move(parts));
}

}  // namespace gicube::samples
