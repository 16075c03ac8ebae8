// A page's request (protocol.h), read from its message.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace gicube::samples::view {

// Options of gicube-render without their dashes.
using Settings = std::map<std::string, std::string>;

struct Request {
  enum class Kind { kPicture, kSlice, kHistogram, kOpen, kMachine, kCompare, kBoard };
  Kind kind = Kind::kPicture;
  std::uint64_t id = 0;
  bool on = false;  // kPicture: something moves; kMachine: send counters
  Settings settings, other;
  enum class Projection { kNone, kMaximum, kMean };
  Projection projection = Projection::kNone;  // kPicture
  int axis = 0;                               // kSlice: 0..2, and the voxel
  int at = 0;
  std::vector<std::string> names;
};

// Throws InputError: the text is not a message of protocol.h.
Request parse_request(std::string_view text);

// Whether a posted file may have this name: no slash, no control character, no leading dot, at most 200 bytes.
bool is_file_name(std::string_view name);

}  // namespace gicube::samples::view
