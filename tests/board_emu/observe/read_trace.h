// Reads a trace back as Perfetto would, and holds every track to its rules.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace gicube::emu {

struct ReadSlice {
  std::string name;
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;
  nlohmann::json args;
};

struct ReadTrace {
  // By "process/track" and "process/counter".
  std::map<std::string, std::vector<ReadSlice>> slices;
  std::map<std::string, std::vector<std::pair<std::int64_t, std::uint64_t>>> counters;
  std::map<std::string, std::vector<std::int64_t>> instants;

  // Of one argument over a track.
  std::uint64_t sum(const std::string& track, const std::string& argument) const;
};

std::string read_text(const std::string& path);

// Throws std::runtime_error if `text` is no JSON array of events, an event lies on a track without a name, or slices of
// a track overlap or are out of order.
ReadTrace read_trace(const std::string& text);

}  // namespace gicube::emu
