// Common parts of the programs' statistics files.
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

// The levels that executed the window's commands, and the parts that they do not model (gicube/fidelity.h): an object
// for each level, with the keys level, answered (commands by kind), not_modelled.
nlohmann::ordered_json fidelity_json(const Counters& counters);

// The time in which the bus was busy, both directions together.
double bus_ms(const Counters& counters);

// Energy of a window (docs/guide/energy.md), of all boards: keys joules (with its value, low and high),
// joules_per_sample, joules_per_ray. Null where the level counts no energy.
nlohmann::ordered_json energy_json(const Counters& counters);
// Watts of each of the `boards`, on average: mean over the window, and peak (of two milliseconds since the program
// began, without the host bus; or null), each with value, low and high; parts with the same; asic, as a mean;
// within_slot, within_packages. Null where the level counts no energy.
nlohmann::ordered_json power_json(const Counters& counters, Picoseconds time, std::size_t boards = 1);
// A sentence with both; empty where the level counts no energy.
std::string energy_line(const Counters& counters, Picoseconds time, std::size_t boards = 1);

// The prefix of the memory's counters, such as "rdram" or "ddr": sums over all channels are "rdram.reads" and so on,
// those of channel 0 "rdram0.reads". Empty if the board has none.
std::string memory_of(const Counters& counters);

// The cost of a part of the work. Keys: board_ms bus_ms bus_down_bytes bus_up_bytes host_seconds board bound
// (what_bounds()) counters energy power fidelity_report.
nlohmann::ordered_json cost_json(const BoardInfo& board, RunWindow& window);

// this_run() with the board and the hash of the input.
Provenance provenance_of(const BoardInfo& board, std::uint64_t scene_hash);

// With `provenance` as a last key. Throws FileError.
void write_json(nlohmann::ordered_json json, const Provenance& provenance, const std::filesystem::path& path);

}  // namespace gicube::samples
