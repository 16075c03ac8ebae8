#include "encode/look_up_tables.h"

#include "gicube/wire/lut.h"
#include "refusal.h"
#include "test.h"

namespace gicube {
namespace {

// A normal's place in the map: face, and column and row in texels.
struct Place {
  int face;
  double column, row;
};

Place place_on(int face, Vec3 n) {
  const std::array<double, 3> v{n.x, n.y, n.z};
  const auto axis = static_cast<std::size_t>(face / 2);
  const std::size_t b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
  const double size = std::abs(v[axis]);
  return {face, (v[b] / size + 1) * 63.5, (v[c] / size + 1) * 63.5};
}

double bilinear(const std::vector<std::uint8_t>& map, Place p) {
  const int column = std::min(static_cast<int>(p.column), 126), row = std::min(static_cast<int>(p.row), 126);
  const double u = p.column - column, v = p.row - row;
  const auto texel = [&](int r, int c) {
    const int index = (p.face * 128 + row + r) * 128 + column + c;
    return map[static_cast<std::size_t>(index)] / 128.0;
  };
  return (1 - v) * ((1 - u) * texel(0, 0) + u * texel(0, 1)) + v * ((1 - u) * texel(1, 0) + u * texel(1, 1));
}

int face_of(Vec3 n) {
  const std::array<double, 3> v{n.x, n.y, n.z};
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) axis = std::abs(v[i]) > std::abs(v[axis]) ? i : axis;
  return static_cast<int>(2 * axis) + (v[axis] < 0);
}

TEST(Reflected, IsLambertWithoutAHighlight) {
  const Phong phong{0.3, 0.8, 0, 10};
  const Vec3 up{0, 0, 1};
  EXPECT_DOUBLE_EQ(reflected(phong, up, {0, 0, 5}, {1, 0, 0}), 0.8);
  EXPECT_NEAR(reflected(phong, up, {0, 3, 3}, {1, 0, 0}), 0.8 * std::sqrt(0.5), 1e-15);
  EXPECT_EQ(reflected(phong, up, {1, 0, 0}, {1, 0, 0}), 0);
  EXPECT_EQ(reflected(phong, up, {1, 0, -1}, {1, 0, 0}), 0);
}

TEST(Reflected, TheHighlightIsWhereTheEyeSeesTheMirroredLight) {
  const Phong phong{0, 0, 0.5, 2};
  const Vec3 up{0, 0, 1}, light{0.6, 0, 0.8};
  EXPECT_NEAR(reflected(phong, up, light, {-0.6, 0, 0.8}), 0.5, 1e-15);
  // Straight above: R.V = 0.8, squared.
  EXPECT_NEAR(reflected(phong, up, light, up), 0.5 * 0.64, 1e-15);
  EXPECT_EQ(reflected(phong, up, light, {0.8, 0, -0.6}), 0);  // R.V < 0
}

TEST(Reflected, TheHighlightFadesInAtTheTerminator) {
  const Phong phong{0, 0, 1, 1};
  for (const double facing : {0.0, 0.02, 0.05, 0.1, 0.3}) {
    const double side = std::sqrt(1 - facing * facing);
    const double expected = facing < 0.1 ? facing / 0.1 : 1.0;
    EXPECT_NEAR(reflected(phong, {0, 0, 1}, {side, 0, facing}, {-side, 0, facing}), expected, 1e-12) << facing;
  }
}

TEST(Reflected, ZeroLightIsAtTheEye) {
  const Phong phong;
  const Vec3 eye = normalise({1, 2, 3}), normal = normalise({1, 1, 1});
  EXPECT_EQ(reflected(phong, normal, {}, eye), reflected(phong, normal, eye, eye));
}

TEST(ReflectanceMap, HoldsTheFormulaAtEveryTexel) {
  const Phong phong{0.2, 0.9, 0.8, 30};
  const Vec3 light{1, -2, 0.5}, eye = normalise({0.2, -1, 0.7});
  const auto map = reflectance_map(phong, light, eye);
  ASSERT_EQ(map.size(), wire::kReflectanceBytes);
  for (int i = 0; i < static_cast<int>(map.size()); ++i) {
    const int face = i / 16384;
    const double major = face % 2 == 0 ? 1 : -1, b = -1 + 2.0 * (i % 128) / 127, c = -1 + 2.0 * (i / 128 % 128) / 127;
    const std::array<Vec3, 3> normals{Vec3{major, b, c}, {b, major, c}, {b, c, major}};
    const double shade = reflected(phong, normalise(normals[static_cast<std::size_t>(face / 2)]), light, eye);
    ASSERT_NEAR(map[static_cast<std::size_t>(i)] / 128.0, std::min(shade, 255 / 128.0), 0.5 / 128 + 1e-12) << i;
  }
}

TEST(ReflectanceMap, HasNoSeamBetweenFaces) {
  const auto map = reflectance_map({0.2, 0.9, 0.8, 30}, {1, -2, 0.5}, normalise({0.2, -1, 0.7}));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> along(-1, 1);
  double greatest = 0;
  for (int first = 0; first < 6; ++first) {
    for (int second = first + 1; second < 6; ++second) {
      if (first / 2 == second / 2) continue;
      for (int i = 0; i < 500; ++i) {
        std::array<double, 3> v;
        v[static_cast<std::size_t>(3 - first / 2 - second / 2)] = along(random);
        v[static_cast<std::size_t>(first / 2)] = first % 2 == 0 ? 1 : -1;
        v[static_cast<std::size_t>(second / 2)] = second % 2 == 0 ? 1 : -1;
        const Vec3 edge{v[0], v[1], v[2]};
        greatest =
            std::max(greatest, std::abs(bilinear(map, place_on(first, edge)) - bilinear(map, place_on(second, edge))));
      }
    }
  }
  EXPECT_LT(greatest, 1e-9);
}

TEST(ReflectanceMap, LookedUpBilinearlyItIsCloseToTheFormula) {
  const Phong phong;
  const Vec3 light{1, 1, 1}, eye = normalise({-0.3, 0.2, 1});
  const auto map = reflectance_map(phong, light, eye);
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 n = normalise({normal(random), normal(random), normal(random)});
    // Half a unit of rounding, and the bend of a cos^24 lobe over a texel of one degree.
    ASSERT_NEAR(bilinear(map, place_on(face_of(n), n)), reflected(phong, n, light, eye), 0.5 / 128 + 0.004);
  }
}

