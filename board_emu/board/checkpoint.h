// Files of a board's state: gicube.v1.Checkpoint.
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

// Saves or loads state around a board, such as that of its driver, in fields whose names begin with "host.".
using Surroundings = std::function<void(Archive& archive)>;

// Passes the bytes of the file to `sink`, piece by piece. May be called when Board::state() may be. The board does not
// change.
void save_checkpoint(Board& board, const std::function<void(std::string_view)>& sink, const Surroundings& around = {});
// Writes a file completely or not at all. Throws std::system_error.
void save_checkpoint(Board& board, const std::filesystem::path& file, const Surroundings& around = {});

// Lists the differences between two resolved configurations that prevent a board of `wanted` from continuing a
// checkpoint of `saved`. Fidelity, threads, pace, the bus, the links, the queue policy and the DSP's ray generation may
// differ; within a command only the bus, threads and pace.
std::vector<Diagnostic> fork_faults(const v1::BoardConfig& saved, const v1::BoardConfig& wanted,
                                    bool in_command = false);

// A valid checkpoint.
class Checkpoint {
 public:
  // Throws CheckpointFault if the bytes are not a checkpoint, are damaged, or have an unsupported version.
  explicit Checkpoint(std::string bytes);
  // Also throws std::system_error if the file cannot be read.
  static Checkpoint read(const std::filesystem::path& file);

  const v1::CheckpointHeader& header() const { return header_; }
  // Restores the saved state in a new board. If its fidelity differs from the saved one, its level is in the power-up
  // state. May throw CheckpointFault; the board must not be used after that.
  void restore(Board& board) const;
  // Loads the state around the board. `around` is not called if none was saved. Throws CheckpointFault.
  void surroundings(const Surroundings& around) const;

 private:
  std::string_view fields() const;

  std::string bytes_;
  std::size_t first_field_ = 0;  // its offset
  v1::CheckpointHeader header_;
};

}  // namespace gicube::emu
