#include "firmware/lighting_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "firmware/low_discrepancy.h"
#include "gicube/wire/registers.h"

namespace gicube::emu {

namespace {

using std::numbers::pi;

constexpr double kFarthest = 1e9;    // chosen: squares and products of coordinates stay far from the limits of doubles
constexpr double kMinLength = 1e-6;  // chosen
constexpr double kNearEdges = 4;     // chosen: the error of eq. 1 for a whole cell is about (edge / r)^2 / 2 there
constexpr double kInFace = 1e-9;     // chosen: a light this close to a face's plane is in the face
constexpr std::uint64_t kRoundingStream = 1;  // separates the hashes of roundings from those of points

bool all_within(const Vector& v, double limit) {
  return std::all_of(v.begin(), v.end(), [limit](double x) { return std::abs(x) <= limit; });  // false for NaN
}

// The vector may have any finite length except 0.
Vector unit(const Vector& v) {
  const double largest = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
  const Vector moderate{v[0] / largest, v[1] / largest, v[2] / largest};
  return scaled(moderate, 1 / length(moderate));
}

}  // namespace

std::optional<std::string> LightingRays::geometry_fault(const wire::IlluminateCommand& command) {
  const std::string range = "finite numbers of -1e9 to 1e9";
  switch (command.kind) {
    case wire::LightKind::kDirectional:
      if (!all_within(command.u, std::numeric_limits<double>::max())) return "u: expected a finite vector to the light";
      if (command.u == Vector{}) return "u: expected a vector to the light, got 0";
      return std::nullopt;
    case wire::LightKind::kSphere:
      if (!(command.u[0] >= kMinLength && command.u[0] <= kFarthest))
        return "u.x: expected a sphere's radius of 1e-6 to 1e9, got " + std::to_string(command.u[0]);
      break;
    case wire::LightKind::kRectangle: {
      if (!all_within(command.u, kFarthest)) return "u: expected an edge of the rectangle, " + range;
      if (!all_within(command.v, kFarthest)) return "v: expected an edge of the rectangle, " + range;
      const double lu = length(command.u), lv = length(command.v);
      if (lu < kMinLength || lv < kMinLength) return "u, v: expected edges of a rectangle, of at least 1e-6";
      if (length(cross(command.u, command.v)) < 1e-9 * lu * lv)
        return "u, v: expected edges of a rectangle, got parallel vectors";
      break;
    }
    case wire::LightKind::kPoint: break;
  }
  if (!all_within(command.position, kFarthest)) return "position: expected " + range;
  return std::nullopt;
}

std::optional<std::string> LightingRays::fault(const wire::IlluminateCommand& command, const Point& extent) {
  const auto beyond = [](const std::string& field, const std::string& range, auto got) {
    return field + ": expected " + range + ", got " + std::to_string(got);
  };
  if (command.kind > wire::LightKind::kSphere) return beyond("kind", "0..3", static_cast<unsigned>(command.kind));
  if (command.albedo > wire::Albedo::kHigh) return beyond("albedo", "0 or 1", static_cast<unsigned>(command.albedo));
  if (command.rules > wire::EnergyRules::kConserving)
    return beyond("rules", "0 or 1", static_cast<unsigned>(command.rules));
  const std::uint32_t k = command.rays_per_voxel;
  if (k < 1 || k > wire::kMaxRaysPerVoxel) return beyond("rays_per_voxel", "1..4096", k);
  if (command.count < 1) return beyond("count", "at least 1", command.count);
  const std::uint64_t end = std::uint64_t{command.first} + command.count;
  if (end > k) return beyond("first + count", "at most rays_per_voxel, " + std::to_string(k), end);
  if (!std::isfinite(command.energy) || command.energy < 0)
    return beyond("energy", "a finite number of at least 0", command.energy);
  const std::uint64_t rays = FaceCells(extent).count() * k;
  if (rays > std::numeric_limits<std::uint32_t>::max())
    return beyond("rays_per_voxel", "at most 2^32 - 1 rays on all face cells", rays);
  return geometry_fault(command);
}

LightingRays::LightingRays(const wire::IlluminateCommand& command, const Point& extent,
                           const std::array<std::uint32_t, 3>& spacing, unsigned energy_bits, std::uint32_t seed)
    : command_(command),
      cells_(extent),
      extent_(extent),
      max_energy_(static_cast<double>((std::uint64_t{1} << energy_bits) - 1)),
      seed_(seed) {
  // The lights of a pass share its seed, but must have different random numbers.
  for (const Vector& v : {command.position, command.u, command.v}) {
    for (const double x : v) seed_ = hash(seed_, std::bit_cast<std::uint64_t>(x));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    spacing_[axis] = spacing[axis] / static_cast<double>(wire::kSpacingOne);
    box_[axis] = cells_.extent(axis) * spacing_[axis];
    position_[axis] = command.position[axis] * spacing_[axis];
  }
  if (command.kind == wire::LightKind::kRectangle) normal_ = unit(cross(command.u, command.v));
}

std::optional<wire::Ray> LightingRays::make(std::uint64_t i) const {
  const Aim aimed = aim(i);
  if (!(aimed.energy > 0)) return std::nullopt;
  const double dither = to_unit(hash(hash(seed_, kRoundingStream), aimed.number));
  const auto energy = static_cast<std::uint32_t>(std::min(std::floor(aimed.energy + dither), max_energy_));
  if (energy == 0) return std::nullopt;

  Vector direction = difference(aimed.through, aimed.start);
  wire::Ray ray;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    direction[axis] /= spacing_[axis];
    const double units = std::round(aimed.start[axis] / spacing_[axis] * wire::kVoxel);
    ray.position[axis] = static_cast<std::uint32_t>(std::clamp(units, 0.0, static_cast<double>(extent_[axis])));
  }
  direction = unit(direction);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.direction[axis] = static_cast<std::int16_t>(std::round(direction[axis] * (1 << wire::kDirectionFractionBits)));
  }
  ray.set_host_id(aimed.number);
  ray.colour = {0, static_cast<std::uint16_t>(energy & 0xFFF), static_cast<std::uint16_t>(energy >> 12)};
  ray.flags = wire::kLightingRay;
  if (command_.albedo == wire::Albedo::kHigh) ray.flags |= wire::kHighAlbedo;
  return ray;
}

