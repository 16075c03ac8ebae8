// A stopped machine in words.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cycle/machine.h"

namespace gicube::emu {

// What each part waits for, and on whom, as a chain from each processor to the part that holds the others up.
std::string why_nothing_moves(Cycle now, const Machine& machine);

// "queue P", "queue P Q", "cache P X Y Z", "bank M D B", "link P", "parts". Throws std::invalid_argument.
std::string view_of(const std::vector<std::string>& words, const Machine& machine);

// A ray's words.
std::string words_of(const RayUnderWay& ray);
// An event of a ray's history in a line.
std::string line_of(const RayEvent& event);

// Sets a word of a ray: colour R G B (0..4095), opacity N (0..2^24 - 1). Throws std::invalid_argument.
void set_word(const std::vector<std::string>& words, std::size_t at, RayUnderWay& ray);

}  // namespace gicube::emu
