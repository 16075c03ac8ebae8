// Counters of the shown board, ten times per second while a page shows them, also during a frame.
//
// The board is busy with a call then, so its process is queried by its socket in the user's registry
// (proto/gicube/registry.h). A board of another machine or user is not there: its counters are updated after each
// picture.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "gicube/board.h"
#include "scene/names.h"

namespace gicube::samples::view {

// State of a board since its start.
struct BoardLook {
  Picoseconds simulated = 0;
  Counters counters;
  nlohmann::ordered_json machine = nullptr;  // as in protocol.h; null: unknown
};

// Finds the board of this URI and configuration in the registry, opened by this process if it is private. Nothing if
// there is none.
std::optional<BoardLook> look_at(const std::string& uri, std::uint64_t config_hash);

class LiveCounters {
 public:
  // Called for each state that differs from the previous one, on a thread of this class. `with_units`: the first time
  // for a page.
  using Tell = std::function<void(std::uint64_t page, const BoardLook& look, bool running, bool with_units)>;
  explicit LiveCounters(Tell tell);
  ~LiveCounters();
  LiveCounters(const LiveCounters&) = delete;
  LiveCounters& operator=(const LiveCounters&) = delete;

  // These may be called from any thread.
  void listen(std::uint64_t page, bool on);
  void show(const std::string& uri, std::uint64_t config_hash);  // empty: none
  void set_running(bool running);
  // Reports the board's own counters, if its process cannot be queried.
  void counted(const BoardLook& look);

 private:
  void work();

  const Tell tell_;
  std::mutex mutex_;  // guards the following members
  std::condition_variable wake_;
  std::set<std::uint64_t> pages_, new_pages_;  // new: without a message so far
  std::string uri_;
  std::uint64_t config_hash_ = 0;
  std::optional<BoardLook> counted_;
  bool running_ = false;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace gicube::samples::view
