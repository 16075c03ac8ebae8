// The parts that the programs' statistics files share.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "gicube/board.h"
#include "gicube/scene/provenance.h"
#include "scene/names.h"

namespace gicube::samples {

class RunWindow;

// An object: name to { value, unit }.
nlohmann::ordered_json to_json(const Counters& counters);

// Keys: fidelity config_hash.
nlohmann::ordered_json to_json(const BoardInfo& board);

// What answered the window's commands, and what its figures leave out (gicube/fidelity.h): an object for each level, with the keys level,
// answered (commands by kind), not_modelled, estimates (quantity, within, relative, measured_on, source).
nlohmann::ordered_json fidelity_json(const Counters& counters);

// What was estimated of the window's commands (docs/reference/hardware.md#sampled-commands): null if the board doesn't sample. Keys: commands
// estimated_commands, and for each of cycles, packets, missed_voxels: the sum, and within, half of its interval at 99.7%.
nlohmann::ordered_json sampled_json(const Counters& counters);
// The same in a line, with whether `error` was reached, if it is not 0; empty if the board doesn't sample.
std::string sampled_line(const Counters& counters, double error);

// Time in which the bus was busy, both directions together.
double bus_ms(const Counters& counters);

// The memory's standard, as "rdram" or "ddr", under which the board counts what its memories do: the sums over all channels are
// "rdram.reads" and so on, those of channel 0 "rdram0.reads". Empty if the board counts none.
std::string memory_of(const Counters& counters);

// What a part of the work cost. Keys: board_ms bus_ms bus_down_bytes bus_up_bytes host_seconds board counters fidelity_report sampled.
nlohmann::ordered_json cost_json(const BoardInfo& board, RunWindow& window);

// this_run() with the board, and the hash of what was computed with.
Provenance provenance_of(const BoardInfo& board, std::uint64_t scene_hash);

// With `provenance` as a last key. Throws FileError.
void write_json(nlohmann::ordered_json json, const Provenance& provenance, const std::filesystem::path& path);

}  // namespace gicube::samples
