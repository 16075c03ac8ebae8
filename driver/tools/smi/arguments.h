// Arguments that CLI11 does not support by itself: options on both sides of the command, times with units.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace gicube::smi {

// `words`, without the program's name. Options before a command are moved after it.
std::vector<std::string> command_first(const CLI::App& app, const std::vector<std::string>& words);

// "500ms", "2s", "1.5s", "1min". Throws std::invalid_argument, "expected ..., got ...".
std::chrono::milliseconds time_with_unit(const std::string& text);

}  // namespace gicube::smi
