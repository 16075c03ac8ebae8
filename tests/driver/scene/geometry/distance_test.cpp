#include "gicube/scene/error.h"
#include "gicube/scene/shape.h"
#include "scene/geometry/signed_distance.h"
#include "test.h"

namespace gicube::scene {
namespace {

Distance at(const Shape& shape, Vec3 p) {
  Distance least{1e300, {}};
  for (const Field& field : fields_of(shape)) {
    const Distance d = field(p);
    if (d.distance < least.distance) least = d;
  }
  return least;
}

const std::vector<std::pair<const char*, Shape>>& shapes() {
  static const std::vector<std::pair<const char*, Shape>> kShapes{
      {"sphere", SphereShape{0.7}},
      {"box", BoxShape{{-0.5, -0.2, -0.9}, {0.4, 0.6, 0.8}, 0.1}},
      {"torus", TorusShape{0.8, 0.2}},
      {"cylinder", CylinderShape{0.6, 1.2, 0, 0.05}},
      {"pipe", CylinderShape{0.8, 0.5, 0.6, 0.02}},
      {"head", BuiltinShape{"head"}},
      {"buckyball", BuiltinShape{"buckyball"}}};
  return kShapes;
}

// Random points around the origin, where no two parts of a surface are equally near.
template <typename Check>
void at_random_points(const Shape& shape, const Check& check) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> side(-1.3, 1.3);
  for (int i = 0; i < 300; ++i) check(Vec3{side(random), side(random), side(random)}, shape);
}

TEST(ShapeDistance, HasItsGradientByCentralDifferences) {
  const double h = 1e-6;
  for (const auto& [name, shape] : shapes()) {
    int compared = 0;
    at_random_points(shape, [&, n = name](Vec3 p, const Shape& s) {
      const auto slope = [&](Vec3 step) {
        return (at(s, p + h * step).distance - at(s, p - h * step).distance) / (2 * h);
      };
      const auto one_sided = [&](Vec3 step) { return (at(s, p + h * step).distance - at(s, p).distance) / h; };
      const Vec3 gradient{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
      const Vec3 forward{one_sided({1, 0, 0}), one_sided({0, 1, 0}), one_sided({0, 0, 1})};
      if (length(gradient - forward) > 1e-4) return;  // on an edge of the field
      ++compared;
      EXPECT_LT(length(at(s, p).away - gradient), 1e-4) << n << " at " << p.x << ' ' << p.y << ' ' << p.z;
    });
    EXPECT_GT(compared, 250) << name;
  }
}

TEST(ShapeDistance, NeverGrowsFasterThanTheWay) {
  for (const auto& [name, shape] : shapes()) {
    at_random_points(shape, [n = name](Vec3 p, const Shape& s) {
      const Vec3 q = p + Vec3{0.05, -0.11, 0.07};
      EXPECT_LE(std::abs(at(s, q).distance - at(s, p).distance), length(q - p) + 1e-12) << n;
    });
  }
}

TEST(ShapeDistance, IsThatOfTheTorus) {
  EXPECT_NEAR(at(TorusShape{2, 0.5}, {0, 0, 0}).distance, 1.5, 1e-12);
  EXPECT_NEAR(at(TorusShape{2, 0.5}, {0, 2, 0}).distance, -0.5, 1e-12);
  EXPECT_NEAR(at(TorusShape{2, 0.5}, {3, 4, 4}).distance, std::hypot(3, 4) - 0.5, 1e-12);
}

TEST(ShapeDistance, IsThatOfTheCylinderAndOfThePipe) {
  const Shape cylinder = CylinderShape{2, 6, 0, 0}, pipe = CylinderShape{2, 6, 1, 0};
  EXPECT_NEAR(at(cylinder, {0, 0, 0}).distance, -2, 1e-12);
  EXPECT_NEAR(at(cylinder, {0, 1, 5}).distance, 2, 1e-12);
  EXPECT_NEAR(at(cylinder, {5, 0, 7}).distance, 5, 1e-12);
  EXPECT_NEAR(at(pipe, {0, 0, 0}).distance, 1, 1e-12);
  EXPECT_NEAR(at(pipe, {1.6, 0, 0}).distance, -0.4, 1e-12);
  EXPECT_EQ(at(pipe, {0.2, 0, 0}).away, (Vec3{-1, 0, 0}));
}

TEST(ShapeDistance, OfTheBuckyballIsLeastAtItsAtomsAndItsMiddleIsEmpty) {
  EXPECT_NEAR(at(BuiltinShape{"buckyball"}, {}).distance, 1 - 0.05 / 0.355, 1e-9);
  EXPECT_NEAR(at(BuiltinShape{"buckyball_atoms"}, {}).distance, 1 - 0.05 / 0.355, 1e-9);
  EXPECT_LT(at(BuiltinShape{"buckyball_bonds"}, {}).distance, 1 - 0.021 / 0.355);
}

TEST(ShapeDistance, OfTheHeadIsSymmetricAndHasANoseInFront) {
  for (const Vec3 p : {Vec3{0.3, -0.6, 0.1}, Vec3{0.55, 0.1, 0}, Vec3{0.1, 0.2, 0.7}}) {
    EXPECT_EQ(head_bound(p).distance, head_bound({-p.x, p.y, p.z}).distance);
    EXPECT_EQ(head_bound(p).away.x, -head_bound({-p.x, p.y, p.z}).away.x);
  }
  EXPECT_LT(head_bound({0, -0.76, -0.1}).distance, 0);
  EXPECT_GT(head_bound({0.3, -0.76, -0.1}).distance, 0);
  EXPECT_LT(head_bound({0, 0, 0}).distance, -0.3);
}

TEST(ShapeDistance, RefusesImpossibleShapesByField) {
  const std::pair<Shape, const char*> cases[] = {{SphereShape{0}, "radius"},
                                                 {SphereShape{std::nan("")}, "radius"},
                                                 {BoxShape{{0, 0, 0}, {1, -1, 1}}, "high.y - low.y"},
                                                 {BoxShape{{0, 0, 0}, {1, 1, 1}, 0.6}, "rounding"},
                                                 {TorusShape{0.5, 0.5}, "tube"},
                                                 {CylinderShape{1, 0}, "height"},
                                                 {CylinderShape{1, 2, 1}, "inner_radius"},
                                                 {CylinderShape{1, 2, 0.9, 0.2}, "rounding"},
                                                 {MeshShape{}, "file"},
                                                 {FieldShape{}, "field"},
                                                 {BuiltinShape{"teapot"}, "builtin"}};
  for (const auto& [shape, field] : cases) {
    try {
      check(shape);
      ADD_FAILURE() << field;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find(field), 0u) << error.what();
    }
  }
}

}  // namespace
}  // namespace gicube::scene
