#include "encode/volume/gradients.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <type_traits>

#include "encode/argument.h"
#include "encode/volume/samples.h"
#include "gicube/parallel_for.h"

namespace gicube {
namespace {

constexpr int kRings = 40;         // chosen [H810]
constexpr double kRingScale = 80;  // twice the rings: equal distances along and between rings; 2,038 codes
constexpr int kGridSize = 128;     // chosen: cells of 0.7 degrees, codes 4.5 apart: most have one candidate
constexpr double kUnitTolerance = 1e-3;
constexpr double kDotMargin = 1e-9;  // chosen: far above rounding, far below differences of codes

std::vector<Vec3> ring_directions() {
  std::vector<Vec3> directions{Vec3{}};
  for (int ring = 0; ring < kRings; ++ring) {
    const double colatitude = std::numbers::pi * (ring + 0.5) / kRings;
    const long population = std::lround(kRingScale * std::sin(colatitude));
    // Every second ring is turned by half a step: the largest error falls from 3.3 to 3.2 degrees.
    const double turn = ring % 2 == 0 ? 0.0 : 0.5;
    for (long i = 0; i < population; ++i) {
      const double longitude = 2 * std::numbers::pi * (static_cast<double>(i) + turn) / static_cast<double>(population);
      directions.push_back({std::sin(colatitude) * std::cos(longitude), std::sin(colatitude) * std::sin(longitude),
                            std::cos(colatitude)});
    }
  }
  return directions;
}

wire::GradientEntry quantise(Vec3 v) {
  const auto component = [](double c) {
    return static_cast<std::int16_t>(
        std::clamp<long>(std::lround(wire::kGradientOne * c), -wire::kGradientOne, wire::kGradientOne));
  };
  return {component(v.x), component(v.y), component(v.z)};
}

Vec3 decode(const wire::GradientEntry& entry) {
  return unit({static_cast<double>(entry[0]), static_cast<double>(entry[1]), static_cast<double>(entry[2])});
}

void check_directions(std::span<const Vec3> directions) {
  const bool is_sized = !directions.empty() && directions.size() <= wire::kGradientCodes;
  expect(is_sized, "codebook", fmt::format("1..{} entries", wire::kGradientCodes), directions.size());
  const Vec3 v = directions[0];
  expect(v == Vec3{}, "codebook[0]", "the zero vector", fmt::format("({}, {}, {})", v.x, v.y, v.z));
  for (std::size_t i = 1; i < directions.size(); ++i) {
    const double size = length(directions[i]);
    const bool is_unit = std::abs(size - 1) <= kUnitTolerance;
    expect(is_unit, fmt::format("codebook[{}]", i), "a unit vector", fmt::format("one of length {}", size));
  }
}

constexpr std::size_t kCorners = 4;
constexpr std::size_t kMiddle = 4;  // index of the probe after the corners

struct FacePoint {
  int face;
  double u, v;  // on the face, -1..1
};

// Projects a direction onto the cube. `major`: the size of its largest component.
FacePoint to_face(Vec3 d, double major) {
  const double x = std::abs(d.x), y = std::abs(d.y);
  if (x == major) return {d.x < 0, d.y / major, d.z / major};
  if (y == major) return {2 + (d.y < 0), d.x / major, d.z / major};
  return {4 + (d.z < 0), d.x / major, d.y / major};
}

Vec3 from_face(const FacePoint& p) {
  const double major = p.face % 2 == 0 ? 1 : -1;
  switch (p.face / 2) {
    case 0: return {major, p.u, p.v};
    case 1: return {p.u, major, p.v};
    default: return {p.u, p.v, major};
  }
}

std::size_t to_cell(double coordinate) {
  const int cell = static_cast<int>((coordinate + 1) * (0.5 * kGridSize));
  return static_cast<std::size_t>(std::min(cell, kGridSize - 1));  // the far edge belongs to the last cell
}

// Density units per voxel edge. chosen: well below the rounding of densities, so that no visible slope is lost.
constexpr double kMinMagnitude = 1.0 / 8;
constexpr double kSobelWeight = 32;  // (1 + 2 + 1)^2 differences over two voxels each

// The Sobel filter, row by row: along z while a row is read, then along y, then along x. 64 times a 16-bit sample fits
// in 32 bits.
template <typename T>
class SobelRows {
 public:
  using Word = std::conditional_t<std::is_floating_point_v<T>, double, std::int32_t>;

  SobelRows(Samples<T> samples, Dims dims) : samples_(samples), dims_(dims), nx_(static_cast<std::size_t>(dims[0])) {
    for (auto* rows : {&sum_, &difference_}) {
      for (auto& row : *rows) row.resize(nx_);
    }
    for (auto* row : {&x_, &y_, &z_}) row->resize(nx_ + 2);
  }

