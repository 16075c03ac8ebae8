// A board of a released version: its answers are those of a captured session, whatever the driver's order, pieces and
// numbers are.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "fake_board.h"
#include "gicube/wire/frame.h"

namespace gicube::captures {

class PastBoard {
 public:
  // Reads the session of a driver and a board of version 2.`minor`. Throws replay::CaptureError.
  PastBoard(const std::filesystem::path& capture, std::uint16_t minor);

  // The board's end of a session, for reference::FakeBoard. What the driver asks and was not asked then is refused.
  void serve(reference::FakeBoard& board);
  // What was refused, in words.
  const std::vector<std::string>& refused() const { return refused_; }

 private:
  using Request = std::pair<wire::FrameType, std::vector<std::uint8_t>>;

  reference::Frame answer_to(const reference::Frame& request);
  void send_completions(reference::FakeBoard& board);

  const std::uint16_t minor_;
  std::map<Request, std::deque<reference::Frame>> answers_;  // the last of them is given again
  std::map<std::uint32_t, std::uint64_t> completed_;         // ticket -> simulated time
  std::vector<reference::Frame> under_way_;
  std::vector<std::string> refused_;
};

}  // namespace gicube::captures
