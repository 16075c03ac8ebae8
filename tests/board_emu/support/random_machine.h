// Scenes, machines, views and rays at random, for tests that hold for all of them.
#pragma once

#include <initializer_list>
#include <random>
#include <string>
#include <vector>

#include "bare_board.h"
#include "machine_rig.h"

namespace gicube::emu {

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  int number(int low, int high) { return low + static_cast<int>(engine_() % static_cast<unsigned>(high - low + 1)); }
  bool chance(int percent) { return number(1, 100) <= percent; }
  template <typename T>
  T one_of(std::initializer_list<T> values) {
    return *(values.begin() + number(0, static_cast<int>(values.size()) - 1));
  }

 private:
  std::mt19937 engine_;
};

// Balls of different materials in clear air, with shading, jitter, leaping, termination and cut planes drawn.
void draw(Scene& scene, Dice& dice);
// Assignments for config_with().
std::vector<std::string> draw_machine(Dice& dice, int block_voxels);
// Some lamps round the volume, or none.
std::vector<wire::Lamp> draw_lamps(const Scene& scene, Dice& dice);
wire::RenderCommand draw_view(const Scene& scene, Dice& dice);
// Host rays from anywhere in the volume to anywhere; some carry what an earlier flight gathered.
std::vector<wire::Ray> draw_rays(const Scene& scene, Dice& dice);

wire::VoxelFormat format_of(const v1::BoardConfig& config);
// Packets that a tile takes in memory.
std::uint32_t packets_of_tile(const v1::BoardConfig& config);

std::string text(const std::vector<std::string>& assignments);
std::vector<std::string> counter_texts(const Machine& machine);

}  // namespace gicube::emu