  // Calls take(y, gx, gy, gz) for each row of plane z; the sums are kSobelWeight times the difference per voxel.
  void plane(int z, auto&& take) {
    std::vector<Word> gx(nx_), gy(nx_), gz(nx_);
    read_row(0, z);
    for (int y = 0; y < dims_[1]; ++y) {
      if (y + 1 < dims_[1]) read_row(y + 1, z);
      filter_along_y(y);
      for (std::size_t x = 0; x < nx_; ++x) {
        gx[x] = x_[x + 2] - x_[x];
        gy[x] = y_[x] + 2 * y_[x + 1] + y_[x + 2];
        gz[x] = z_[x] + 2 * z_[x + 1] + z_[x + 2];
      }
      take(y, gx.data(), gy.data(), gz.data());
    }
  }

 private:
  void read_row(int y, int z) {
    const auto row = [&](int plane) { return index_of(dims_, 0, y, std::clamp(plane, 0, dims_[2] - 1)); };
    const std::size_t before = row(z - 1), here = row(z), after = row(z + 1);
    Word* sum = sum_[static_cast<std::size_t>(y % 3)].data();
    Word* difference = difference_[static_cast<std::size_t>(y % 3)].data();
    for (std::size_t x = 0; x < nx_; ++x) {
      const Word a = samples_[before + x], b = samples_[here + x], c = samples_[after + x];
      sum[x] = a + 2 * b + c;
      difference[x] = c - a;
    }
  }

  void filter_along_y(int y) {
    const auto before = static_cast<std::size_t>(std::max(y - 1, 0) % 3), here = static_cast<std::size_t>(y % 3),
               after = static_cast<std::size_t>(std::min(y + 1, dims_[1] - 1) % 3);
    const Word *s0 = sum_[before].data(), *s1 = sum_[here].data(), *s2 = sum_[after].data();
    const Word *d0 = difference_[before].data(), *d1 = difference_[here].data(), *d2 = difference_[after].data();
    Word *gx = x_.data() + 1, *gy = y_.data() + 1, *gz = z_.data() + 1;
    for (std::size_t x = 0; x < nx_; ++x) {
      gx[x] = s0[x] + 2 * s1[x] + s2[x];
      gy[x] = s2[x] - s0[x];
      gz[x] = d0[x] + 2 * d1[x] + d2[x];
    }
    for (auto* row : {&x_, &y_, &z_}) {
      row->front() = (*row)[1];
      row->back() = (*row)[nx_];
    }
  }

  Samples<T> samples_;
  Dims dims_;
  std::size_t nx_;
  std::array<std::vector<Word>, 3> sum_, difference_;  // along z; row y is at y mod 3
  std::vector<Word> x_, y_, z_;                        // along z and y, with a clamped voxel at both ends
};

template <typename T>
void sobel_slab(Samples<T> samples, Dims dims, Vec3 scale, const GradientCodebook& codebook, int begin, int end,
                std::uint16_t* codes) {
  const auto nx = static_cast<std::size_t>(dims[0]);
  SobelRows<T> rows(samples, dims);
  for (int z = begin; z < end; ++z) {
    rows.plane(z, [&](int y, const auto* gx, const auto* gy, const auto* gz) {
      std::uint16_t* out = codes + index_of(dims, 0, y, z);
      for (std::size_t x = 0; x < nx; ++x) {
        const Vec3 gradient{scale.x * gx[x], scale.y * gy[x], scale.z * gz[x]};
        const bool flat = dot(gradient, gradient) < kMinMagnitude * kMinMagnitude;
        out[x] = flat ? wire::kNoGradient : codebook.nearest(gradient);
      }
    });
  }
}

void supplied_slab(const VolumeView& view, const GradientCodebook& codebook, int begin, int end, std::uint16_t* codes) {
  for (std::size_t i = index_of(view.dims, 0, 0, begin); i < index_of(view.dims, 0, 0, end); ++i) {
    const float* g = view.gradients.data() + 3 * i;
    codes[i] = codebook.nearest({g[0], g[1], g[2]});
  }
}

// Divides 0..planes into slabs, and calls work(begin, end) for each on a thread of its own.
void for_each_slab(int planes, unsigned threads, const auto& work) {
  const int slabs = std::min(static_cast<int>(thread_count(threads)), planes);
  parallel_for(static_cast<std::size_t>(slabs), threads, [&](std::size_t part) {
    const int i = static_cast<int>(part);
    work(planes * i / slabs, planes * (i + 1) / slabs);
  });
}

}  // namespace

// A square of size x size grid cells on one face.
struct GradientCodebook::Cell {
  int face, column, row, size;

