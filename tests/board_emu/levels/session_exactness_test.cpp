// A host that does anything with a board gets the same bits from every level, on every machine and bus, by any number
// of threads.
#include "random_session.h"
#include "seeds.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr int kEdge = 8, kSteps = 40;  // voxels of a block, things that the host does

// What a host hears of values, without the times. It waits for each thing that it does, since what it does next depends
// on what has come.
std::vector<std::string> heard(const v1::BoardConfig& config, unsigned seed) {
  RandomHost host(seed, kEdge);
  Board board(config, 1);
  host.begin(board);
  for (int i = 0; i < kSteps; ++i) {
    host.step(board);
    host.end(board);
  }
  host.read_memories(board);
  std::vector<std::string> out;
  for (const std::string& line : host.heard()) {
    if (line.starts_with("counters")) continue;
    const std::size_t at = line.find(" at ");
    out.push_back(line.substr(0, at) + line.substr(line.find(": ", at)));
  }
  return out;
}

class Sessions : public testing::TestWithParam<unsigned> {};

TEST_P(Sessions, HearTheSameFromEveryBoard) {
  Dice dice(GetParam());
  std::vector<std::string> machine = draw_machine(dice, kEdge);
  machine.push_back("threads=1");
  if (dice.chance(50)) machine.insert(machine.end(), {"asic.datapath=wide", "cache.irradiance=with_voxels"});
  v1::BoardConfig config = config_with(machine);
  SCOPED_TRACE(config.ShortDebugString());
  config.set_fidelity(v1::functional);
  const std::vector<std::string> expected = heard(config, GetParam());
  config.set_fidelity(v1::cycle);
  EXPECT_EQ(heard(config, GetParam()), expected) << "cycle";
  // Another machine that has the same words: what divides the work, and when it is done, is not seen in it.
  config.set_fidelity(v1::functional);
  config.set_threads(3);
  config.mutable_bus()->set_model(v1::agp4x);
  config.mutable_asic()->set_processors(1 + config.asic().processors() % 16);
  config.mutable_asic()->set_queue_rays(2 * config.asic().queue_rays());
  config.mutable_sorter()->set_policy(v1::longest_wait);
  EXPECT_EQ(heard(config, GetParam()), expected) << "another machine";
}

INSTANTIATE_TEST_SUITE_P(Random, Sessions, seeds(30));

}  // namespace
}  // namespace gicube::emu
