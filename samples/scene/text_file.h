// Small files of text.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace gicube::samples {

// A file that a user wrote. Throws InputError: it is not there, is larger, or can't be read; `kind` says what it was to be.
std::string read_text(const std::filesystem::path& file, const std::string& kind, std::uintmax_t max_mib = 1);

}  // namespace gicube::samples
