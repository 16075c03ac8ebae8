#include "scene/geometry/head_shape.h"

namespace gicube::samples {
namespace {

Distance outside_of(Distance d) { return {-d.distance, -1 * d.away}; }

// The union, with a fillet where the solids are within `width` of each other (polynomial smooth minimum). Its gradient
// is the same mix of gradients as its value is of values.
Distance blend(Distance a, Distance b, double width) {
  const double share = std::clamp(0.5 + 0.5 * (b.distance - a.distance) / width, 0.0, 1.0);
  return {share * a.distance + (1 - share) * b.distance - width * share * (1 - share),
          share * a.away + (1 - share) * b.away};
}

Distance carve(Distance from, Distance hollow, double width) {
  return outside_of(blend(outside_of(from), hollow, width));
}

}  // namespace

Distance head_bound(Vec3 p) {
  const Vec3 q{std::abs(p.x), p.y, p.z};  // both sides are alike
  Distance head = ellipsoid_bound(q, {0, 0.1, 0.26}, {0.56, 0.7, 0.6});
  head = blend(head, ellipsoid_bound(q, {0, -0.14, -0.2}, {0.43, 0.5, 0.58}), 0.14);         // face and jaw
  head = blend(head, ellipsoid_bound(q, {0, -0.52, -0.66}, {0.17, 0.14, 0.12}), 0.1);        // chin
  head = blend(head, ellipsoid_bound(q, {0.25, -0.5, -0.16}, {0.13, 0.1, 0.12}), 0.1);       // cheeks
  head = blend(head, ellipsoid_bound(q, {0.17, -0.585, 0.21}, {0.17, 0.06, 0.05}), 0.06);    // brows
  head = carve(head, sphere_distance(q, {0.19, -0.69, 0.07}, 0.13), 0.06);                   // sockets
  head = blend(head, sphere_distance(q, {0.19, -0.52, 0.07}, 0.1), 0.01);                    // eyes
  head = blend(head, capsule_distance(q, {0, -0.6, 0.14}, {0, -0.74, -0.13}, 0.055), 0.07);  // nose
  head = blend(head, ellipsoid_bound(q, {0.06, -0.66, -0.16}, {0.06, 0.07, 0.05}), 0.03);    // nostrils
  head = blend(head, ellipsoid_bound(q, {0, -0.64, -0.365}, {0.16, 0.055, 0.035}), 0.03);    // lips
  head = blend(head, ellipsoid_bound(q, {0, -0.63, -0.435}, {0.13, 0.055, 0.035}), 0.02);
  head = blend(head, capsule_distance(q, {0, 0.14, -0.4}, {0, 0.24, -0.85}, 0.3), 0.12);  // neck
  Distance ear = ellipsoid_bound(q, {0.55, 0.12, 0.02}, {0.07, 0.15, 0.2});
  ear = carve(ear, ellipsoid_bound(q, {0.64, 0.09, 0.03}, {0.06, 0.09, 0.13}), 0.03);
  const double side = std::copysign(1.0, p.x);
  head = blend(head, ear, 0.04);
  head.away.x *= side;
  return head;
}

}  // namespace gicube::samples
