#include "scene/formats/orientation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

#include "gicube/scene/orientation.h"
#include "scene/common/checks.h"
#include "scene/formats/plane_file.h"

namespace gicube::scene {
namespace {

using Axes = std::array<int, 3>;  // as WorldPlacement::stored
constexpr Axes kSame{1, 2, 3};
constexpr double kSaidDegrees = 1;          // chosen: smaller angles are not visible
constexpr double kLeastDeterminant = 1e-3;  // chosen: of unit vectors that span space

std::size_t index_of(int axis) { return static_cast<std::size_t>(std::abs(axis) - 1); }
double determinant(const std::array<Vec3, 3>& axes) { return dot(cross(axes[0], axes[1]), axes[2]); }

// The placement with unit vectors. Zero vectors, and those that are not finite, stay as they are.
WorldPlacement with_unit_directions(WorldPlacement placement) {
  for (Vec3& direction : placement.directions) direction = unit_or_zero(direction);
  return placement;
}

template <typename Item>
void flip(std::span<Item> items, const Dims& dims, const Axes& axes) {
  const auto row = static_cast<std::size_t>(dims[0]), plane = voxels_of({dims[0], dims[1], 1});
  if (axes[0] < 0 && axes[1] < 0) {
    for (std::size_t at = 0; at < items.size(); at += plane) std::ranges::reverse(items.subspan(at, plane));
  } else if (axes[0] < 0) {
    for (std::size_t at = 0; at < items.size(); at += row) std::ranges::reverse(items.subspan(at, row));
  } else if (axes[1] < 0) {
    for (std::size_t at = 0; at < items.size(); at += plane) {
      for (std::size_t low = 0, high = plane - row; low < high; low += row, high -= row)
        std::ranges::swap_ranges(items.subspan(at + low, row), items.subspan(at + high, row));
    }
  }
  if (axes[2] > 0) return;
  for (std::size_t low = 0, high = items.size() - plane; low < high; low += plane, high -= plane)
    std::ranges::swap_ranges(items.subspan(low, plane), items.subspan(high, plane));
}

// The items in the order of the new axes. `dims`: of the stored ones.
template <typename Item>
std::vector<Item> permuted(std::span<const Item> from, const Dims& dims, const Axes& axes) {
  const std::array<std::ptrdiff_t, 3> steps{1, dims[0], std::ptrdiff_t{dims[0]} * dims[1]};
  std::array<std::ptrdiff_t, 3> step{}, size{};
  std::ptrdiff_t first = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t stored = index_of(axes[i]);
    size[i] = dims[stored];
    step[i] = axes[i] > 0 ? steps[stored] : -steps[stored];
    if (axes[i] < 0) first += (size[i] - 1) * steps[stored];
  }
  std::vector<Item> to;
  to.reserve(from.size());
  for (std::ptrdiff_t z = 0; z < size[2]; ++z) {
    for (std::ptrdiff_t y = 0; y < size[1]; ++y) {
      const std::ptrdiff_t row = first + z * step[2] + y * step[1];
      for (std::ptrdiff_t x = 0; x < size[0]; ++x) to.push_back(from[static_cast<std::size_t>(row + x * step[0])]);
    }
  }
  return to;
}

bool is_flip(const Axes& axes) { return index_of(axes[0]) == 0 && index_of(axes[1]) == 1 && index_of(axes[2]) == 2; }

template <typename Item, typename Stored>
void turn(std::span<Stored> values, const Dims& dims, const Axes& axes) {
  const std::span items(reinterpret_cast<Item*>(values.data()), values.size_bytes() / sizeof(Item));
  if (is_flip(axes)) return flip(items, dims, axes);
  const auto turned = permuted(std::span<const Item>(items), dims, axes);
  std::ranges::copy(turned, items.begin());
}

void turn_samples(std::span<std::byte> samples, SampleType type, const Dims& dims, const Axes& axes) {
  switch (bytes_per_sample(type)) {
    case 1: return turn<std::uint8_t>(samples, dims, axes);
    case 2: return turn<std::uint16_t>(samples, dims, axes);
    default: return turn<std::uint32_t>(samples, dims, axes);
  }
}

using Colour3 = std::array<std::uint8_t, 3>;

// Planes of another reader, turned. `axes` keep z.
PlaneReader turned_planes(PlaneReader planes, std::optional<SampleType> type, Dims dims, Axes axes) {
  return [=, planes = std::move(planes)](int first, int count, std::span<std::byte> out) {
    planes(first, count, out);
    const Dims part{dims[0], dims[1], count};
    if (type) return turn_samples(out, *type, part, axes);
    turn<Colour3>(out, part, axes);
  };
}

}  // namespace

