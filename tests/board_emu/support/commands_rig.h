// What tests of the DSP's commands share: a small board, and what a command's completion says.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bare_board.h"

namespace gicube::emu {

inline v1::BoardConfig blocks_of_eight(v1::FidelityLevel level = v1::functional) {
  v1::BoardConfig config;
  config.set_fidelity(level);
  config.mutable_asic()->set_block_voxels(8);
  config.set_threads(1);
  return config;
}

// 17^3 voxels of one opacity.
inline void load_fog(BareBoard& board, std::uint16_t opacity) {
  board.load_volume({17, 17, 17}, [](int, int, int) { return wire::Voxel{1000, 0, 0, 0}; });
  board.write_segmentation([opacity](unsigned, unsigned) {
    return wire::SegmentationEntry{{2048, 2048, 2048}, opacity};
  });
}

// A ray of so many units for each cell of the face that looks along `towards`: by default they run along -z.
inline wire::IlluminateCommand sunlight(double energy, const std::array<double, 3>& towards = {0, 0, 1}) {
  wire::IlluminateCommand command;
  command.kind = wire::LightKind::kDirectional;
  command.energy = energy;
  command.u = towards;
  return command;
}

inline Completion carry_out(BareBoard& board, const std::vector<std::uint8_t>& payload) {
  return board.wait(board.command(payload)).completions.at(0);
}
inline std::string refusal(BareBoard& board, const std::vector<std::uint8_t>& payload) {
  const Completion done = carry_out(board, payload);
  return done.error == wire::ErrorCode::kNone ? "accepted" : std::string(done.payload.begin(), done.payload.end());
}

}  // namespace gicube::emu
