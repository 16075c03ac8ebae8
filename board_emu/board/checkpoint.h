// A board's state as a file: gicube.v1.Checkpoint.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "board/board.h"
#include "config/config.h"
#include "gicube/v1/checkpoint.pb.h"

namespace gicube::emu {

// Saves or loads what stands around a board, such as its driver's state: fields whose names begin with "host.".
using Surroundings = std::function<void(Archive& archive)>;

// Hands the file's bytes to `sink`, piece by piece. Called like Board::state(); nothing changes.
void save_checkpoint(Board& board, const std::function<void(std::string_view)>& sink, const Surroundings& around = {});
// To a file that is whole or not there. Throws std::system_error.
void save_checkpoint(Board& board, const std::filesystem::path& file, const Surroundings& around = {});

// What differs between two resolved configurations and shapes a board's state, so that a board of `wanted` can't go on from a
// checkpoint of `saved`. Free are fidelity, threads, pace, the bus, the links, the queue policy, and how the DSP makes rays;
// in a command the bus, threads and pace alone.
std::vector<Diagnostic> fork_faults(const v1::BoardConfig& saved, const v1::BoardConfig& wanted,
                                    bool in_command = false);

// A checkpoint that is whole.
class Checkpoint {
 public:
  // Throws CheckpointFault if the bytes are no checkpoint, are damaged, or of a version that this board does not know.
  explicit Checkpoint(std::string bytes);
  // Throws std::system_error besides, if the file can't be read.
  static Checkpoint read(const std::filesystem::path& file);

  const v1::CheckpointHeader& header() const { return header_; }
  // Makes a new board what was saved. Of another fidelity than the saved one its level is as at power-up. Throws CheckpointFault;
  // the board must not be used then.
  void restore(Board& board) const;
  // Loads what stood around that board; `around` is not called if nothing of it was saved. Throws CheckpointFault.
  void surroundings(const Surroundings& around) const;

 private:
  std::string_view fields() const;

  std::string bytes_;
  std::size_t first_field_ = 0;  // where it begins
  v1::CheckpointHeader header_;
};

}  // namespace gicube::emu
