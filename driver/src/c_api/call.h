// What every function of the C ABI is made of: the board's handle, checks of arguments, and call(), which catches what is thrown
// and remembers its words for the thread.
#pragma once

#include <concepts>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "gicube/board.h"
#include "gicube/c_api.h"
#include "gicube/error.h"

struct GICUBE_HIDDEN gicube_board {
  explicit gicube_board(gicube::Board opened) : board(std::move(opened)) {}

  gicube::Board board;
  std::mutex mutex;                                   // of what follows; never held while the board works
  std::map<std::uint32_t, gicube::RayBatch> arrived;  // polled, and not received yet
  std::vector<std::uint32_t> announce;  // of those, in their order, the ones to tell gicube_poll()'s caller
  std::vector<std::string> warnings;    // of the last illumination
  std::pair<int, int> framebuffer{};    // width and height
};

namespace gicube::c_api {

// A callback of the caller's asked for the end of the call.
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

// Checks of arguments; each throws BadArgument that names it.

template <typename T>
T& checked(const char* name, T* pointer) {
  if (pointer == nullptr) throw BadArgument(name, "a pointer", "NULL");
  return *pointer;
}

// `count` elements at `pointer`, which may be NULL only if there are none.
template <typename T>
T* checked(const std::string& name, T* pointer, std::size_t count) {
  constexpr std::size_t kMax = PTRDIFF_MAX / sizeof(T);
  if (count > kMax) throw BadArgument(name, "at most " + std::to_string(kMax) + " of them", std::to_string(count));
  if (pointer == nullptr && count > 0) throw BadArgument(name, "a pointer", "NULL");
  return pointer;
}

// The size of an array that the call fills or takes.
inline void check_count(const std::string& name, std::size_t got, std::size_t expected) {
  if (got != expected) throw BadArgument(name, std::to_string(expected), std::to_string(got));
}

template <typename Enum>
Enum choice(const std::string& name, std::int32_t value, Enum last) {
  if (value < 0 || value > static_cast<std::int32_t>(last)) {
    throw BadArgument(name, "0.." + std::to_string(static_cast<std::int32_t>(last)), std::to_string(value));
  }
  return static_cast<Enum>(value);
}

inline bool truth(const std::string& name, std::int32_t value) {
  if (value != 0 && value != 1) throw BadArgument(name, "0 or 1", std::to_string(value));
  return value == 1;
}

template <std::integral T>
void check_reserved(const std::string& name, T value) {
  if (value != 0) throw BadArgument(name, "0", std::to_string(value));
}

inline gicube_board& checked_board(gicube_board* board) {
  if (board == nullptr) throw BadArgument("board", "an open board", "NULL");
  return *board;
}

// A call about a board, which is checked before its other arguments: work(its handle).
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

inline Vec3 to_vec3(const double (&xyz)[3]) { return {xyz[0], xyz[1], xyz[2]}; }

inline void put(Vec3 from, double (&xyz)[3]) {
  xyz[0] = from.x;
  xyz[1] = from.y;
  xyz[2] = from.z;
}

// Calls that move one value a voxel of a box.
gicube_status read_box(gicube_board* board, const gicube_box* box, float* values, std::size_t count,
                       std::vector<float> (Board::*read)(const VoxelBox&));
gicube_status write_box(gicube_board* board, const gicube_box* box, const float* values, std::size_t count,
                        void (Board::*write)(const VoxelBox&, std::span<const float>));

gicube_lighting_report to_c(const LightingReport& report);

}  // namespace gicube::c_api
