#include "encode/geometric_factor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "gicube/wire/pair.h"

namespace gicube {
namespace {

constexpr double kFlat = 1e-6;  // share of its sides: lower corners are in the plane, but for rounding to floats

// Gauss-Legendre points on 0..1.
struct Rule {
  std::size_t points;
  std::array<double, 4> at, weight;
};
constexpr Rule kTwo{2, {0.21132486540518713, 0.7886751345948129}, {0.5, 0.5}};
constexpr Rule kThree{3, {0.1127016653792583, 0.5, 0.8872983346207417}, {5.0 / 18, 8.0 / 18, 5.0 / 18}};
constexpr Rule kFour{4,
                     {0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970263},
                     {0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692}};

Vec3 normal_of(const Element& flat) { return normalise(cross(flat.u, flat.v)); }

// The outline of a flat element, or of the part in front of a plane. A hole or two parts are joined by edges that run
// to and fro on one line: their contributions to an integral along the outline cancel.
using Polygon = std::vector<Vec3>;

// Chords for a whole turn, and at least for any arc; the coarse outline has half as many. Chosen: a disc's factor is
// then known to about 0.002%.
constexpr int kChordsOfTurn = 32, kChordsOfArc = 4;

// Arcs become chords whose ends are a little outside, so that the area is preserved.
Polygon outline(const Element& flat, bool fine) {
  if (flat.kind == ElementKind::kTriangle) return {flat.origin, flat.origin + flat.u, flat.origin + flat.v};
  if (flat.kind == ElementKind::kPatch) {
    return {flat.origin, flat.origin + flat.u, flat.origin + flat.u + flat.v, flat.origin + flat.v};
  }
  const double turn = 1 - flat.w.y, hole = std::sqrt(flat.w.x);
  const int pairs = std::max(kChordsOfArc / 2, static_cast<int>(std::ceil(turn * kChordsOfTurn / 2)));
  const int chords = fine ? 2 * pairs : pairs;
  const double each = turn / chords, angle = 2 * std::numbers::pi * each;
  const double out = std::sqrt(angle / wire::cosine_sine(each).sine);
  Polygon corners;
  const auto add = [&](double radius, int i) {
    const auto [cosine, sine] = wire::cosine_sine(i * each);
    corners.push_back(flat.origin + (radius * cosine) * flat.u + (radius * sine) * flat.v);
  };
  const bool whole = flat.w.y == 0;
  for (int i = 0; i <= (whole && hole == 0 ? chords - 1 : chords); ++i) add(out, i);
  if (hole == 0 && !whole) corners.push_back(flat.origin);
  for (int i = chords; i >= 0 && hole > 0; --i) add(out * hole, i);
  return corners;
}

template <typename Visit>
void for_each_edge(const Polygon& corners, const Visit& visit) {
  for (std::size_t i = 0; i < corners.size(); ++i) visit(corners[i], corners[(i + 1) % corners.size()]);
}

// The part of a flat element that is in front of another one; empty if there is none.
Polygon seen_by(const Element& other, const Element& flat, bool fine) {
  const Polygon all = outline(flat, fine);
  const Vec3 normal = normal_of(other);
  const auto height = [&](Vec3 corner) { return dot(corner - other.origin, normal); };
  double highest = 0;
  for (const Vec3 corner : all) highest = std::max(highest, height(corner));
  Polygon out;
  if (highest <= kFlat * (length(flat.u) + length(flat.v))) return out;
  for_each_edge(all, [&](Vec3 here, Vec3 next) {
    const double from = height(here), to = height(next);
    if (from >= 0) out.push_back(here);
    if ((from > 0 && to < 0) || (from < 0 && to > 0)) out.push_back(here + (from / (from - to)) * (next - here));
  });
  return out;
}

// Integral of ln r along the edge from `from` to `to`, r the distance from the point.
double log_along(Vec3 point, Vec3 from, Vec3 to) {
  const Vec3 along = normalise(to - from), a = from - point;
  const double begin = dot(a, along), end = dot(to - point, along);
  const double square = std::max(dot(a, a) - begin * begin, 0.0), distance = std::sqrt(square);
  const auto until = [&](double t) {
    const double r2 = square + t * t;
    return (r2 > 0 ? 0.5 * t * std::log(r2) : 0) - t + (distance > 0 ? distance * std::atan2(t, distance) : 0);
  };
  return until(end) - until(begin);
}

// Integral of cos cos / r^2 over two elements in front of each other, from their outlines (Sparrow 1963).
double between(const Polygon& a, const Polygon& b, const Rule& rule) {
  double sum = 0;
  for_each_edge(a, [&](Vec3 a_from, Vec3 a_to) {
    for_each_edge(b, [&](Vec3 b_from, Vec3 b_to) {
      const double size = length(b_to - b_from), along = dot(a_to - a_from, b_to - b_from);
      if (size == 0 || along == 0) return;
      for (std::size_t i = 0; i < rule.points; ++i) {
        sum += rule.weight[i] * along / size * log_along(a_from + rule.at[i] * (a_to - a_from), b_from, b_to);
      }
    });
  });
  return 0.5 * std::abs(sum);
}

// Solid angle of a triangle seen from the origin, signed by its orientation (Van Oosterom and Strackee 1983).
double solid_angle(Vec3 a, Vec3 b, Vec3 c) {
  const double la = length(a), lb = length(b), lc = length(c);
  return 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la);
}

// Solid angle of a flat element, seen from a point in front of it.
double solid_angle(Vec3 point, Element flat, bool fine) {
  flat.origin = flat.origin - point;
  const Polygon corners = outline(flat, fine);
  double sum = 0;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) sum += solid_angle(corners[0], corners[i], corners[i + 1]);
  return std::abs(sum);
}

