// The board's end of a link, played by a script: sends and expects frames byte by byte, so that it can also misbehave.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "gicube/wire/frame.h"
#include "transport/fd.h"
#include "transport/link.h"

namespace gicube::reference {

struct Frame {
  wire::FrameHeader header;
  std::vector<std::uint8_t> payload;
};

class FakeBoard {
 public:
  using Script = std::function<void(FakeBoard&)>;

  // Runs the script on a thread of its own; its end of the socket closes when the script returns.
  explicit FakeBoard(Script script);
  // The same for the first driver that connects to the Unix socket `path`, which it makes.
  FakeBoard(const std::string& path, Script script);
  // Waits for the script's end.
  ~FakeBoard();

  // The driver's end; once.
  Fd take_socket() { return std::move(driver_end_); }

  // For scripts. All block; receive() gives nothing once the driver has closed.
  std::optional<Frame> receive();
  std::optional<Frame> receive_until(wire::FrameType type);  // the first of that type; the others are dropped
  void send(wire::FrameHeader header, std::span<const std::uint8_t> payload = {});
  void send_bytes(std::span<const std::uint8_t> bytes);
  void respond(const Frame& request, std::uint64_t time_ps, std::span<const std::uint8_t> payload = {});
  void refuse(const Frame& request, wire::ErrorCode error, std::string_view text);
  void complete(std::uint32_t ticket, std::uint64_t time_ps, std::span<const std::uint8_t> payload = {});
  void progress(std::uint32_t ticket, std::uint32_t done, std::uint32_t all);
  void return_credit(std::uint32_t slots, std::uint64_t bytes);
  // Answers the driver's version with `mine`; returns what the driver said.
  wire::VersionInfo shake_hands(const wire::VersionInfo& mine = {});
  // The next numbered frame follows on number `sequence`.
  void continue_from(std::uint32_t sequence) { sent_ = sequence; }
  // Receives until the driver closes.
  void drain();
  bool readable_within(int milliseconds) const;

 private:
  bool receive_bytes(std::span<std::uint8_t> bytes);

  Fd driver_end_;
  Fd board_end_;
  std::uint32_t sent_ = 0;  // sequence number of the last frame
  std::thread thread_;
};

std::vector<std::uint8_t> bytes_of(std::string_view text);

}  // namespace gicube::reference

namespace gicube {

// Without the questions of a call that waits long: scripts count frames.
inline const LinkOptions kPatient{.watchdog = std::chrono::seconds(60), .probe = std::chrono::hours(1)};

// Shakes hands, does what `script` says, and then receives until the driver closes.
inline reference::FakeBoard::Script in_session(reference::FakeBoard::Script script,
                                               const wire::VersionInfo& version = {}) {
  return [script = std::move(script), version](reference::FakeBoard& self) {
    self.shake_hands(version);
    script(self);
    self.drain();
  };
}

}  // namespace gicube
