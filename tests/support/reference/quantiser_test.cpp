// Each quantiser alone changes the picture, and by no more than its word explains.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "compare.h"
#include "march.h"
#include "test_scene.h"

namespace gicube::reference {
namespace {

// A soft, shaded blob with colours and opacities that vary.
class BlobScene : public TestScene {
 public:
  BlobScene()
      : TestScene({33, 33, 33}, [](Vec3 p) {
          const Vec3 d = p - Vec3{16, 16, 16};
          return std::exp(-dot(d, d) / 80) * (0.8 + 0.2 * std::sin(0.7 * p.x) * std::cos(0.5 * p.y));
        }) {
    scene.functions[0] = {{{0, {0.1, 0.3, 0.9}}, {1, {0.9, 0.6, 0.2}}}, {{0.1, 0}, {0.9, 0.4}}};
    scene.view.eye = {-30, 50, -20};
    scene.view.look_at = {16, 16, 16};
    scene.view.width = scene.view.height = 40;
    scene.view.shade = true;
    scene.shading.light = {-1, 2, -2};
  }
};

struct Case {
  std::string name;
  bool Quantisers::*quantiser;
  double largest_error;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class OneQuantiser : public testing::TestWithParam<Case> {};

TEST_P(OneQuantiser, CostsSomethingButNoMoreThanItsWordExplains) {
  const BlobScene test;
  Quantisers quantisers;
  quantisers.*GetParam().quantiser = true;
  const Difference cost = compare(render(test.scene, quantisers), render(test.scene));
  EXPECT_GT(cost.max_error, 0);
  EXPECT_LT(cost.max_error, GetParam().largest_error);
}

// Bounds: density and opacity far below a step of an 8-bit display; colour half a 12-bit unit a sample; gradient the
// sine of the codebook's largest error of 3.4 degrees; reflectance 1/128; the framebuffer half a unit.
INSTANTIATE_TEST_SUITE_P(Each, OneQuantiser,
                         testing::Values(Case{"density", &Quantisers::density, 1.0 / 1024},
                                         Case{"gradient", &Quantisers::gradient, 0.06},
                                         Case{"colour", &Quantisers::colour, 1.0 / 255},
                                         Case{"opacity", &Quantisers::opacity, 1.0 / 1024},
                                         Case{"reflectance", &Quantisers::reflectance, 1.5 / 128},
                                         Case{"position", &Quantisers::position, 1.0 / 255},
                                         Case{"framebuffer", &Quantisers::framebuffer, 0.5 / 255 + 1e-9}),
                         [](const auto& test) { return test.param.name; });

TEST(AllQuantisers, TogetherKeepTheBlobWithinFortyDecibel) {
  const BlobScene test;
  EXPECT_GE(compare(render(test.scene, Quantisers::all()), render(test.scene)).psnr_db, 40);
}

TEST(GradientCodes, StandForTheirDirectionsToTheCodebooksLargestError) {
  const BlobScene test;
  Quantisers quantisers;
  quantisers.gradient = true;
  const Field coded(test.scene.volume, quantisers), exact(test.scene.volume, {});
  for (int z = 2; z < 31; z += 3) {
    for (int x = 2; x < 31; x += 3) {
      const Vec3 a = coded.voxel_gradient(x, 11, z), b = exact.voxel_gradient(x, 11, z);
      EXPECT_GT(dot(normalise(a), b), std::cos(3.5 * 3.14159265 / 180));
    }
  }
}

}  // namespace
}  // namespace gicube::reference