  Vec3 corner(int i) const {
    const auto coordinate = [](int index) { return -1 + 2.0 * index / kGridSize; };
    return from_face({face, coordinate(column + (i % 2) * size), coordinate(row + (i / 2) * size)});
  }
  std::size_t index() const {
    return (static_cast<std::size_t>(face) * kGridSize + static_cast<std::size_t>(row)) * kGridSize +
           static_cast<std::size_t>(column);
  }
};

GradientCodebook::GradientCodebook() : GradientCodebook(std::span<const Vec3>(ring_directions())) { given_.clear(); }

GradientCodebook::GradientCodebook(std::span<const Vec3> directions)
    : given_(directions.begin(), directions.end()), entries_(wire::kGradientCodes) {
  check_directions(directions);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    entries_[i] = quantise(directions[i]);
    directions_.push_back(decode(entries_[i]));
  }
  build_grid();
}

void GradientCodebook::build_grid() {
  std::vector<std::uint16_t> all;  // the lowest code of each decoded direction
  std::set<wire::GradientEntry> seen;
  for (std::size_t code = 1; code < directions_.size(); ++code) {
    if (seen.insert(entries_[code]).second) all.push_back(static_cast<std::uint16_t>(code));
  }
  std::vector<std::vector<std::uint16_t>> lists(std::size_t{6} * kGridSize * kGridSize);
  for (int face = 0; face < 6; ++face) refine({face, 0, 0, kGridSize}, all, lists);

  begins_.reserve(lists.size() + 1);
  begins_.push_back(0);
  for (const auto& list : lists) {
    candidates_.insert(candidates_.end(), list.begin(), list.end());
    begins_.push_back(static_cast<std::uint32_t>(candidates_.size()));
  }
}

// Directions in a square are linear in its corners. So a code can be the nearest in it only if, compared with each code
// that is nearest at a corner or in the middle, it is at least as near at some corner.
void GradientCodebook::refine(const Cell& cell, std::span<const std::uint16_t> candidates,
                              std::span<std::vector<std::uint16_t>> lists) const {
  std::vector<std::array<double, kCorners + 1>> dots(candidates.size());
  std::array<std::size_t, kCorners + 1> best{};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (std::size_t c = 0; c < kCorners; ++c) {
      dots[i][c] = dot(cell.corner(static_cast<int>(c)), directions_[candidates[i]]);
      dots[i][kMiddle] += 0.25 * dots[i][c];
    }
    for (std::size_t c = 0; c <= kCorners; ++c) best[c] = dots[i][c] > dots[best[c]][c] ? i : best[c];
  }
  std::vector<std::uint16_t> left;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const auto can_win = [&](std::size_t rival) {
      for (std::size_t c = 0; c < kCorners; ++c) {
        if (dots[i][c] >= dots[rival][c] - kDotMargin) return true;
      }
      return false;
    };
    if (std::all_of(best.begin(), best.end(), can_win)) left.push_back(candidates[i]);
  }
  if (cell.size == 1) {
    lists[cell.index()] = std::move(left);
    return;
  }
  const int half = cell.size / 2;
  for (int i = 0; i < 4; ++i) {
    refine({cell.face, cell.column + i % 2 * half, cell.row + i / 2 * half, half}, left, lists);
  }
}

std::uint16_t GradientCodebook::nearest(Vec3 direction) const {
  const double major = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
  if (!(major > 0) || !(major <= std::numeric_limits<double>::max())) return wire::kNoGradient;
  const FacePoint point = to_face(direction, major);
  // A component is NaN.
  if (std::isnan(point.u) || std::isnan(point.v)) return wire::kNoGradient;
  const std::size_t cell =
      (static_cast<std::size_t>(point.face) * kGridSize + to_cell(point.v)) * kGridSize + to_cell(point.u);
  const std::uint32_t begin = begins_[cell], end = begins_[cell + 1];
  if (end - begin == 1) return candidates_[begin];

  const Vec3 on_face = from_face(point);  // scaled, so that tiny and huge directions keep precision
  std::uint16_t best = wire::kNoGradient;
  double best_dot = -2;
  for (std::uint32_t i = begin; i < end; ++i) {
    const double d = dot(on_face, directions_[candidates_[i]]);
    if (d > best_dot) best = candidates_[i], best_dot = d;
  }
  return best;
}

std::vector<std::uint16_t> gradient_codes(const VolumeView& view, ValueRange range, const GradientCodebook& codebook,
                                          unsigned threads) {
  if (view.gradients.empty() && !view.find_gradients) return {};
  std::vector<std::uint16_t> codes(voxel_count(view.dims));
  if (!view.gradients.empty()) {
    for_each_slab(view.dims[2], threads,
                  [&](int begin, int end) { supplied_slab(view, codebook, begin, end, codes.data()); });
    return codes;
  }
  const Vec3 edges = relative_spacing(view.spacing);
  const double density = wire::kDensityMax / (range.high - range.low) / kSobelWeight;
  const Vec3 scale{density / edges.x, density / edges.y, density / edges.z};
  with_samples(view, [&](auto samples) {
    for_each_slab(view.dims[2], threads, [&](int begin, int end) {
      sobel_slab(samples, view.dims, scale, codebook, begin, end, codes.data());
    });
  });
  return codes;
}

}  // namespace gicube