TEST(ReflectanceMap, IsHeldToItsGreatestValue) {
  const auto map = reflectance_map({0, 1, 0.99, 1}, {0, 0, 1}, {0, 0, 1});
  const auto head = reflectance_map({0, 1, 0.99, 1}, {}, {0, 0, 1});
  EXPECT_EQ(map, head);
  EXPECT_GE(*std::max_element(map.begin(), map.end()), 254);
}

TEST(PhongCheck, NamesTheCoefficient) {
  const auto refused = [](Phong phong) { return refusal([&] { check(phong); }); };
  EXPECT_EQ(refused({}), "accepted");
  EXPECT_EQ(refused({1.0, 0.99, 1.0, 1000}), "accepted");
  EXPECT_EQ(refused({-0.1, 0.7, 0.3, 24}), "phong.ambient: expected 0..1.99, got -0.1");
  EXPECT_EQ(refused({0, 2, 0.3, 24}), "phong.diffuse: expected 0..1.99, got 2");
  EXPECT_EQ(refused({0, 1, std::nan(""), 24}), "phong.specular: expected 0..1.99, got nan");
  EXPECT_EQ(refused({0, 1, 0, 0.5}), "phong.shininess: expected 1..1000, got 0.5");
  EXPECT_EQ(refused({1.5, 1, 0, 24}), "phong.ambient + phong.diffuse: expected at most 1.99, got 2.5");
  EXPECT_EQ(refused({0.5, 1, 1, 24}), "phong.diffuse + phong.specular: expected at most 1.99, got 2");
}

TEST(ShadingCheck, LightIsAnyFiniteVector) {
  EXPECT_EQ(refusal([] { check(Shading{}); }), "accepted");
  EXPECT_EQ(refusal([] { check(Shading{{}, {0, std::nan(""), 1}}); }), "light.y: expected a finite number, got nan");
  EXPECT_EQ(refusal([] { check(Shading{{0, 3, 0, 1}, {}}); }), "phong.diffuse: expected 0..1.99, got 3");
}

}  // namespace
}  // namespace gicube
