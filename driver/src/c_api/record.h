// Records that begin with their size: a caller may have been compiled with an older or a newer version of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "gicube/error.h"

namespace gicube::c_api {

inline constexpr std::size_t kLargestRecord = 65'536;  // bytes, chosen: a size beyond is no size but a stray value

// `min_size` is the record's size in the first version of this ABI. Throws BadArgument.
template <typename Record>
void check_size(const std::string& name, std::size_t size, std::size_t min_size) {
  if (size < min_size || size > kLargestRecord) {
    throw BadArgument(name + ".size",
                      std::to_string(min_size) + ".." + std::to_string(kLargestRecord) + " (sizeof the record)",
                      std::to_string(size));
  }
}

// The caller's record, with this library's defaults for what it does not have. Throws BadArgument.
template <typename Record>
Record read_record(const std::string& name, const Record* given, const Record& defaults,
                   std::size_t min_size = sizeof(Record)) {
  if (given == nullptr) throw BadArgument(name, "a pointer", "NULL");
  const std::size_t size = given->size;
  check_size<Record>(name, size, min_size);
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  for (std::size_t i = sizeof(Record); i < size; ++i) {
    if (bytes[i] != 0) {
      throw BadArgument(
          name, "zeros in fields that this library does not know (from byte " + std::to_string(sizeof(Record)) + " on)",
          std::to_string(bytes[i]) + " at byte " + std::to_string(i));
    }
  }
  Record record = defaults;
  std::memcpy(&record, given, std::min(size, sizeof(Record)));
  record.size = sizeof(Record);
  return record;
}

// Fills the caller's record as far as it goes, which has said its size. Throws BadArgument.
template <typename Record>
void write_record(const std::string& name, Record* out, Record record, std::size_t min_size = sizeof(Record)) {
  if (out == nullptr) throw BadArgument(name, "a pointer", "NULL");
  const std::uint32_t size = out->size;
  check_size<Record>(name, size, min_size);
  record.size = size;
  std::memcpy(static_cast<void*>(out), &record, std::min<std::size_t>(size, sizeof(Record)));
  if (size > sizeof(Record))
    std::memset(reinterpret_cast<unsigned char*>(out) + sizeof(Record), 0, size - sizeof(Record));
}

// For ..._init(): the same with a size that stands beside it.
template <typename Record>
void init_record(const std::string& name, Record* out, std::size_t size, const Record& defaults,
                 std::size_t min_size = sizeof(Record)) {
  if (out == nullptr) throw BadArgument(name, "a pointer", "NULL");
  check_size<Record>(name, size, min_size);
  out->size = static_cast<std::uint32_t>(size);
  write_record(name, out, defaults, min_size);
}

}  // namespace gicube::c_api
