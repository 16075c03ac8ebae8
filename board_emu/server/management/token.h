// The secret of remote management.
#pragma once

#include <string>
#include <string_view>

namespace gicube::emu {

inline constexpr std::size_t kMinTokenBytes = 16;  // chosen: 64 bits and more, if its digits are random

// The file's content without its line end. Throws std::runtime_error if the file can't be read, if others than its owner
// may, or if the token is too short.
std::string read_token(const std::string& path);

// True if the header is "Bearer " and the token; takes the same time wherever they differ.
bool is_authorized(std::string_view authorization, std::string_view token);

}  // namespace gicube::emu
