#include "encode/host_ray.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "encode/argument.h"
#include "encode/vectors.h"
#include "gicube/wire/registers.h"
#include "gicube/wire/voxel.h"

namespace gicube {
namespace {

constexpr std::array<char, 3> kAxisNames{'x', 'y', 'z'};
constexpr double kPositionOne = wire::kVoxel;
constexpr double kDirectionOne = 1 << wire::kDirectionFractionBits;
constexpr double kLengthOne = 65536;
constexpr double kMaxLength = wire::kMaxLength / kLengthOne;
constexpr int kEnergyFractionBits = 12;

bool is_segment(RayType type) { return wire::is_segment(static_cast<wire::RayType>(type)); }
bool has_threshold(RayType type) { return wire::has_threshold(static_cast<wire::RayType>(type)); }

bool leaves_sums(const RaySetup& setup) {
  return setup.request.type == RayType::kBackproject && setup.request.words == SumWords::kSums;
}

// The largest energy that a ray's bits can hold [P §4.2].
double max_energy(const RaySetup& setup) {
  const int bits = setup.wide ? 24 : setup.request.albedo == Albedo::kHigh ? 4 : 8;
  return std::ldexp(1, bits) - 1;
}

void check_position(Vec3 at, const char* what, std::size_t index, const char* field, Dims dims) {
  const std::array<double, 3> position = to_array(at);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto name = [&] { return fmt::format("{}[{}].{}.{}", what, index, field, kAxisNames[axis]); };
    expect_within(name, position[axis], 0, dims[axis] - 1);
  }
}

void check_direction(const HostRay& ray, std::size_t index) {
  const std::array<double, 3> direction = to_array(ray.direction);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    expect_finite([&] { return fmt::format("rays[{}].direction.{}", index, kAxisNames[axis]); }, direction[axis]);
  }
  if (ray.direction == Vec3{}) throw BadArgument(fmt::format("rays[{}].direction", index), "any length but 0", "0");
}

std::uint64_t length_word(const HostRay& ray) { return wire::to_nearest(ray.length * kLengthOne); }

std::uint64_t colour_word(const HostRay& ray, const RaySetup& setup) {
  if (is_segment(setup.request.type)) return length_word(ray);
  if (setup.request.type != RayType::kDeposit) return 0;
  return static_cast<std::uint64_t>(std::llround(std::ldexp(ray.energy / setup.energy_unit, kEnergyFractionBits)));
}

// unit(), faster for usual lengths, whose squares neither over- nor underflow.
Vec3 direction_of(Vec3 v) {
  const double square = dot(v, v);
  if (!(square > 1e-100 && square < 1e100)) return unit(v);
  return (1 / std::sqrt(square)) * v;
}

// Physical length of a step; 0 for a ray of length 0. `along`: its direction_of().
double length_of_a_step(const HostRay& ray, Vec3 along, const RaySetup& setup) {
  const std::uint32_t steps = wire::steps_of(static_cast<std::uint32_t>(length_word(ray)), step_word(setup.sampling));
  if (steps == 0) return 0;
  const Vec3 physical = times(along, setup.spacing);
  return ray.length / steps * std::sqrt(dot(physical, physical));
}

// Amount that each step of a kBackproject ray deposits, in units of its field in the packet.
double units_of_a_step(const HostRay& ray, Vec3 along, const RaySetup& setup) {
  const double units = ray.energy * length_of_a_step(ray, along, setup) / setup.energy_unit;
  return leaves_sums(setup) ? units : std::ldexp(units, wire::kAmountFractionBits);
}

void check_energy_of_a_step(const HostRay& ray, std::size_t index, const RaySetup& setup) {
  const auto name = [index] { return fmt::format("rays[{}].energy", index); };
  // Fast path: steps are not longer than requested, and most rays are far from the limit.
  const double longest = setup.sampling.step * std::max({setup.spacing.x, setup.spacing.y, setup.spacing.z});
  if (leaves_sums(setup) && std::abs(ray.energy) * longest < wire::kMaxAmount / 2 * setup.energy_unit) return;
  expect_finite(name, ray.energy);
  const double units = units_of_a_step(ray, direction_of(ray.direction), setup),
               min_units = leaves_sums(setup) ? -wire::kMaxAmount : 0;
  if (units >= min_units && units <= wire::kMaxAmount) return;
  const double one = ray.energy / units;
  expect_within(name(), ray.energy, min_units * one, wire::kMaxAmount * one);
}

}  // namespace

HostRay ray_between(std::uint32_t id, Vec3 from, Vec3 to) {
  const Vec3 way = to - from;
  return {.id = id, .position = from, .direction = way == Vec3{} ? Vec3{0, 0, 1} : way, .length = length(way)};
}

std::optional<HostRay> clip_to_volume(const HostRay& ray, const Dims& dims) {
  const std::array<double, 3> start = to_array(ray.position), along = to_array(ray.direction);
  const double size = length(ray.direction);
  double first = 0, last = ray.length / size;  // in lengths of `direction`
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double end = dims[axis] - 1;
    if (along[axis] == 0) {
      if (start[axis] < 0 || start[axis] > end) return std::nullopt;
      continue;
    }
    const double one = -start[axis] / along[axis], other = (end - start[axis]) / along[axis];
    first = std::max(first, std::min(one, other));
    last = std::min(last, std::max(one, other));
  }
  if (!(last > first)) return std::nullopt;
  const Vec3 entry = ray.position + first * ray.direction;
  HostRay part = ray;
  part.position = {std::clamp(entry.x, 0.0, dims[0] - 1.0), std::clamp(entry.y, 0.0, dims[1] - 1.0),
                   std::clamp(entry.z, 0.0, dims[2] - 1.0)};
  part.length = (last - first) * size;
  return part;
}

