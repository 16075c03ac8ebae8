#include "encode/camera.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "encode/argument.h"
#include "encode/lights.h"
#include "encode/vectors.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/registers.h"

namespace gicube {
namespace {

constexpr double kFarthest = 1e9;  // chosen: a double still resolves 1e-6 voxel there
constexpr double kMinSine = 1e-6;  // chosen: between up and the line of sight
constexpr double kShortestStep = wire::kStepMin / double{wire::kStepOne};  // voxels
constexpr double kLongestStep = wire::kStepMax / double{wire::kStepOne};
constexpr double kOffsetLimit = 1 << 20;  // voxels; a signed register with 10 fraction bits holds twice that

void check_point(const std::string& field, Vec3 p) {
  expect_within(field + ".x", p.x, -kFarthest, kFarthest);
  expect_within(field + ".y", p.y, -kFarthest, kFarthest);
  expect_within(field + ".z", p.z, -kFarthest, kFarthest);
}

void check_cut_planes(const std::string& name, const std::vector<CutPlane>& planes) {
  const std::size_t max_planes = wire::kMaxCutPlanes;
  expect(planes.size() <= max_planes, name, fmt::format("at most {}", max_planes), planes.size());
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const std::string field = fmt::format("{}[{}]", name, i);
    expect_finite(field + ".normal", planes[i].normal);
    expect(planes[i].normal != Vec3{}, field + ".normal", "any length but 0", 0);
    expect_finite(field + ".offset", planes[i].offset);
    const double distance = planes[i].offset / std::hypot(planes[i].normal.x, planes[i].normal.y, planes[i].normal.z);
    expect(std::abs(distance) < kOffsetLimit, field + ".offset",
           fmt::format("a plane within {} voxels of the origin", kOffsetLimit), fmt::format("{} voxels", distance));
  }
}

void check_lamps(const std::vector<Lamp>& lamps) {
  static_assert(kMaxLamps == wire::kMaxLamps);
  expect(lamps.size() <= kMaxLamps, "lamps", fmt::format("at most {}", kMaxLamps), lamps.size());
  for (std::size_t i = 0; i < lamps.size(); ++i) {
    const std::string field = fmt::format("lamps[{}]", i);
    const Light& light = lamps[i].light;
    const bool has_area = std::holds_alternative<RectangleLight>(light) || std::holds_alternative<SphereLight>(light);
    expect(has_area, field + ".light", "a RectangleLight or a SphereLight", "one without an area");
    check(light, field + ".light");
    for (const double part : lamps[i].colour) {
      expect_within(field + ".colour", part, 0, std::numeric_limits<double>::max());
    }
  }
}

// Checks the fields that View and Sampling share. `where` stands before their names.
void check_sampling(const std::string& where, const auto& sampling) {
  expect_within(where + "opacity_threshold", sampling.opacity_threshold, 0, 1);
  check_cut_planes(where + "cut_planes", sampling.cut_planes);
  expect_within(where + "exposure", sampling.exposure, 0, std::numeric_limits<double>::max());
  expect_within(where + "lifetime", sampling.lifetime, 0, wire::kLifetimeMax);
}

// Copies the fields that View and Sampling share.
void copy_sampling(const auto& from, auto& to) {
  to.jitter = from.jitter;
  to.cut_planes = from.cut_planes;
  to.seed = from.seed;
  to.opacity_threshold = from.opacity_threshold;
  to.shade = from.shade;
  to.irradiance = from.irradiance;
  to.incident = from.incident;
  to.exposure = from.exposure;
  to.scatter = from.scatter;
  to.high_albedo = from.high_albedo;
  to.lifetime = from.lifetime;
}

// Three axes at right angles in physical space.
struct Axes {
  Vec3 forward, right, up;
};

Axes physical_axes(const View& view, Vec3 spacing) {
  const Vec3 forward = unit(times(spacing, view.look_at - view.eye));
  const Vec3 right = unit(cross(forward, unit(times(spacing, view.up))));
  return {forward, right, cross(right, forward)};
}

std::uint32_t to_register(double value, int fraction_bits) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(std::ldexp(value, fraction_bits))));
}

}  // namespace

