#include "extinction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "reference/camera.h"

namespace gicube::reference::paths {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where, from 0 on, a line is inside the box and on the kept side of all planes.
Interval kept(Vec3 origin, Vec3 direction, Vec3 high, Vec3 spacing, const std::vector<CutPlane>& planes) {
  Interval out{0, kInfinity};
  const auto keep = [&](Vec3 normal, double offset) {  // normal . p >= offset
    const double slope = dot(normal, direction), above = dot(normal, origin) - offset;
    if (slope > 0) out.begin = std::max(out.begin, -above / slope);
    if (slope < 0) out.end = std::min(out.end, -above / slope);
    if (slope == 0 && above < 0) out.end = -1;
  };
  keep({1, 0, 0}, 0), keep({0, 1, 0}, 0), keep({0, 0, 1}, 0);
  keep({-1, 0, 0}, -high.x), keep({0, -1, 0}, -high.y), keep({0, 0, -1}, -high.z);
  for (const CutPlane& plane : planes) {
    keep({plane.normal.x / spacing.x, plane.normal.y / spacing.y, plane.normal.z / spacing.z}, plane.offset);
  }
  return out;
}

bool reflects(Bsdf bsdf) { return bsdf == Bsdf::kSpecular || bsdf == Bsdf::kDullReflection || bsdf == Bsdf::kDiffuse; }

bool depends_on_normal(const Material& material) {
  return reflects(material.bsdf) || (material.bsdf == Bsdf::kTrap && material.routine == kFresnelRoutine);
}

// The greatest opacity of the values from `low` to `high`: at an end, at a point between them, or on either side of a
// step.
double max_opacity(const TransferFunction& function, double low, double high) {
  if (function.opacities.empty()) return 0;
  double most = std::max(function.opacity_at(low), function.opacity_at(high));
  for (const OpacityPoint& point : function.opacities) {
    if (point.value >= low && point.value <= high) most = std::max(most, point.opacity);
  }
  return most;
}

}  // namespace

Extinction::Extinction(const PathScene& scene, const Field& field)
    : scene_(scene), field_(field), solids_(scene, field), spacing_(field.spacing()) {
  const Dims dims = field.volume().dims;
  std::vector<double> values;
  for (int z = 0; z < dims[2]; ++z) {
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x) {
        values.push_back(field.sample({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}).value);
      }
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) cubes_[axis] = dims[axis] - 1;
  for (int z = 0; z < cubes_[2]; ++z) {
    for (int y = 0; y < cubes_[1]; ++y) {
      for (int x = 0; x < cubes_[0]; ++x) bounds_.push_back(bound_of_cube({x, y, z}, values));
    }
  }
  any_ = std::any_of(bounds_.begin(), bounds_.end(), [](double bound) { return bound > 0; });
  if (std::none_of(scene.materials.begin(), scene.materials.end(), depends_on_normal)) return;
  for (int z = 0; z < dims[2]; ++z) {
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x) {
        const Vec3 g = field.voxel_gradient(x, y, z);
        gradients_.push_back({static_cast<float>(g.x), static_cast<float>(g.y), static_cast<float>(g.z)});
      }
    }
  }
}

Vec3 Extinction::gradient(Vec3 position) const {
  if (gradients_.empty()) return {};
  const Dims dims = field_.volume().dims;
  const Vec3 voxel = voxel_of(position);
  const std::array<double, 3> place{voxel.x, voxel.y, voxel.z};
  std::array<std::array<double, 2>, 3> weights{};
  std::array<std::size_t, 3> first{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = std::clamp(place[axis], 0.0, dims[axis] - 1.0);
    first[axis] = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(dims[axis]) - 2);
    weights[axis][1] = at - static_cast<double>(first[axis]);
    weights[axis][0] = 1 - weights[axis][1];
  }
  Vec3 sum;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const std::size_t x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    const auto nx = static_cast<std::size_t>(dims[0]), ny = static_cast<std::size_t>(dims[1]);
    const auto& [gx, gy, gz] = gradients_[((first[2] + z) * ny + first[1] + y) * nx + first[0] + x];
    sum = sum + weights[0][x] * weights[1][y] * weights[2][z] * Vec3{gx, gy, gz};
  }
  return sum;
}

// The bound in the cube whose voxel of least coordinates is `low`.
double Extinction::bound_of_cube(const std::array<int, 3>& low, const std::vector<double>& values) const {
  const Dims dims = field_.volume().dims;
  double least = kInfinity, most = -kInfinity;
  std::array<bool, 4> tags{};
  for (int corner = 0; corner < 8; ++corner) {
    const int x = low[0] + (corner & 1), y = low[1] + (corner >> 1 & 1), z = low[2] + (corner >> 2);
    const double value = values[static_cast<std::size_t>((z * dims[1] + y) * dims[0] + x)];
    least = std::min(least, value), most = std::max(most, value);
    tags[static_cast<std::size_t>(
        field_.tag({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}))] = true;
  }
  // A hair more on both sides: interpolation rounds.
  const double hair = 1e-9 * (std::abs(least) + std::abs(most));
  double opacity = 0;
  for (std::size_t tag = 0; tag < tags.size(); ++tag) {
    if (tags[tag] && !scene_.surfaces[tag])
      opacity = std::max(opacity, max_opacity(scene_.scene.functions[tag], least - hair, most + hair));
  }
  return extinction_of(opacity);
}

double Extinction::extinction_of(double opacity) const {
  if (opacity == 0) return 0;
  return opacity < 1 ? std::min(-std::log1p(-opacity), scene_.max_extinction) : scene_.max_extinction;
}

