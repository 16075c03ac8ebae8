// A program for mpirun: boards of the ranks that share a volume's blocks give pictures, host rays and light the bits of
// one board that stores it whole. Ends with exit code 1, and says what differs, if they do not.
// Usage: mpi_boards SCENES
#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "../board/brick_scenes.h"
#include "gicube/error.h"
#include "gicube/mpi.h"

namespace {

using namespace gicube;
using namespace gicube::reference;

void expect(bool is_so, const std::string& what) {
  if (!is_so) throw std::runtime_error(what);
}

struct Results {
  Image picture, lit;
  std::vector<TracedRay> rays;
  std::vector<float> irradiance;
};

// All ranks make the same random choices; rays are each rank's own.
void compare(MpiExchange& ranks, Board& shared, Board& endless, std::uint32_t scene) {
  std::mt19937 random(scene + 1);
  const Blobs blobs = make_blobs(random, 20, 50);
  const Material material = make_material(random);
  const std::vector<Light> lights{make_light(random, blobs.dims)};
  const Illumination settings = make_illumination(random, scene);
  const View view = make_view(random, blobs.dims, 24);
  std::mt19937 own(scene * 100 + static_cast<unsigned>(ranks.rank()));
  const auto rays = random_rays(own, blobs.dims, 40);
  const auto results = [&](Board& board) {
    board.set_transfer_function(fog_and_balls(0.02));
    board.set_material(material);
    board.load_volume(blobs.view());
    Results out;
    out.picture = board.render(view);
    out.rays = board.receive(board.submit(rays, {.type = RayType::kFirstHit, .opacity = 0.6})).rays;
    board.illuminate(lights, settings);
    out.irradiance = board.read_irradiance();
    View lit = view;
    lit.irradiance = lit.scatter = true;
    out.lit = board.render(lit);
    return out;
  };
  const Results got = results(shared), expected = results(endless);
  const std::string where = fmt::format("rank {}, scene {}: ", ranks.rank(), scene);
  expect(got.picture == expected.picture, where + "the picture differs");
  expect(got.rays == expected.rays, where + "a ray differs");
  expect(got.irradiance == expected.irradiance, where + "irradiance differs");
  expect(got.lit == expected.lit, where + "the lit picture differs");
}

void run(std::uint32_t scenes) {
  const std::string base = "emu:?set=asic.block_voxels=8&threads=1&set=asic.max_volume_voxels=";
  const std::shared_ptr<MpiExchange> ranks = MpiExchange::open();
  Board shared = Board::open(base + "32"), endless = Board::open(base + "64");
  shared.share_blocks(ranks);
  for (std::uint32_t scene = 0; scene < scenes; ++scene) compare(*ranks, shared, endless, scene);
  const std::uint64_t sent = ranks->sum(shared.counters().value("dsp.forwarded_rays"));
  const std::uint64_t came = ranks->sum(shared.counters().value("dsp.arrived_rays"));
  expect(sent == came && (sent > 0) == (ranks->ranks() > 1), fmt::format("{} rays were sent, {} came", sent, came));
  if (ranks->rank() == 0)
    fmt::print("{} ranks: {} rays between them, all bits are those of one board\n", ranks->ranks(), sent);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc > 1 ? static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10)) : 1);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "mpi_boards: {}\n", error.what());
    return 1;
  }
}
