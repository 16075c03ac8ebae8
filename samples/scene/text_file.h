// Small files of text, read and written whole.
#pragma once

#include <filesystem>
#include <string>

namespace gicube::samples {

// A file that a user wrote. Throws InputError: it is not there, has more than a mebibyte, or can't be read; `what` it was to be.
std::string read_text(const std::filesystem::path& file, const std::string& what);
// Throws InputError.
void write_text(const std::filesystem::path& file, const std::string& text);

// In quotes if it has commas, quotes or line ends (RFC 4180).
std::string csv_cell(const std::string& cell);

}  // namespace gicube::samples
