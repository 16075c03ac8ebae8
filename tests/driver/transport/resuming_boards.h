// Scripted boards for links whose connection breaks.
#pragma once

#include "fake_board.h"
#include "gicube/error.h"
#include "test.h"
#include "transport/link.h"

namespace gicube {

using reference::FakeBoard;
using wire::FrameType;

inline constexpr std::uint64_t kToken = 77;

inline wire::VersionInfo board_with_session(std::uint32_t taken = 0, std::uint32_t consumed = 0) {
  wire::VersionInfo info;
  info.session = kToken;
  info.taken = taken;
  info.consumed = consumed;
  return info;
}

// Breaks the connection after `frames` of a session that can be resumed.
inline FakeBoard::Script hang_up_after(int frames) {
  return [frames](FakeBoard& self) {
    self.shake_hands(board_with_session());
    for (int i = 0; i < frames; ++i) self.receive();
  };
}

// Scripts for one connection after the other.
class Boards {
 public:
  explicit Boards(std::deque<FakeBoard::Script> scripts) : scripts_(std::move(scripts)) {}
  Fd connect() {
    if (scripts_.empty()) throw OpenFailed("no board is left");
    boards_.push_back(std::make_unique<FakeBoard>(std::move(scripts_.front())));
    scripts_.pop_front();
    return boards_.back()->take_socket();
  }
  LinkOptions options(int attempts = 0) {
    LinkOptions options;
    options.watchdog = std::chrono::seconds(60);
    options.reconnect = [this] { return connect(); };
    options.reopen_attempts = attempts;
    return options;
  }

 private:
  std::deque<FakeBoard::Script> scripts_;
  std::vector<std::unique_ptr<FakeBoard>> boards_;
};

inline std::string text_of_loss(Link& link) {
  return message_of<DeviceLost>([&] { link.request(FrameType::kCounters, 0, {}); });
}

inline Loss cause_of_loss(Link& link) {
  try {
    link.request(FrameType::kCounters, 0, {});
  } catch (const DeviceLost& error) {
    return error.cause();
  }
  ADD_FAILURE() << "the link was not lost";
  return Loss::kEnded;
}

}  // namespace gicube