LightingRays::Aim LightingRays::aim(std::uint64_t i) const {
  const std::uint64_t index = i / command_.count;
  const std::uint32_t j = command_.first + static_cast<std::uint32_t>(i % command_.count);
  const FaceCell cell = cells_.cell(index);
  if (is_behind(cell)) return {};
  const std::uint64_t seed = hash(seed_, index << 8);
  const Draws draws{j, seed};
  Aim aimed = command_.kind == wire::LightKind::kDirectional ? aim_directional(cell, draws)
                                                             : aim_from(emitter(draws), cell, draws);
  aimed.number = static_cast<std::uint32_t>(index * command_.rays_per_voxel + j);
  return aimed;
}

LightingRays::Aim LightingRays::aim_directional(const FaceCell& cell, const Draws& draws) const {
  const std::size_t b = (cell.axis + 1) % 3, c = (cell.axis + 2) % 3;
  const Vector towards = unit(command_.u);
  const double cosine = cell.far ? towards[cell.axis] : -towards[cell.axis];
  if (cosine <= 0) return {};
  const auto [s, t] = draws.in_cell();
  const Vector start = on_cell(cell, {(cell.at[0] + s) * spacing_[b], (cell.at[1] + t) * spacing_[c]});
  return {start, difference(start, towards),
          command_.energy * cosine * spacing_[b] * spacing_[c] / command_.rays_per_voxel, 0};
}