// A face of a box, its normal outwards.
struct Face {
  Vec3 normal;
  std::array<Vec3, 4> corners, edges;  // edges: directions from each corner to the next, with the normal to their right
};
using Faces = std::array<Face, 6>;

Faces faces_of(const Element& box) {
  Faces faces;
  auto* face = faces.begin();
  const double handed = dot(cross(box.u, box.v), box.w) < 0 ? -1 : 1;
  const std::array<std::array<Vec3, 3>, 3> sides{{{box.u, box.v, box.w}, {box.v, box.w, box.u}, {box.w, box.u, box.v}}};
  for (const auto& [u, v, w] : sides) {
    const Vec3 along = handed * normalise(cross(u, v));
    for (const bool far : {false, true}) {
      face->normal = far ? along : -1.0 * along;
      const Vec3 low = far ? box.origin + w : box.origin;
      face->corners = {low, low + u, low + u + v, low + v};
      if (far != (handed > 0)) std::swap(face->corners[1], face->corners[3]);
      for (std::size_t i = 0; i < 4; ++i) face->edges[i] = normalise(face->corners[(i + 1) % 4] - face->corners[i]);
      ++face;
    }
  }
  return faces;
}

// Integral of 1 / r^2, r from a point `height` above the plane, over the triangle of an edge and the point's foot;
// negative if the foot is beyond the edge. In polar coordinates about the foot, so one dimension is left to integrate
// numerically.
double under_edge(Vec3 a, Vec3 b, Vec3 edge, Vec3 normal, double height) {
  const double distance = dot(cross(a, edge), normal);  // of the foot from the edge's line
  if (distance == 0) return 0;
  const double d = std::abs(distance), first = std::atan2(dot(a, edge), d), last = std::atan2(dot(b, edge), d);
  // The integrand is steep near a right angle: points are concentrated there.
  const auto half = [&](double end) {
    double sum = 0;
    for (std::size_t i = 0; i < kFour.points; ++i) {
      const double left = 1 - kFour.at[i], cosine = std::cos(end * (1 - left * left));
      sum += 2 * left * kFour.weight[i] * std::log1p(d * d / (height * height * cosine * cosine));
    }
    return end * sum;
  };
  return std::copysign(0.5 * (half(last) - half(first)), distance);
}