void check(const View& view) {
  check_point("eye", view.eye);
  check_point("look_at", view.look_at);
  expect(view.eye != view.look_at, "look_at", "a point other than the eye", "the eye");
  expect_finite("up", view.up);
  const bool is_across = length(cross(unit(view.look_at - view.eye), unit(view.up))) > kMinSine;
  expect(is_across, "up", "a direction across the line of sight",
         view.up == Vec3{} ? "the zero vector" : "one along the line of sight");
  expect_within("orthographic_height", view.orthographic_height, 0, kFarthest);
  const bool has_angle = view.orthographic_height != 0 || (view.fov_degrees > 0 && view.fov_degrees < 180);
  expect(has_angle, "fov_degrees", "between 0 and 180, exclusive", view.fov_degrees);
  expect_within("width", view.width, 1, wire::kMaxImageSize);
  expect_within("height", view.height, 1, wire::kMaxImageSize);
  const int samples = view.samples_per_axis;
  expect(samples == 1 || samples == 2 || samples == 4, "samples_per_axis", "1, 2 or 4", samples);
  const bool is_filter = view.filter == PixelFilter::kBox || view.filter == PixelFilter::kTent;
  expect(is_filter, "filter", "kBox or kTent", view.filter);
  expect_within("step", view.step, kShortestStep, kLongestStep);
  check_lamps(view.lamps);
  check_sampling("", view);
}

void check(const Sampling& sampling) {
  const std::string where = "request.sampling.";
  check_point(where + "looking", sampling.looking);
  expect(sampling.looking != Vec3{}, where + "looking", "any length but 0", 0);
  check_sampling(where, sampling);
}

Sampling sampling_of(const View& view) {
  Sampling sampling;
  copy_sampling(view, sampling);
  if (view.look_at != view.eye) sampling.looking = view.look_at - view.eye;
  return sampling;
}

View view_of(const RayRequest& request) {
  const Sampling& from = request.sampling;
  View view;
  view.look_at = from.looking;
  if (std::abs(unit(from.looking).y) > 0.9) view.up = {0, 0, 1};  // it must not be parallel to the line of sight
  view.step = request.step;
  view.leap = request.leap;
  copy_sampling(from, view);
  return view;
}

wire::RenderCommand viewing_command(const View& view, Vec3 relative_spacing) {
  const bool orthographic = view.orthographic_height > 0;
  const Axes axes = physical_axes(view, relative_spacing);
  const double image_height =
      orthographic ? view.orthographic_height : 2 * std::tan(view.fov_degrees * std::numbers::pi / 360);
  const double pixel = image_height / view.height;
  // From the image's middle to its top left corner.
  const Vec3 corner = (-0.5 * view.width * pixel) * axes.right + (0.5 * view.height * pixel) * axes.up;
  const Vec3 forward = orthographic ? axes.forward : axes.forward + corner;
  const Vec3 to_origin = orthographic ? corner : Vec3{};

  wire::RenderCommand command;
  command.width = static_cast<std::uint16_t>(view.width);
  command.height = static_cast<std::uint16_t>(view.height);
  command.projection = orthographic ? wire::Projection::kOrthographic : wire::Projection::kPerspective;
  command.samples_per_axis = static_cast<std::uint8_t>(view.samples_per_axis);
  command.filter = view.filter == PixelFilter::kTent ? wire::Filter::kTent : wire::Filter::kBox;
  command.origin = to_array(view.eye + over(to_origin, relative_spacing));
  command.forward = to_array(over(forward, relative_spacing));
  command.du = to_array(over(pixel * axes.right, relative_spacing));
  command.dv = to_array(over(-pixel * axes.up, relative_spacing));
  return command;
}

Vec3 towards_eye(const View& view, Vec3 relative_spacing) {
  return unit(times(relative_spacing, view.eye - view.look_at));
}

std::array<std::uint32_t, 4> cut_plane_words(const CutPlane& plane) {
  const Vec3 normal = unit(plane.normal);
  const double size = std::hypot(plane.normal.x, plane.normal.y, plane.normal.z);
  return {to_register(normal.x, wire::kDirectionFractionBits), to_register(normal.y, wire::kDirectionFractionBits),
          to_register(normal.z, wire::kDirectionFractionBits),
          to_register(plane.offset / size, wire::kCutOffsetFractionBits)};
}

}  // namespace gicube
