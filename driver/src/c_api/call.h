// Common parts of all functions of the C ABI: the board's handle, checks of arguments, and call(), which catches and
// records errors.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "c_api/fields.h"
#include "encode/argument.h"
#include "gicube/board.h"
#include "gicube/c_api.h"

struct GICUBE_HIDDEN gicube_board {
  explicit gicube_board(gicube::Board opened) : board(std::move(opened)) {}

  gicube::Board board;
  std::mutex mutex;                                        // guards what follows; never held while the board works
  std::map<std::uint32_t, gicube::RayBatch> arrived;       // polled, but not received yet
  std::vector<std::uint32_t> announce;                     // those to report to gicube_poll()'s caller, in their order
  std::vector<std::string> warnings;                       // of the last illumination
  std::pair<int, int> framebuffer{};                       // width and height
  gicube::Sampling sampling{};                             // of the last view rendered
  std::map<std::uint32_t, std::vector<std::size_t>> legs;  // of the lines of a batch, by its ticket
  std::string why_invisible;                               // of the last picture read; empty: something is visible
};

namespace gicube::c_api {

// A callback of the caller asked to end the call.
struct Stopped : Error {
  using Error::Error;
};

// Keeps the error that is being handled for gicube_last_error(), and returns its status. Never throws.
gicube_status remember_current_error() noexcept;

template <std::invocable Work>
gicube_status call(const Work& work) noexcept {
  try {
    work();
    return GICUBE_OK;
  } catch (...) {
    return remember_current_error();
  }
}

// Checks of arguments, which throw BadArgument with the argument's name.

template <typename T>
T& checked(const char* name, T* pointer) {
  if (pointer == nullptr) throw BadArgument(name, "a pointer", "NULL");
  return *pointer;
}

// `count` elements at `pointer`, which may be NULL only if `count` is 0.
template <typename T>
T* checked(const std::string& name, T* pointer, std::size_t count) {
  constexpr std::size_t kMax = PTRDIFF_MAX / sizeof(T);
  expect(count <= kMax, name, fmt::format("at most {}", kMax), count);
  if (pointer == nullptr && count > 0) throw BadArgument(name, "a pointer", "NULL");
  return pointer;
}

// The values for which the items of an array stand, for instance "elements[3]".
template <typename T, typename Record>
std::vector<T> from_records(const std::string& name, const Record* records, std::size_t count) {
  checked(name, records, count);
  std::vector<T> values;
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(from_record<T>(fmt::format("{}[{}]", name, i), records[i]));
  }
  return values;
}

// The size of an array that the call fills or takes.
inline void check_count(const std::string& name, std::size_t got, std::size_t expected) {
  expect(got == expected, name, fmt::format("{}", expected), got);
}

inline gicube_board& checked_board(gicube_board* board) {
  if (board == nullptr) throw BadArgument("board", "an open board", "NULL");
  return *board;
}

// A call for a board, which is checked before the other arguments: work(its handle).
template <std::invocable<gicube_board&> Work>
gicube_status on_board(gicube_board* board, const Work& work) noexcept {
  return call([&] { work(checked_board(board)); });
}

// The caller's progress callback as the driver's; empty if it is NULL.
inline Progress to_progress(gicube_progress progress, void* user) {
  if (progress == nullptr) return {};
  return [progress, user](std::uint32_t done, std::uint32_t all) {
    if (progress(user, done, all) != 0) throw Stopped("the progress callback ended the call");
  };
}

gicube_lighting_report to_c(const LightingReport& report);
View to_view(const gicube_view* given, const std::string& name);
VolumeView to_volume(const gicube_volume* given);
Illumination to_illumination(const gicube_illumination* settings);

// These keep in the handle a picture's view, why nothing was visible in a picture, and an illumination's warnings.
void remember_view(gicube_board& handle, const View& view);
void hand_over(gicube_board& handle, const Image& image, gicube_pixel* pixels, std::size_t count);
void hand_over(gicube_board& handle, const LightingReport& result, gicube_lighting_report* report);

// Records begin with their size, since the caller may have been compiled with an older or a newer version.

inline constexpr std::size_t kLargestRecord = 65'536;  // bytes, chosen: a larger value is an uninitialized one

// Throws BadArgument.
template <typename Record>
void check_size(const std::string& name, const Record* record, std::size_t size) {
  if (record == nullptr) throw BadArgument(name, "a pointer", "NULL");
  expect(size >= kFirstSize<Record> && size <= kLargestRecord, name + ".size",
         fmt::format("{}..{} (sizeof the record)", kFirstSize<Record>, kLargestRecord), size);
}
// Accepts NULL as well.
template <typename Record>
void check_optional(const std::string& name, const Record* record) {
  if (record != nullptr) check_size(name, record, record->size);
}

// Overwrites `record`, which has the defaults, with the fields of the caller's record. Throws BadArgument.
template <typename Record>
void read_record(const std::string& name, const Record* given, Record& record) {
  check_size(name, given, given == nullptr ? 0 : given->size);
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  for (std::size_t i = sizeof(Record); i < given->size; ++i) {
    const auto unknown = [] {
      return fmt::format("zeros in fields that this library does not know (from byte {} on)", sizeof(Record));
    };
    if (bytes[i] != 0) throw BadArgument(name, unknown(), fmt::format("{} at byte {}", bytes[i], i));
  }
  std::memcpy(static_cast<void*>(&record), given, std::min<std::size_t>(given->size, sizeof(Record)));
}

// Fills the caller's record of `size` bytes. Throws BadArgument.
template <typename Record>
void write_record(const std::string& name, Record* out, std::size_t size, Record record) {
  check_size(name, out, size);
  record.size = static_cast<std::uint32_t>(size);
  std::memset(static_cast<void*>(out), 0, size);
  std::memcpy(static_cast<void*>(out), &record, std::min(size, sizeof(Record)));
}
template <typename Record>
void write_record(const std::string& name, Record* out, const Record& record) {
  write_record(name, out, out == nullptr ? 0 : out->size, record);
}

// For ..._init(): the defaults of the C++ API.
template <typename T, typename Record>
gicube_status init(const char* name, Record* out, std::size_t size) {
  return call([&] { write_record(name, out, size, to_record<Record>(T{})); });
}

// Converts the caller's record. Throws BadArgument. Leaves the copied bytes in `record`, for fields that are not plain
// values.
template <typename T, typename Record>
T read_fields(const char* name, const Record* given, Record& record) {
  T value;
  record = to_record<Record>(value);
  read_record(name, given, record);
  copy_fields(Copy<false>{name}, record, value);
  return value;
}

template <typename T, typename Record>
T read_fields(const char* name, const Record* given) {
  Record record;
  return read_fields<T>(name, given, record);
}

// Converts a record that may be NULL, for all defaults.
template <typename T, typename Record>
T read_optional(const char* name, const Record* given) {
  return given == nullptr ? T() : read_fields<T>(name, given);
}

}  // namespace gicube::c_api