// Integral of 1 / r^2 over the box, by Gauss's theorem: that of h / r^2 over its faces, h the distance of the point
// from each.
double inverse_square(Vec3 point, const Faces& faces) {
  double sum = 0;
  for (const Face& face : faces) {
    const double height = dot(face.corners[0] - point, face.normal);
    if (height == 0) continue;
    const Vec3 foot = point + height * face.normal;
    for (std::size_t i = 0; i < 4; ++i) {
      sum += height *
             under_edge(face.corners[i] - foot, face.corners[(i + 1) % 4] - foot, face.edges[i], face.normal, height);
    }
  }
  return sum;
}

template <typename Function>
double integral_over(const Element& box, const Rule& rule, const Function& f) {
  double sum = 0;
  for (std::size_t i = 0; i < rule.points; ++i) {
    for (std::size_t j = 0; j < rule.points; ++j) {
      for (std::size_t k = 0; k < rule.points; ++k) {
        const Vec3 point = box.origin + rule.at[i] * box.u + rule.at[j] * box.v + rule.at[k] * box.w;
        sum += rule.weight[i] * rule.weight[j] * rule.weight[k] * f(point);
      }
    }
  }
  return measure_of(box) * sum;
}

}  // namespace

double measure_of(const Element& element) {
  const Vec3 across = cross(element.u, element.v);
  switch (element.kind) {
    case ElementKind::kBox: return std::abs(dot(across, element.w));
    case ElementKind::kTriangle: return 0.5 * length(across);
    case ElementKind::kDisc: return std::numbers::pi * (1 - element.w.x) * (1 - element.w.y) * length(across);
    default: return length(across);
  }
}

GeometricFactor geometric_factor(const Element& a, const Element& b, bool near) {
  const double measures = measure_of(a) * measure_of(b);
  if (measures == 0) return {};
  const auto of = [&](double coarse, double fine) {
    const double scale = 1 / (std::numbers::pi * measures);
    // Rounded to floats, because logarithms differ in their last bits between machines.
    return GeometricFactor{static_cast<float>(scale * fine), static_cast<float>(scale * std::abs(fine - coarse))};
  };
  const bool flat_a = a.kind != ElementKind::kBox, flat_b = b.kind != ElementKind::kBox;
  if (flat_a && flat_b) {
    const Polygon seen_a = seen_by(b, a, true), seen_b = seen_by(a, b, true);
    const bool round = a.kind == ElementKind::kDisc || b.kind == ElementKind::kDisc;
    return of(round ? between(seen_by(b, a, false), seen_by(a, b, false), kThree) : between(seen_a, seen_b, kThree),
              between(seen_a, seen_b, kFour));
  }
  if (flat_a || flat_b) {
    const Element &flat = flat_a ? a : b, &box = flat_a ? b : a;
    const Vec3 normal = normal_of(flat);
    const auto seen = [&](bool fine) {
      return [&flat, normal, fine](Vec3 point) {
        return dot(point - flat.origin, normal) > 0 ? solid_angle(point, flat, fine) : 0;
      };
    };
    return of(integral_over(box, kTwo, seen(false)), integral_over(box, kThree, seen(true)));
  }
  const bool first = measure_of(a) <= measure_of(b);
  const Element &points = first ? a : b, &whole = first ? b : a;
  if (!near) {
    const auto by = [&](const Rule& rule) {
      return integral_over(points, rule, [&](Vec3 from) {
        return integral_over(whole, rule, [&](Vec3 to) { return 1 / dot(to - from, to - from); });
      });
    };
    return of(by(kTwo), by(kThree));
  }
  const Faces faces = faces_of(whole);
  const auto seen = [&](Vec3 point) { return inverse_square(point, faces); };
  return of(integral_over(points, kTwo, seen), integral_over(points, kThree, seen));
}

}  // namespace gicube