Extinction::Site Extinction::site(Vec3 position) const {
  const Dims dims = field_.volume().dims;
  Vec3 voxel = voxel_of(position);
  voxel = {std::clamp(voxel.x, 0.0, dims[0] - 1.0), std::clamp(voxel.y, 0.0, dims[1] - 1.0),
           std::clamp(voxel.z, 0.0, dims[2] - 1.0)};
  const int tag = field_.tag(voxel);
  const auto index = static_cast<std::size_t>(tag);
  const TransferFunction& function = scene_.scene.functions[index];
  if (function.opacities.empty() || scene_.surfaces[index]) return {0, tag};
  const Material& material = scene_.materials[index];
  const double all = extinction_of(function.opacity_at(field_.sample(voxel).value));
  return {material.bsdf == Bsdf::kNone ? (1 - material.scattering) * all : all, tag};
}

double Extinction::real_share(Flight& flight, Vec3 position, double bound, int& tag) const {
  const Site here = site(position);
  tag = here.tag;
  const Bsdf bsdf = scene_.materials[static_cast<std::size_t>(tag)].bsdf;
  if (here.extinction == 0 || bsdf != Bsdf::kTrap) flight.at_surface = false;
  if (here.extinction == 0 || flight.at_surface) return 0;
  if (flight.scattered && reflects(bsdf) && dot(flight.direction, gradient(position)) < 0) return 0;
  return here.extinction / bound;
}

// Calls visit(distance, position, bound) for each tentative collision until it returns false.
template <typename Visit>
void Extinction::track(Flight& flight, double limit, CounterRandom& random, const Visit& visit) const {
  if (!any_) return;
  const Dims dims = field_.volume().dims;
  const Vec3 high = place_of({dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0});
  const Interval inside = kept(flight.origin, flight.direction, high, spacing_, scene_.scene.view.cut_planes);
  const double end = std::min(inside.end, limit);
  if (!(inside.begin < end)) return;
  const Vec3 start = voxel_of(flight.origin + inside.begin * flight.direction), along = voxel_of(flight.direction);
  const std::array<double, 3> from{start.x, start.y, start.z}, step{along.x, along.y, along.z};
  std::array<int, 3> cube{};
  std::array<double, 3> next{kInfinity, kInfinity, kInfinity};  // distance of the cube's face ahead
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cube[axis] = std::clamp(static_cast<int>(std::floor(from[axis])), 0, cubes_[axis] - 1);
    if (step[axis] == 0) continue;
    const double face = cube[axis] + (step[axis] > 0 ? 1.0 : 0.0);
    next[axis] = inside.begin + (face - from[axis]) / step[axis];
  }
  double depth = random.exponential();  // to the next tentative collision
  for (double distance = inside.begin; distance < end;) {
    const auto axis = static_cast<std::size_t>(std::min_element(next.begin(), next.end()) - next.begin());
    const double border = std::min(next[axis], end);
    const double bound = bounds_[static_cast<std::size_t>((cube[2] * cubes_[1] + cube[1]) * cubes_[0] + cube[0])];
    if (bound == 0) {
      flight.at_surface = false;
    } else {
      double t = distance;
      for (; t + depth / bound < border; depth = random.exponential()) {
        t += depth / bound;
        if (!visit(t, flight.origin + t * flight.direction, bound)) return;
      }
      depth -= (border - t) * bound;
    }
    distance = border;
    cube[axis] += step[axis] > 0 ? 1 : -1;
    if (cube[axis] < 0 || cube[axis] >= cubes_[axis]) return;
    next[axis] += 1 / std::abs(step[axis]);
  }
}

std::optional<Collision> Extinction::surface(const Flight& flight, double limit) const {
  if (!solids_.any()) return std::nullopt;
  constexpr double kOff = 1e-7;  // a ray that begins at a surface has left it here
  const Dims dims = field_.volume().dims;
  const Vec3 high = place_of({dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0});
  const Interval part = kept(flight.origin, flight.direction, high, spacing_, scene_.scene.view.cut_planes);
  const auto found = solids_.crossing(voxel_of(flight.origin), voxel_of(flight.direction), std::max(part.begin, kOff),
                                      std::min(part.end, limit), flight.inside);
  if (!found) return std::nullopt;
  const Vec3 slope{found->normal.x / spacing_.x, found->normal.y / spacing_.y, found->normal.z / spacing_.z};
  const Vec3 against = flight.inside ? flight.direction : -1.0 * flight.direction;
  return Collision{flight.origin + found->distance * flight.direction, found->distance, found->tag,
                   slope == Vec3{} ? against : normalise(slope)};
}

std::optional<Collision> Extinction::collide(Flight flight, double limit, CounterRandom& random) const {
  std::optional<Collision> found = surface(flight, limit);
  if (flight.inside) return found;  // nothing scatters within glass
  track(flight, found ? found->distance : limit, random, [&](double distance, Vec3 position, double bound) {
    int tag = 0;
    const double share = real_share(flight, position, bound, tag);
    if (share == 0 || random.uniform() >= share) return true;
    found = Collision{position, distance, tag};
    return false;
  });
  return found;
}

double Extinction::transmittance(Flight flight, double distance, CounterRandom& random) const {
  if (surface(flight, distance)) return 0;
  double passes = 1;
  track(flight, distance, random, [&](double, Vec3 position, double bound) {
    int tag = 0;
    passes *= 1 - real_share(flight, position, bound, tag);
    return passes > 0;
  });
  return passes;
}

}  // namespace gicube::reference::paths
