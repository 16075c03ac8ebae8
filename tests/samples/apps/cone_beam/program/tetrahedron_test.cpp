// The iron tetrahedron of the CTSimU toolbox, from its JSON and raw files, against the mesh that it was simulated from.
#include "cone_beam/fdk.h"
#include "cone_beam/scan/scan.h"
#include "stl.h"
#include "test.h"

namespace gicube::samples {
namespace {

const std::filesystem::path kData = GICUBE_SOURCE_DIR "/../shared/data/ctsimu_tetra_cone_projections";

// In the volume's coordinates: the scenario places the middle of the mesh's bounding box, so that its tip is on the
// axis.
Mesh frame_of_iron() {
  Mesh mesh = read_stl(kData / "tetra.stl");
  const auto middle = [&](double Vec3::*axis) {
    const auto [least, most] = std::ranges::minmax(mesh.points, {}, axis);
    return (least.*axis + most.*axis) / 2;
  };
  const Vec3 shift = Vec3{9.428083, 0, 8.888888} - Vec3{middle(&Vec3::x), middle(&Vec3::y), middle(&Vec3::z)};
  for (Vec3& point : mesh.points) point = point + shift;
  return mesh;
}

struct SurfacePoint {
  Vec3 place, normal;
};

// Evenly over the area, by a sequence of low discrepancy.
std::vector<SurfacePoint> surface_points(const Mesh& mesh, int count) {
  double area = 0;
  std::vector<double> ends;
  for (const auto& [a, b, c] : mesh.triangles) {
    area += length(cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a])) / 2;
    ends.push_back(area);
  }
  std::vector<SurfacePoint> out;
  for (int i = 0; i < count; ++i) {
    const auto part = [i](double step) { return std::fmod((i + 0.5) * step, 1.0); };
    const auto found = std::ranges::lower_bound(ends, area * (i + 0.5) / count);
    const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(found - ends.begin())];
    double u = part(0.7548776662466927), v = part(0.5698402909980532);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 p = mesh.points[a], ab = mesh.points[b] - p, ac = mesh.points[c] - p;
    const Vec3 normal = cross(ab, ac);
    out.push_back({p + u * ab + v * ac, (1 / length(normal)) * normal});
  }
  return out;
}

// The volume between its voxels, turned over along some axes: a sign of -1 mirrors it.
class Values {
 public:
  Values(const std::vector<float>& values, const Grid& grid, Vec3 signs)
      : values_(values), grid_(grid), signs_(signs) {}

  double at(Vec3 p) const {
    const Vec3 voxel = to_voxels(grid_, {signs_.x * p.x, signs_.y * p.y, signs_.z * p.z});
    const auto x = static_cast<int>(voxel.x), y = static_cast<int>(voxel.y), z = static_cast<int>(voxel.z);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const int i = x + (corner & 1), j = y + (corner >> 1 & 1), k = z + (corner >> 2);
      const double weight = (1 - std::abs(voxel.x - i)) * (1 - std::abs(voxel.y - j)) * (1 - std::abs(voxel.z - k));
      const auto index =
          (static_cast<std::size_t>(k) * static_cast<std::size_t>(grid_.dims[1]) + static_cast<std::size_t>(j)) *
              static_cast<std::size_t>(grid_.dims[0]) +
          static_cast<std::size_t>(i);
      sum += weight * static_cast<double>(values_[index]);
    }
    return sum;
  }

 private:
  const std::vector<float>& values_;
  const Grid& grid_;
  Vec3 signs_;
};

// The mean value `depth` mm below the surface, all of it moved by `shift`.
double mean_below(const Values& values, const std::vector<SurfacePoint>& points, double depth, Vec3 shift) {
  double sum = 0;
  for (const SurfacePoint& point : points) sum += values.at(point.place + shift - depth * point.normal);
  return sum / static_cast<double>(points.size());
}

// By how much the frame must be moved for it to meet the greatest values: the top of a parabola on each axis.
Vec3 displacement(const Values& values, const std::vector<SurfacePoint>& points) {
  const auto along = [&](Vec3 axis) {
    const double before = mean_below(values, points, 1, -1.0 * axis), here = mean_below(values, points, 1, {}),
                 behind = mean_below(values, points, 1, axis);
    return 0.5 * (before - behind) / (before - 2 * here + behind);
  };
  return {along({1, 0, 0}), along({0, 1, 0}), along({0, 0, 1})};
}

struct Fit {
  double found = 0;     // share of the mesh's surface beside which there is one, within 2 mm along its normal
  double distance = 0;  // mm: of that, where it is from the mesh, root mean square
  double value = 0;     // 1 mm below the mesh's surface, mean
};

