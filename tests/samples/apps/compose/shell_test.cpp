#include "compose/shell.h"

#include "../meshes/meshes.h"
#include "gicube/scene/error.h"
#include "small_stage.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr Dims kTile{17, 9, 5};

// The square -2..2 at z = 0, u and v from 0 to 1 along x and y.
Mesh flat() {
  Mesh mesh = square(2, 0);
  mesh.texture = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.texture_triangles = mesh.triangles;
  return mesh;
}

std::vector<Span> spans_of(const Shell& shell, Vec3 from, Vec3 direction, const Phong& phong = {1, 0, 0, 1}) {
  std::vector<Span> spans;
  shell.add_spans(from, normalise(direction), 7, {0, 0, 1}, phong, spans);
  std::ranges::sort(spans, {}, &Span::near);
  return spans;
}

TEST(Shell, OverAFlatMeshIsTheVolumeItself) {
  const Shell shell(flat(), {.thickness = 2}, kTile);
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> place(-1.5, 1.5);
  for (int i = 0; i < 500; ++i) {
    const Vec3 in{place(engine), place(engine), 2}, out{place(engine), place(engine), 0};
    const Vec3 from = in + 2 * (in - out);
    const auto spans = spans_of(shell, from, out - from);
    ASSERT_FALSE(spans.empty());
    EXPECT_NEAR(spans.front().near, length(in - from), 1e-9);
    EXPECT_NEAR(spans.back().far, length(out - from), 1e-9);
    for (std::size_t k = 0; k < spans.size(); ++k) {
      EXPECT_EQ(spans[k].volume, 7u);
      if (k > 0) {
        EXPECT_NEAR(spans[k].near, spans[k - 1].far, 1e-9);
      }
      for (const double distance : {spans[k].near, spans[k].far}) {
        const Vec3 p = from + distance * normalise(out - from), voxel = spans[k].at(distance);
        EXPECT_NEAR(voxel.x, (p.x + 2) / 4 * 16, 1e-7);
        EXPECT_NEAR(voxel.y, (p.y + 2) / 4 * 8, 1e-7);
        EXPECT_NEAR(voxel.z, p.z / 2 * 4, 1e-7);
      }
    }
  }
}

TEST(Shell, RepeatsTheVolumeAndCutsRaysWhereACopyEnds) {
  const Shell shell(flat(), {.thickness = 1, .repeat_u = 4, .repeat_v = 2}, kTile);
  // Flat along x at a quarter of the height: four copies, each from its first to its last voxel.
  const auto spans = spans_of(shell, {-3, 0.3, 0.25}, {1, 0, 0});
  double copies = 0;
  for (const Span& span : spans) {
    const Vec3 a = span.at(span.near), b = span.at(span.far);
    EXPECT_GE(std::min(a.x, b.x), -1e-9);
    EXPECT_LE(std::max(a.x, b.x), 16 + 1e-9);
    EXPECT_NEAR(a.y, 8 * (2.3 / 4 * 2 - 1), 1e-9);
    EXPECT_NEAR(a.z, 1, 1e-9);
    copies += (b.x - a.x) / 16;
  }
  EXPECT_NEAR(copies, 4, 1e-9);
  EXPECT_NEAR(spans.front().near, 1, 1e-9);
  EXPECT_NEAR(spans.back().far, 5, 1e-9);
}

TEST(Shell, OfAClosedMeshHasNeitherGapsNorOverlaps) {
  Mesh mesh = cube(1);
  for (const Vec3& p : mesh.points) mesh.texture.push_back({0.5 + p.x / 3, 0.5 + p.y / 3});
  mesh.texture_triangles = mesh.triangles;
  // From the mesh outwards along its corners' normals: a cube of half edge 1 + 0.3 / sqrt(3).
  const Shell shell(mesh, {.thickness = 0.3}, kTile);
  const double outer = 1 + 0.3 / std::sqrt(3);
  std::mt19937 engine(2);
  std::uniform_real_distribution<double> place(-0.9, 0.9);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 from{place(engine), place(engine), -5}, to{place(engine), place(engine), 5},
        along = normalise(to - from);
    const auto spans = spans_of(shell, from, to - from);
    double covered = 0;
    for (std::size_t k = 0; k < spans.size(); ++k) {
      covered += spans[k].far - spans[k].near;
      if (k > 0) {
        ASSERT_GE(spans[k].near, spans[k - 1].far - 1e-9);
      }
    }
    // Through both cubes by their faces across z.
    const auto meets = [&](double z, double half) {
      const Vec3 p = from + ((z - from.z) / along.z) * along;
      return std::abs(p.x) < half && std::abs(p.y) < half;
    };
    if (!meets(-1, 0.99) || !meets(1, 0.99) || !meets(-outer, 0.99) || !meets(outer, 0.99)) continue;
    ASSERT_NEAR(covered, 2 * (outer - 1) / along.z, 1e-6);
  }
}

TEST(Shell, BeginsAtTheEyeIfThatIsInIt) {
  const Shell shell(flat(), {.thickness = 2}, kTile);
  const auto spans = spans_of(shell, {0.1, 0.2, 1}, {0, 0, -1});
  EXPECT_EQ(spans.front().near, 0);
  EXPECT_NEAR(spans.front().at(0).z, 2, 1e-12);
  EXPECT_NEAR(spans.back().far, 1, 1e-12);
  EXPECT_TRUE(spans_of(shell, {0.1, 0.2, 3}, {0, 0, 1}).empty());
  EXPECT_TRUE(spans_of(shell, {5, 5, 3}, {0, 0, -1}).empty());
}

TEST(Shell, IsShadedByTheMeshsNormals) {
  const Shell shell(flat(), {.thickness = 2}, kTile);
  for (const Span& span : spans_of(shell, {0.1, 0.2, 3}, {0, 0, -1}, {.ambient = 0.2, .diffuse = 0.5})) {
    EXPECT_NEAR(span.shade, 0.7, 1e-12);
  }
  Stage stage = stage_of({fog(kTile, {1, 1, 1}, 0.1)}, {}, {0, 0, -5}, 2, 2);
  stage.media[0].shell = std::make_shared<const Shell>(flat(), ShellSettings{.thickness = 2}, kTile);
  stage.phong = {.ambient = 0.5, .diffuse = 0.5, .specular = 0};
  stage.light = {0, 0, -3};  // on the other side
  for (const Premultiplied& pixel : picture_of(stage, kWide).pixels) {
    const double opacity = 1 - std::pow(0.9, 4);  // four voxels, however thick the layer is
    EXPECT_NEAR(pixel.opacity, opacity, 1e-4);
    EXPECT_NEAR(pixel.colour[0], 0.5 * opacity, 2e-4);
  }
}

TEST(Shell, NeedsTextureCoordinatesThatStayWithinBounds) {
  const auto refusal = [](const Mesh& mesh, const ShellSettings& settings) -> std::string {
    return message_of<InputError>([&] { const Shell shell(mesh, settings, kTile); });
  };
  EXPECT_EQ(refusal(square(1, 0), {.thickness = 1}),
            "file: expected a mesh whose faces all have texture coordinates (.obj, vt), got others");
  Mesh wide = flat();
  wide.texture[1][0] = 100;
  EXPECT_EQ(refusal(wide, {.thickness = 1, .repeat_u = 10}), "none");
  EXPECT_EQ(refusal(wide, {.thickness = 1, .repeat_u = 11}),
            "repeat_u: expected at most 1000 copies of the volume on a triangle, got 1100");
}

}  // namespace
}  // namespace gicube::samples
