#include "gicube/scene/voxeliser.h"

#include "test.h"

namespace gicube::scene {
namespace {

double degrees_to_nearest(Vec3 g, const std::vector<Vec3>& codes) {
  double best = -1;
  for (std::size_t i = 1; i < codes.size(); ++i) best = std::max(best, dot(g, codes[i]));
  return std::acos(std::min(best, 1.0)) * 180 / std::numbers::pi;
}

void add(Vec3 g, std::vector<float>& gradients) {
  gradients.insert(gradients.end(), {static_cast<float>(g.x), static_cast<float>(g.y), static_cast<float>(g.z)});
}

TEST(Codebook, HoldsEveryDirectionOfAVolumeWithFew) {
  std::vector<float> gradients(300, 0.0f);
  for (const Vec3 g : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0.6, 0.8, 0}, Vec3{0, 0, 1}}) add(g, gradients);
  const std::vector<Vec3> codes = codebook_of(gradients);
  ASSERT_EQ(codes.size(), 4u);
  EXPECT_EQ(codes[0], (Vec3{}));
  for (const Vec3 g : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0.6, 0.8, 0}}) EXPECT_LT(degrees_to_nearest(g, codes), 0.15);
}

TEST(Codebook, IsFinerThanOneForAllDirectionsWhereAVolumeHasOnlySome) {
  std::vector<float> gradients;  // a ring's: within five degrees of a plane
  std::mt19937 random(2);
  std::uniform_real_distribution<double> turn(0, 2 * std::numbers::pi), tilt(-0.09, 0.09);
  for (int i = 0; i < 20'000; ++i) {
    const double t = turn(random);
    add(normalise({std::cos(t), std::sin(t), tilt(random)}), gradients);
  }
  const std::vector<Vec3> codes = codebook_of(gradients);
  ASSERT_EQ(codes.size(), kCodes);
  double worst = 0;
  for (std::size_t i = 0; i < gradients.size(); i += 3) {
    worst = std::max(worst, degrees_to_nearest(normalise({gradients[i], gradients[i + 1], gradients[i + 2]}), codes));
  }
  EXPECT_LT(worst, 1.2);  // 2047 codes for the whole sphere leave 2.8 at best
  for (std::size_t i = 1; i < codes.size(); ++i) EXPECT_NEAR(length(codes[i]), 1, 1e-9);
}

TEST(Codebook, OfNothingIsTheZeroVector) { EXPECT_EQ(codebook_of({}).size(), 1u); }

}  // namespace
}  // namespace gicube::scene
