// Describes a paused machine in words.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cycle/machine.h"

namespace gicube::emu {

// States for each processor what it waits for, as a chain to the part that blocks the others.
std::string why_nothing_moves(Cycle now, const Machine& machine);

// Answers "queue P", "queue P Q", "cache P X Y Z", "cache P set S", "bank M D B", "link" and "parts". Throws
// std::invalid_argument.
std::string view_of(const std::vector<std::string>& words, const Machine& machine);

// The words of a ray as text.
std::string words_of(const RayUnderWay& ray);
// An event of a ray's history as one line.
std::string line_of(const RayEvent& event);

// Sets a word of a ray: colour R G B (0..4095), opacity N (0..2^24 - 1). Throws std::invalid_argument.
void set_word(const std::vector<std::string>& words, std::size_t at, RayUnderWay& ray);

}  // namespace gicube::emu
