// Samples that a file holds as text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "scene/formats/stored_samples.h"

namespace gicube::samples {

// `count` numbers parted by white space or commas, from byte `offset` on, as samples in the machine's byte order.
// Throws FileError: too few, no number, or out of the type's range.
std::vector<std::byte> read_numbers(const std::filesystem::path& file, std::uint64_t offset, StoredType type,
                                    std::size_t count);

// `bytes` bytes of two hexadecimal digits each, white space allowed anywhere; the bytes as they stand.
// Throws FileError: too few, or another character.
std::vector<std::byte> read_hex(const std::filesystem::path& file, std::uint64_t offset, std::size_t bytes);

}  // namespace gicube::samples