std::uint32_t step_word(const View& view) { return wire::to_nearest(view.step * wire::kStepOne); }

void check(const RayRequest& request) {
  const bool is_type = request.type >= RayType::kIntegrate && request.type <= RayType::kBackproject;
  expect(is_type, "request.type", "a RayType", request.type);
  const bool is_good = !has_threshold(request.type) || (request.opacity > 0 && request.opacity <= 1);
  expect(is_good, "request.opacity", "more than 0, at most 1", request.opacity);
  constexpr double kOne = wire::kStepOne;
  expect_within("request.step", request.step, wire::kStepMin / kOne, wire::kStepMax / kOne);
  const bool is_words = request.words == SumWords::kIrradiance || request.words == SumWords::kSums;
  expect(is_words, "request.words", "a SumWords", request.words);
  if (request.type == RayType::kDeposit) expect_within("request.lifetime", request.lifetime, 0, wire::kLifetimeMax);
}

void check(const HostRay& ray, std::size_t index, const RaySetup& setup) {
  check_position(ray.position, "rays", index, "position", setup.dims);
  check_direction(ray, index);
  if (is_segment(setup.request.type)) {
    expect_within([&] { return fmt::format("rays[{}].length", index); }, ray.length, 0, kMaxLength);
  }
  if (setup.request.type == RayType::kBackproject) check_energy_of_a_step(ray, index, setup);
  if (setup.request.type != RayType::kDeposit) return;
  expect_within([&] { return fmt::format("rays[{}].energy", index); }, ray.energy,
                std::ldexp(setup.energy_unit, -kEnergyFractionBits), max_energy(setup) * setup.energy_unit);
}

std::uint32_t opacity_word(double opacity) {
  return std::max(1u, static_cast<std::uint32_t>(std::lround(opacity * wire::kOpacityOne)));
}

wire::TraceHeader trace_header(const RayRequest& request, std::size_t rays) {
  wire::TraceHeader header;
  header.count = static_cast<std::uint32_t>(rays);
  header.type = static_cast<wire::RayType>(request.type);
  if (has_threshold(request.type)) header.opacity = opacity_word(request.opacity);
  if (request.type == RayType::kBackproject) header.words = static_cast<wire::SumWords>(request.words);
  if (request.type != RayType::kDeposit) return header;
  header.albedo = static_cast<wire::Albedo>(request.albedo);
  header.rules = static_cast<wire::EnergyRules>(request.rules);
  return header;
}

wire::Ray to_wire(const HostRay& ray, const RaySetup& setup) {
  const Vec3 along = direction_of(ray.direction);
  const std::array<double, 3> position = to_array(ray.position), direction = to_array(along);
  wire::Ray packet;
  packet.set_host_id(ray.id);
  packet.flags = wire::kHostRay;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    packet.position[axis] = wire::to_nearest(position[axis] * kPositionOne);
    const double d = direction[axis] * kDirectionOne;
    const auto size = static_cast<std::int16_t>(wire::to_nearest(d < 0 ? -d : d));
    packet.direction[axis] = static_cast<std::int16_t>(d < 0 ? -size : size);
  }
  if (setup.request.type == RayType::kIntegrate || setup.request.type == RayType::kFirstHit) return packet;
  packet.set_colour_word(colour_word(ray, setup));
  if (setup.request.type == RayType::kBackproject) {
    const double units = units_of_a_step(ray, along, setup);
    const std::uint32_t size = wire::to_nearest(std::abs(units));
    packet.opacity = (units < 0 ? 0 - size : size) & wire::kOpacityOne;
  }
  if (setup.request.type != RayType::kDeposit) return packet;
  packet.flags |= wire::kLightingRay;
  if (setup.request.albedo == Albedo::kHigh) packet.flags |= wire::kHighAlbedo;
  packet.lifetime = static_cast<std::uint16_t>(setup.request.lifetime);
  return packet;
}

double integral_unit(const HostRay& ray, const RaySetup& setup) {
  constexpr double kDensitySteps = 8.0 * wire::kDensityMax;  // a sample's 12.3 bits over the value range
  return (setup.range.high - setup.range.low) / kDensitySteps *
         length_of_a_step(ray, direction_of(ray.direction), setup);
}

std::uint64_t max_moved(const wire::Ray& packet, const RaySetup& setup) {
  if (!leaves_sums(setup)) return 0;
  const auto size = static_cast<std::uint32_t>(std::abs(wire::sign_extend(packet.opacity, 24)));
  return wire::max_moved(size, static_cast<std::uint32_t>(packet.colour_word()), step_word(setup.sampling));
}

TracedRay integral_from_wire(const wire::Ray& ray, double unit) {
  TracedRay traced = from_wire(ray);
  traced.integral = static_cast<double>(ray.colour_word()) * unit;
  traced.colour = {};
  return traced;
}

TracedRay from_wire(const wire::Ray& ray) {
  TracedRay traced;
  traced.id = ray.host_id();
  traced.position = {ray.position[0] / kPositionOne, ray.position[1] / kPositionOne, ray.position[2] / kPositionOne};
  traced.direction = {ray.direction[0] / kDirectionOne, ray.direction[1] / kDirectionOne,
                      ray.direction[2] / kDirectionOne};
  for (std::size_t c = 0; c < 3; ++c) traced.colour[c] = ray.colour[c] / double{wire::kColourOne};
  traced.opacity = ray.opacity / double{wire::kOpacityOne};
  return traced;
}

}  // namespace gicube