// A surface is where the values fall through `level` on the way out.
Fit fit_of(const Values& values, const std::vector<SurfacePoint>& points, double level) {
  constexpr double kReach = 2, kStep = 0.05;
  Fit fit{0, 0, mean_below(values, points, 1, {})};
  int found = 0;
  for (const SurfacePoint& point : points) {
    double nearest = kReach + 1, before = values.at(point.place - kReach * point.normal);
    for (double s = -kReach + kStep; s <= kReach; s += kStep) {
      const double value = values.at(point.place + s * point.normal);
      if (before >= level && value < level && std::abs(s) < std::abs(nearest)) nearest = s - kStep / 2;
      before = value;
    }
    if (nearest > kReach) continue;
    ++found;
    fit.distance += nearest * nearest;
  }
  fit.found = found / static_cast<double>(points.size());
  fit.distance = found > 0 ? std::sqrt(fit.distance / found) : kReach;
  return fit;
}

TEST(Tetrahedron, StandsWhereItsMeshDoesAndNotMirrored) {
  if (!std::filesystem::exists(kData)) GTEST_SKIP() << "no " << kData;
  const Scan scan = load_scan(read_description(kData / "projections" / "tetra_metadata.json"));
  EXPECT_EQ(scan.geometry.angles.size(), 20u);
  EXPECT_EQ(scan.views_read, 21u);
  EXPECT_EQ(scan.repeated, 1u);  // view 20 is a whole turn behind view 0
  EXPECT_EQ(scan.flat_field.absorbed, 0u);
  EXPECT_NEAR(*std::ranges::max_element(scan.projections.values), 10.99, 0.01);
  ASSERT_EQ(scan.geometry.volume.dims, (Dims{150, 150, 150}));
  Board board = Board::open("emu:");
  const Reconstruction result = reconstruct_fdk(board, scan.geometry, scan.projections);
  EXPECT_EQ(result.overflowed, 0u);

  const auto points = surface_points(frame_of_iron(), 20'000);
  const auto turned = [&](Vec3 signs) { return Values(result.values, scan.geometry.volume, signs); };
  const Values values = turned({1, 1, 1});
  const double level = mean_below(values, points, 1, {}) / 2;
  const Fit right = fit_of(values, points, level);
  const Vec3 moved = displacement(values, points);
  std::printf(
      "surface beside %.1f%% of the mesh, %.3f mm from it (RMS); value %.4f a mm; displaced by %.3f %.3f %.3f mm\n",
      100 * right.found, right.distance, right.value, moved.x, moved.y, moved.z);
  const double voxel = scan.geometry.volume.spacing.x;
  EXPECT_GT(right.found, 0.7);  // of 20 views: streaks hide the rest
  EXPECT_LT(right.distance, voxel);
  EXPECT_LT(length(moved), voxel / 4);
  // The frame is the same from both sides of y, so that only two axes can tell; y's own is told by the order of the
  // views.
  for (const Vec3 signs : {Vec3{-1, 1, 1}, Vec3{1, 1, -1}, Vec3{-1, 1, -1}}) {
    const Fit wrong = fit_of(turned(signs), points, level);
    std::printf("mirrored %+.0f %+.0f %+.0f: surface beside %.1f%%, %.3f mm from it; value %.4f\n", signs.x, signs.y,
                signs.z, 100 * wrong.found, wrong.distance, wrong.value);
    EXPECT_LT(wrong.found, 0.5 * right.found);
    EXPECT_LT(wrong.value, 0.5 * right.value);
  }
}

// Mirrored along y, a scan goes round the other way. The frame's own symmetry hides that from the mesh, not from the
// rays.
TEST(Tetrahedron, IsSmearedByViewsThatGoRoundTheOtherWay) {
  if (!std::filesystem::exists(kData)) GTEST_SKIP() << "no " << kData;
  ScanDescription description = read_description(kData / "projections" / "tetra_metadata.json");
  const double first = description.geometry.angles.front();
  for (double& angle : description.geometry.angles) angle = 2 * first - angle;
  const Scan scan = load_scan(description);
  Board board = Board::open("emu:");
  const Reconstruction result = reconstruct_fdk(board, scan.geometry, scan.projections);
  const auto points = surface_points(frame_of_iron(), 20'000);
  const double value = mean_below(Values(result.values, scan.geometry.volume, {1, 1, 1}), points, 1, {});
  std::printf("the other way round: value %.4f a mm\n", value);
  EXPECT_LT(value, 0.1);
}

}  // namespace
}  // namespace gicube::samples
