// Several volumes and surfaces in one picture: splitting rays, media that overlap, meshes in single precision.
#include <algorithm>
#include <cmath>
#include <random>

#include "../meshes/meshes.h"
#include "small_stage.h"
#include "stability.h"

namespace gicube::stability {
namespace {

using namespace samples;

constexpr int kLong = 48;  // voxels along the ray
constexpr Vec3 kEye{3.5, 3.5, -5};

PlacedSurface clear_wall(double z) {
  scene::Mesh mesh = square(20, z);
  return {"clear", mesh, {1, 1, 1}, 0};
}

struct Split {
  double opacity = 0, colour = 0;  // largest differences of any pixel
};

Split split_of(const StageMedium& fog, std::size_t surfaces, double step, const std::string& datapath,
               std::mt19937& engine) {
  std::uniform_real_distribution<double> place(0.5, kLong - 1.5);
  std::vector<PlacedSurface> walls;
  for (std::size_t i = 0; i < surfaces; ++i) walls.push_back(clear_wall(place(engine)));
  Stage whole = stage_of({fog}, {}, kEye, 2, 2), split = stage_of({fog}, walls, kEye, 2, 2);
  whole.view.step = split.view.step = step;
  const Picture a = picture_of(whole, datapath), b = picture_of(split, datapath);
  Split off;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    off.opacity = std::max(off.opacity, std::abs(a.pixels[i].opacity - b.pixels[i].opacity));
    off.colour = std::max(off.colour, std::abs(a.pixels[i].colour[0] - b.pixels[i].colour[0]));
  }
  return off;
}

TEST(StabilityOfCompositions, ARayThatIsSplitAtClearSurfacesIsOffByRoundingAlone) {
  std::mt19937 engine(7);
  const Dims dims{8, 8, kLong};
  for (const char* datapath : {"", kWide}) {
    const bool wide = *datapath != 0;
    double worst = 0, worst_share = 0;
    for (const double opacity : {0.001, 0.02, 0.2}) {
      for (const std::size_t surfaces : {1u, 3u, 9u}) {
        const double step = surfaces == 3 ? 0.25 : 0.5;
        const Split off = split_of(fog(dims, {1, 0.5, 0}, opacity), surfaces, step, datapath, engine);
        // Samples of both rays, and segments whose length and place are rounded to 2^-16 and 2^-14 voxel on each end.
        // Of a sample's opacity the last place (22 units of 2^-24 by correction and ray, 8 on the wide datapath); of a
        // sample's colour, on the wide one of a segment's, half a unit of 4095.
        const double samples = 2 * kLong / step + static_cast<double>(surfaces) + 1;
        const auto segments = static_cast<double>(surfaces + 2);
        const double lengths = segments * -std::log1p(-opacity) * std::ldexp(1, -13);
        const double of_opacity = samples * (wide ? 8 : 22) * std::ldexp(1, -24) + lengths;
        const double of_colour = of_opacity + (wide ? segments : samples) / (2 * 4095.0);
        EXPECT_LE(off.opacity, of_opacity) << datapath << " " << opacity << " " << surfaces;
        EXPECT_LE(off.colour, of_colour) << datapath << " " << opacity << " " << surfaces;
        worst = std::max(worst, off.colour);
        worst_share = std::max(worst_share, off.colour / of_colour);
      }
    }
    EXPECT_GT(worst, 0);
    record(wide ? "split_colour_wide" : "split_colour", worst);
    record(wide ? "split_share_of_bound_wide" : "split_share_of_bound", worst_share);
  }
}

// Two media whose shares change from end to end, in double precision.
struct Ramp {
  double rising(double z) const { return -std::log1p(-0.1 * z / (kLong - 1)); }
  double falling(double z) const { return -std::log1p(-0.1 * (1 - z / (kLong - 1))); }

