#include "good_client.h"

#include <cmath>

namespace gicube::system_test {

std::vector<std::string> small_board() {
  return {"--set", "asic.block_voxels=8", "--set", "asic.max_volume_voxels=32", "--set", "threads=1", "--quiet"};
}

GoodVolume::GoodVolume() {
  for (int z = 0; z < kEdge; ++z) {
    for (int y = 0; y < kEdge; ++y) {
      for (int x = 0; x < kEdge; ++x) {
        const double r = std::hypot(x - 11.5, y - 12.5, z - 10.5);
        samples_.push_back(static_cast<std::byte>(r < 10 ? 90 + 3 * x + 2 * y + z : 0));
      }
    }
  }
}

TransferFunction good_function() {
  return {.colours = {{0, {0.2, 0.5, 0.9}}, {255, {1, 0.7, 0.1}}}, .opacities = {{60, 0}, {255, 0.25}}};
}

View good_view(int turn) {
  View view;
  view.eye = {60 * std::cos(turn * 0.7), 20, 60 * std::sin(turn * 0.7)};
  view.look_at = {11.5, 11.5, 11.5};
  view.width = view.height = 48;
  return view;
}

// Low-discrepancy points and directions: a golden-ratio sequence in each coordinate.
HostRay good_ray(std::uint64_t number) {
  const auto part = [number](double step) { return std::fmod(static_cast<double>(number % 1'000'003) * step, 1.0); };
  HostRay ray;
  ray.id = static_cast<std::uint32_t>(number);
  ray.position = {22 * part(0.6180339887), 22 * part(0.7548776662), 22 * part(0.5698402910)};
  const double z = 2 * part(0.8191725134) - 1, angle = 6.283185307 * part(0.6710436067), r = std::sqrt(1 - z * z);
  ray.direction = {r * std::cos(angle), r * std::sin(angle), z};
  return ray;
}

std::vector<HostRay> good_rays(std::uint64_t first, std::size_t count) {
  std::vector<HostRay> rays;
  for (std::size_t i = 0; i < count; ++i) rays.push_back(good_ray(first + i));
  return rays;
}

void prepare(Board& board) {
  static const GoodVolume volume;
  board.set_transfer_function(good_function());
  board.load_volume(volume.view());
}

bool operator==(const Round& a, const Round& b) {
  if (a.pictures != b.pictures || a.begin != b.begin || a.end != b.end || a.batches.size() != b.batches.size()) {
    return false;
  }
  for (std::size_t i = 0; i < a.batches.size(); ++i) {
    if (a.batches[i].rays != b.batches[i].rays || a.batches[i].completed != b.batches[i].completed) return false;
  }
  return true;
}

Round work(Board& board) {
  Round round;
  round.begin = board.now();
  for (int turn = 0; turn < 3; ++turn) {
    round.pictures.push_back(board.render(good_view(turn)));
    const Ticket first = board.submit(good_rays(static_cast<std::uint64_t>(turn) * 1000, 500));
    const Ticket second = board.submit(good_rays(static_cast<std::uint64_t>(turn) * 1000 + 500, 500));
    board.host_compute(1'000'000);
    round.batches.push_back(board.receive(second));
    round.batches.push_back(board.receive(first));
  }
  round.end = board.now();
  return round;
}

}  // namespace gicube::system_test