LightingRays::Aim LightingRays::aim_from(const Emitter& emitter, const FaceCell& cell, const Draws& draws) const {
  const std::size_t a = cell.axis, b = (a + 1) % 3, c = (a + 2) % 3;
  const bool inside = is_inside(emitter.at);
  const double beyond = cell.far ? box_[a] - emitter.at[a] : emitter.at[a];  // inward distance from the face
  SeenRectangle seen{{cell.at[0] * spacing_[b] - emitter.at[b], cell.at[1] * spacing_[c] - emitter.at[c]},
                     {},
                     inside ? beyond : -beyond};
  if (seen.height < kInFace) return {};
  seen.high = {seen.low[0] + spacing_[b], seen.low[1] + spacing_[c]};

  const auto [s, t] = draws.in_cell();
  const double longest = std::max(spacing_[b], spacing_[c]);
  const Vector centre{(seen.low[0] + seen.high[0]) / 2, (seen.low[1] + seen.high[1]) / 2, seen.height};
  const bool printed_point =
      command_.kind == wire::LightKind::kPoint && command_.rules == wire::EnergyRules::kAsPrinted;
  const bool near = !printed_point && length(centre) < kNearEdges * longest;
  const std::array<double, 2> across =
      near ? point_seen(seen, s, t) : std::array{seen.low[0] + s * spacing_[b], seen.low[1] + t * spacing_[c]};
  const Vector through = on_cell(cell, {emitter.at[b] + across[0], emitter.at[c] + across[1]});

  const Vector segment{across[0], across[1], seen.height};
  const double r = length(segment);
  const double share = command_.energy / command_.rays_per_voxel;
  double energy = 0;
  if (command_.kind == wire::LightKind::kPoint && !printed_point) {
    energy = share * solid_angle(seen) / (4 * pi);
  } else {
    const double least = printed_point ? longest / 2 : 0;
    const double form = seen.height / r * spacing_[b] * spacing_[c] / (pi * std::max(r * r, least * least));
    energy = share * (near ? solid_angle(seen) / pi : form);
  }
  if (command_.kind != wire::LightKind::kPoint)
    energy *= std::max(0.0, dot(difference(through, emitter.at), emitter.normal) / r);
  return {inside ? emitter.at : through, inside ? through : sum(through, difference(through, emitter.at)), energy, 0};
}

bool LightingRays::is_behind(const FaceCell& cell) const {
  if (command_.kind != wire::LightKind::kRectangle) return false;
  const std::size_t b = (cell.axis + 1) % 3, c = (cell.axis + 2) % 3;
  const Vector middle = on_cell(cell, {(cell.at[0] + 0.5) * spacing_[b], (cell.at[1] + 0.5) * spacing_[c]});
  const double above = dot(difference(middle, position_), normal_);
  const double reach = (std::abs(normal_[b]) * spacing_[b] + std::abs(normal_[c]) * spacing_[c]) / 2;
  return above + reach < -1e-6 * length(box_);  // rounding error of a position
}

std::array<double, 2> LightingRays::Draws::in_cell() const {
  return {scrambled_sobol(ray, 0, seed), scrambled_sobol(ray, 1, seed)};
}
std::array<double, 2> LightingRays::Draws::on_emitter() const {
  return {scrambled_sobol(ray, 2, seed), scrambled_sobol(ray, 3, seed)};
}

LightingRays::Emitter LightingRays::emitter(const Draws& draws) const {
  if (command_.kind == wire::LightKind::kPoint) return {position_, {}};
  const auto [s, t] = draws.on_emitter();
  if (command_.kind == wire::LightKind::kRectangle) {
    return {sum(position_, sum(scaled(command_.u, s), scaled(command_.v, t))), normal_};
  }
  const double z = 1 - 2 * s, ring = std::sqrt(std::max(0.0, 1 - z * z)), phi = 2 * pi * t;
  const Vector normal{ring * std::cos(phi), ring * std::sin(phi), z};
  return {sum(position_, scaled(normal, command_.u[0])), normal};
}

bool LightingRays::is_inside(const Vector& physical) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (physical[axis] < 0 || physical[axis] > box_[axis]) return false;
  }
  return true;
}

Vector LightingRays::on_cell(const FaceCell& cell, const std::array<double, 2>& across) const {
  Vector point{};
  point[cell.axis] = cell.far ? box_[cell.axis] : 0;
  point[(cell.axis + 1) % 3] = across[0];
  point[(cell.axis + 2) % 3] = across[1];
  return point;
}

}  // namespace gicube::emu