  double colour() const {
    constexpr int kParts = 400'000;
    double through = 1, sum = 0;
    const double part = (kLong - 1.0) / kParts;
    for (int i = 0; i < kParts; ++i) {
      const double z = (i + 0.5) * part, red = rising(z), both = red + falling(z);
      sum += through * -std::expm1(-both * part) * red / both;
      through *= std::exp(-both * part);
    }
    return sum;
  }
};

TEST(StabilityOfCompositions, TheErrorOfOverlapsFallsWithTheSquareOfThePieces) {
  const Dims dims{8, 8, kLong};
  const auto rise = [](Vec3 p) { return p.z / (kLong - 1); };
  const StageMedium red = medium(dims, {1, 0, 0}, 0.1, rise);
  const StageMedium blue = medium(dims, {0, 0, 1}, 0.1, [&](Vec3 p) { return 1 - rise(p); });
  const double exact = Ramp().colour();
  std::vector<double> errors;
  for (const double piece : {16.0, 8.0, 4.0, 1.0}) {
    Stage stage = stage_of({red, blue}, {}, kEye, 2, 2);
    stage.overlap_step = piece;
    stage.view.step = 0.25;
    const double error = std::abs(picture_of(stage, kWide).pixels[0].colour[0] - exact);
    // Of a piece of optical depth tau: tau^2 / 4 times how far the share of a medium varies in it; here both grow with
    // the piece.
    const double pieces = std::ceil((kLong - 1) / piece), depth = 0.1054 * (kLong - 1) / pieces;
    EXPECT_LE(error, pieces * depth * depth / 4 / pieces + 2e-4) << piece;
    record("overlap_of_" + std::to_string(static_cast<int>(piece)), error);
    errors.push_back(error);
  }
  EXPECT_GT(errors[0], 3 * errors[1]);
  EXPECT_GT(errors[1], 3 * errors[2]);
  EXPECT_LT(errors[3], 2e-4);
}

// What a fog shows in front of a wall at z = 20, whose opacity of a voxel rises from 0 to 1 over the voxel before it.
double fog_before_wall(double opacity) {
  constexpr int kParts = 1'000'000;
  const double thin = -std::log1p(-opacity), part = 20.0 / kParts;
  double through = 1, sum = 0;
  for (int i = 0; i < kParts; ++i) {
    const double z = (i + 0.5) * part, both = thin + (z > 19 ? -std::log1p(-(z - 19)) : 0);
    sum += through * -std::expm1(-both * part) * thin / both;
    through *= std::exp(-both * part);
  }
  return sum;
}

// An opaque wall that begins within a piece hides all of the other medium there, also what is in front of it.
TEST(StabilityOfCompositions, AnOpaqueWallInAnOverlapHidesAtMostOnePieceBeforeIt) {
  const Dims dims{8, 8, kLong};
  const double thin = 0.05;
  const StageMedium wall = medium(dims, {1, 0, 0}, 1, [](Vec3 p) { return p.z >= 20 ? 1.0 : 0.0; });
  const StageMedium around = fog(dims, {0, 0, 1}, thin);
  for (const double piece : {8.0, 2.0, 0.5}) {
    Stage stage = stage_of({wall, around}, {}, kEye, 2, 2);
    stage.overlap_step = piece;
    stage.view.step = 1.0 / 64;  // so that what remains is the pieces'
    const double blue = picture_of(stage, kWide).pixels[0].colour[2], exact = fog_before_wall(thin);
    EXPECT_LE(std::abs(blue - exact), std::pow(1 - thin, 20 - piece) * (1 - std::pow(1 - thin, piece)) + 5e-3) << piece;
    record("wall_in_pieces_of_" + std::to_string(static_cast<int>(2 * piece)) + "_halves", std::abs(blue - exact));
  }
}

// A cube seen from within: its layer grows towards its middle, and beyond that prisms turn inside out.
TEST(StabilityOfCompositions, AShellThickerThanAHollowIsTornButNothingOfItCountsTwice) {
  scene::Mesh hollow = cube(1);
  for (auto& triangle : hollow.triangles) std::swap(triangle[1], triangle[2]);
  for (const Vec3& p : hollow.points) hollow.texture.push_back({0.5 + p.x / 3, 0.5 + p.y / 3});
  hollow.texture_triangles = hollow.triangles;
  const Dims dims{8, 8, 8};
  const auto torn = [&](double thickness) {  // of the places where a ray goes from one tetrahedron to the next
    const Shell shell(hollow, {.thickness = thickness}, dims);
    std::vector<Span> spans;
    int jumps = 0, places = 0;
    for (int i = 0; i < 400; ++i) {
      spans.clear();
      shell.add_spans({-0.95 + 0.1 * (i % 20), -0.95 + 0.1 * (i / 20), -3}, {0, 0, 1}, 0, {0, 0, 1}, {}, spans);
      for (std::size_t k = 1; k < spans.size(); ++k) {
        EXPECT_GE(spans[k].near, spans[k - 1].far);
        if (spans[k].near - spans[k - 1].far > 1e-9) continue;
        ++places;
        jumps += length(spans[k].at(spans[k].near) - spans[k - 1].at(spans[k - 1].far)) > 0.5 ? 1 : 0;
      }
    }
    return static_cast<double>(jumps) / places;
  };
  EXPECT_EQ(torn(0.5), 0);
  const double thick = torn(4);
  EXPECT_GT(thick, 0.05);
  record("torn_places_of_a_shell_thicker_than_its_hollow", thick);
  Stage stage = stage_of({fog(dims, {1, 1, 1}, 0.1)}, {}, {0, 0, -3}, 8, 8);
  stage.view.orthographic_height = 2;
  stage.media[0].shell = std::make_shared<const Shell>(hollow, ShellSettings{.thickness = 4}, dims);
  for (const Premultiplied& pixel : picture_of(stage, kWide).pixels) {
    EXPECT_GT(pixel.opacity, 0.05);
    EXPECT_LE(pixel.opacity, 1);
    EXPECT_LE(pixel.colour[0], pixel.opacity + 1e-3);
  }
}

TEST(StabilityOfCompositions, MeshesFarFromTheOriginAreMissedOrMetByTheirSinglePrecision) {
  constexpr double kFar = 1e5, kPrecision = kFar * 0x1p-23;
  scene::Mesh mesh = cube(1);
  for (Vec3& p : mesh.points) p = p + Vec3{kFar, kFar, kFar};
  const MeshCaster caster({mesh});
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> beside(-4 * kPrecision, 4 * kPrecision), along(-0.9, 0.9);
  std::vector<Crossing> found;
  int near = 0, wrong = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double off = beside(engine);  // from an edge of the face, inwards if below 0
    caster.find({kFar + 1 + off, kFar + along(engine), kFar - 10}, {0, 0, 1}, found);
    const bool met = found.size() == 2, right = met == (off <= 0);
    if (std::abs(off) > 2 * kPrecision) {
      ASSERT_TRUE(right) << off;
    } else {
      ++near;
      wrong += right ? 0 : 1;
    }
    // Every surface is found at its place.
    if (!met) continue;
    EXPECT_NEAR(found[0].distance, 9, 1e-9);
  }
  EXPECT_GT(wrong, 0);
  record("wrong_of_rays_by_an_edge", static_cast<double>(wrong) / near);
}

}  // namespace
}  // namespace gicube::stability
