// A new reconstruction method on gicube::Projector, for views on any orbit, here a helix: gradient descent with
// momentum (Nesterov 1983) on half the squared residual of the projections, without values below 0.
//
//   c++ -std=c++20 -O2 own_method.cpp $(pkg-config --cflags --libs gicube) -o own_method
//   ./own_method
//
// Prints the residual of every tenth iteration, and the error of the volume. Returns 1 if that is above 1/10.
#include <gicube/projector.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "voxels.h"

using Values = std::vector<float>;

double norm(const Values& values) {
  double sum = 0;
  for (const float value : values) sum += double{value} * double{value};
  return std::sqrt(sum);
}

// The method, with its loop.
Values reconstruct(gicube::Projector& projector, const Values& measured, std::size_t voxels, int iterations) {
  // Greatest eigenvalue of backproject(project()), by the power method; steps of its inverse do not overshoot.
  Values x(voxels, 1.0F);
  double greatest = 1;
  for (int i = 0; i < 6; ++i) {
    x = projector.backproject(projector.project(x));
    greatest = norm(x);
    for (float& value : x) value /= static_cast<float>(greatest);
  }
  const auto step = static_cast<float>(0.95 / greatest);
  Values estimate(voxels), before(voxels), ahead(voxels);
  double momentum = 1;
  for (int i = 1; i <= iterations; ++i) {
    Values missing = projector.project(ahead);
    for (std::size_t k = 0; k < missing.size(); ++k) missing[k] = measured[k] - missing[k];
    const Values gradient = projector.backproject(missing);
    before.swap(estimate);
    for (std::size_t k = 0; k < voxels; ++k) estimate[k] = std::max(0.0F, ahead[k] + step * gradient[k]);
    const double next = (1 + std::sqrt(1 + 4 * momentum * momentum)) / 2;
    const auto on = static_cast<float>((momentum - 1) / next);
    for (std::size_t k = 0; k < voxels; ++k) ahead[k] = estimate[k] + on * (estimate[k] - before[k]);
    momentum = next;
    if (i % 10 == 0) std::printf("iteration %2d: residual %.4f\n", i, norm(missing) / norm(measured));
  }
  return estimate;
}

int main() {
  constexpr int kSize = 24, kHeight = 32, kViews = 72;
  gicube::ProjectorSetup setup{.dims = {kSize, kSize, kHeight}, .columns = 40, .rows = 24};
  for (int i = 0; i < kViews; ++i) {  // three turns, a pose each
    const double angle = i * 3 * 2 * std::numbers::pi / kViews, height = (i + 0.5) * kHeight / kViews - kHeight / 2.0;
    const gicube::Vec3 out{std::cos(angle), std::sin(angle), 0}, along{-out.y, out.x, 0}, up{0, 0, 1};
    setup.views.push_back({80.0 * out + height * up, -40.0 * out + height * up, 1.5 * along, 1.5 * up});
  }
  const Values object = make_voxels(setup.dims, [](gicube::Vec3 place) {  // two balls in a box
    const auto ball = [&](gicube::Vec3 centre, double radius) { return length(place - centre) < radius ? 1.0F : 0.0F; };
    return ball({8, 14, 9}, 5) + 0.5F * ball({15, 9, 22}, 6);
  });
  auto board = gicube::Board::open("emu:?set=asic.block_voxels=16");
  gicube::Projector projector(board, setup);
  const Values measured = projector.project(object);
  Values found = reconstruct(projector, measured, object.size(), 40);
  for (std::size_t i = 0; i < found.size(); ++i) found[i] -= object[i];
  const double error = norm(found) / norm(object);
  std::printf("error %.3f of the object, %.0f simulated ms\n", error, gicube::to_ms(board.now()));
  return error > 0.1;
}
