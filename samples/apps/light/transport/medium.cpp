#include "light/transport/medium.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gicube/scene/error.h"

namespace gicube::samples {
namespace {

// The least value from which on the opacity is at least half of the greatest.
double surface_of(const TransferFunction& look, const ValueRange& range, const std::string& name) {
  double most = 0;
  for (const OpacityPoint& point : look.opacities) most = std::max(most, point.opacity);
  if (!(most > 0)) throw InputError(name + ".opacity", "above 0 somewhere for a surface", "0");
  constexpr int kSteps = 4095;  // densities of the board
  for (int i = 0; i <= kSteps; ++i) {
    const double value = range.low + (range.high - range.low) * i / kSteps;
    if (look.opacity_at(value) >= most / 2) return value;
  }
  throw InputError(name + ".opacity", "above 0 for a value of the volume", "0");
}

TransferFunction stepped(double from, std::optional<double> to) {
  TransferFunction out{{{from, {1, 1, 1}}}, {{from, 0}, {from, 1}}};
  if (to) out.opacities.insert(out.opacities.end(), {{*to, 1}, {*to, 0}});
  return out;
}

}  // namespace

Medium::Tag Medium::tag_of(const TransferFunction& look, const Optics& optics, const ValueRange& range,
                           const std::string& name) {
  if (optics.look == Look::kMedium) return {optics, look, 0, 0};
  const double surface = surface_of(look, range, name);
  constexpr double kSkin = 0.8;  // chosen: of the way to the densest; of a scene's solids 0.8 voxel, more than a step
  return {optics, {}, surface, surface + kSkin * (range.high - surface)};
}

Medium::Medium(Board& board, const SceneSetup& setup, const Progress& progress) : dims_(setup.volume.dims) {
  if (!setup.view.cut_planes.empty())
    throw InputError("cut_plane", "none", std::to_string(setup.view.cut_planes.size()));
  const Vec3 s = setup.volume.spacing;
  spacing_ = 1 / std::min({s.x, s.y, s.z}) * s;
  high_ = place_of({dims_[0] - 1.0, dims_[1] - 1.0, dims_[2] - 1.0});
  samples::load(board, setup, false, progress);
  values_ = board.read_volume({{}, dims_});
  materials_ = setup.tags;
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < setup.materials.size(); ++tag) {
    const std::string name = "material of tag " + std::to_string(tag);
    const Material material = tag < setup.optics.size() ? setup.optics[tag] : Material{};
    const Colour colour = tag < setup.scattering_colours.size() ? setup.scattering_colours[tag] : Colour{1, 1, 1};
    const TransferFunction look = in_values_of(range, setup.materials[tag]);
    if (look.opacities.empty()) continue;
    tags_[tag] = tag_of(look, optics_of(material, colour, name), range, name);
    const Tag& made = tags_[tag];
    if (made.optics.look == Look::kMedium) continue;
    const bool glass = made.optics.look == Look::kGlass;
    board.set_transfer_function(stepped(made.surface, glass ? std::optional(made.body) : std::nullopt),
                                static_cast<int>(tag));
  }
}

double Medium::value(Vec3 voxel) const {
  const std::array<double, 3> place{voxel.x, voxel.y, voxel.z};
  std::array<std::size_t, 3> first{};
  std::array<double, 3> way{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = std::clamp(place[axis], 0.0, dims_[axis] - 1.0);
    first[axis] = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(dims_[axis]) - 2);
    way[axis] = at - static_cast<double>(first[axis]);
  }
  const auto row = static_cast<std::size_t>(dims_[0]), slice = row * static_cast<std::size_t>(dims_[1]);
  const float* at = &values_[first[0] + row * first[1] + slice * first[2]];
  const auto mix = [](double a, double b, double w) { return a + (b - a) * w; };
  const auto plane = [&](const float* p) {
    return mix(mix(p[0], p[1], way[0]), mix(p[row], p[row + 1], way[0]), way[1]);
  };
  return mix(plane(at), plane(at + slice), way[2]);
}

int Medium::tag(Vec3 place) const {
  if (materials_.empty()) return 0;
  const Vec3 voxel = voxel_of(place);
  const auto nearest = [](double v, int size) {
    return static_cast<std::size_t>(std::clamp(std::floor(v + 0.5), 0.0, size - 1.0));
  };
  const auto nx = static_cast<std::size_t>(dims_[0]), ny = static_cast<std::size_t>(dims_[1]);
  return materials_[(nearest(voxel.z, dims_[2]) * ny + nearest(voxel.y, dims_[1])) * nx + nearest(voxel.x, dims_[0])];
}

double Medium::extinction(Vec3 place) const {
  const Tag& tag = tags_[static_cast<std::size_t>(this->tag(place))];
  if (tag.function.opacities.empty()) return 0;
  constexpr double kLeastThrough = 1e-7;  // of an edge: full opacity is as good as that
  return -std::log(std::max(kLeastThrough, 1 - tag.function.opacity_at(value(voxel_of(place)))));
}

std::optional<int> Medium::solid(Vec3 place) const {
  const int tag = this->tag(place);
  const Tag& here = tags_[static_cast<std::size_t>(tag)];
  if (here.optics.look == Look::kMedium || value(voxel_of(place)) < here.surface) return std::nullopt;
  return tag;
}

bool Medium::in_body(Vec3 place) const {
  const Tag& here = tags_[static_cast<std::size_t>(tag(place))];
  return here.optics.look == Look::kGlass && value(voxel_of(place)) >= here.body;
}

Vec3 Medium::normal(Vec3 place) const {
  const Vec3 v = voxel_of(place);
  constexpr double kHalf = 0.5;  // voxel, each way: a scene's surfaces are ramps of one to each side
  const auto slope = [&](Vec3 step) { return value(v - step) - value(v + step); };
  const Vec3 out{slope({kHalf, 0, 0}) / spacing_.x, slope({0, kHalf, 0}) / spacing_.y,
                 slope({0, 0, kHalf}) / spacing_.z};
  return out == Vec3{} ? out : normalise(out);
}

Medium::Span Medium::inside(Vec3 place, Vec3 direction) const {
  Span out{0, std::numeric_limits<double>::infinity()};
  const std::array<double, 3> from{place.x, place.y, place.z}, along{direction.x, direction.y, direction.z},
      high{high_.x, high_.y, high_.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (along[axis] == 0 && (from[axis] < 0 || from[axis] > high[axis])) return {};
    if (along[axis] == 0) continue;
    const double a = -from[axis] / along[axis], b = (high[axis] - from[axis]) / along[axis];
    out.begin = std::max(out.begin, std::min(a, b));
    out.end = std::min(out.end, std::max(a, b));
  }
  return out;
}

}  // namespace gicube::samples