Axes nearest_axes(const std::array<Vec3, 3>& given) {
  std::array<Vec3, 3> directions;
  std::ranges::transform(given, directions.begin(), unit_or_zero);
  if (!(std::abs(determinant(directions)) > kLeastDeterminant)) return {};
  Axes best = kSame;
  double most = -4;
  Axes order{0, 1, 2};
  do {
    for (unsigned signs = 0; signs < 8; ++signs) {
      std::array<Vec3, 3> turned;
      Axes axes{};
      double sum = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const int sign = (signs >> i & 1U) != 0 ? -1 : 1;
        axes[i] = sign * (order[i] + 1);
        turned[i] = sign * directions[static_cast<std::size_t>(order[i])];
        sum += in_order(turned[i])[i];
      }
      if (determinant(turned) > 0 && sum > most + 1e-9) best = axes, most = sum;
    }
  } while (std::ranges::next_permutation(order).found);
  return best;
}

double oblique_degrees(const WorldPlacement& placement) {
  double least = 1;
  for (std::size_t i = 0; i < 3; ++i) least = std::min(least, in_order(placement.directions[i])[i]);
  return std::acos(std::max(least, -1.0)) * 180 / std::numbers::pi;
}

Volume oriented(Volume volume) {
  if (volume.placement.axes == WorldAxes::kNone) return volume;
  const WorldPlacement before = with_unit_directions(volume.placement);
  const Axes axes = nearest_axes(before.directions);
  if (axes == Axes{} || !is_finite(before.origin)) {
    throw FileError(volume.source, "orientation",
                    "an origin and three directions that span space (or the axes as stored)",
                    fmt::format("{}, {} and {}", shown_point(before.directions[0]), shown_point(before.directions[1]),
                                shown_point(before.directions[2])));
  }
  const Dims dims = volume.dims;
  const auto spacing = in_order(volume.spacing);
  std::array<double, 3> edges{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t stored = index_of(axes[i]);
    volume.dims[i] = dims[stored];
    edges[i] = spacing[stored];
    volume.placement.stored[i] = axes[i];
    volume.placement.directions[i] = (axes[i] > 0 ? 1.0 : -1.0) * before.directions[stored];
    if (axes[i] < 0)
      volume.placement.origin = volume.placement.origin + (dims[stored] - 1) * edges[i] * before.directions[stored];
  }
  volume.spacing = {edges[0], edges[1], edges[2]};
  if (const double degrees = oblique_degrees(volume.placement); degrees >= kSaidDegrees) {
    const bool patient = volume.placement.axes == WorldAxes::kPatient;
    warn(volume.source, "orientation", patient ? "axes along the patient's" : "axes along the world's",
         fmt::format("{:.1f} degrees off; the nearest are taken", degrees));
  }
  if (axes == kSame) return volume;
  if (volume.planes && axes[2] != 3) {
    const Dims turned = std::exchange(volume.dims, dims);
    take_planes(volume);
    volume.dims = turned;
  }
  if (volume.planes) {
    volume.planes = turned_planes(std::move(volume.planes), volume.type, dims, axes);
    if (volume.colour_planes)
      volume.colour_planes = turned_planes(std::move(volume.colour_planes), std::nullopt, dims, axes);
    return volume;
  }
  turn_samples(volume.samples, volume.type, dims, axes);
  if (!volume.colours.empty()) turn<Colour3>(std::span(volume.colours), dims, axes);
  return volume;
}

}  // namespace gicube::scene
