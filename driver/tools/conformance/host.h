// The host's side of one session, which checks what every session promises: credit, numbers, response forms and times.
#pragma once

#include <cstdint>
#include <deque>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "case.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/record.h"
#include "gicube/wire/registers.h"
#include "gicube/wire/reliable_window.h"
#include "place.h"

namespace gicube::conformance {

namespace reg = wire::reg;
using wire::ErrorCode;
using wire::FrameHeader;
using wire::FrameType;
using Bytes = std::vector<std::uint8_t>;

// Little-endian words of 32 bits.
Bytes words(std::initializer_list<std::uint32_t> values);
Bytes long_words(std::initializer_list<std::uint64_t> values);
wire::VersionInfo host_version();

class Host {
 public:
  // Opens a session; a board that another client has is waited for. Throws Failure if it is refused.
  explicit Host(Place& place, const wire::VersionInfo& mine = host_version());
  // Says goodbye.
  ~Host();
  Host(Host&&) = delete;

  RawClient& wire() { return client_; }
  wire::ReliableWindow& window() { return window_; }
  const wire::VersionInfo& board() const { return board_; }  // its values, not the agreed ones
  std::uint32_t max_payload() const { return std::min(mine_.max_payload_bytes, board_.max_payload_bytes); }

  std::uint64_t now = 0;  // the host's clock, ps

  // Sends a numbered frame as the window allows, with the credit that is due.
  std::uint32_t post(FrameType type, const Bytes& payload, std::uint16_t flags = wire::kPosted);
  // Sends a request and returns its one response; moves the clock. Completions are kept.
  RawFrame ask(FrameType type, const Bytes& payload);
  // ask() for a response without an error.
  Bytes request(FrameType type, const Bytes& payload);
  // The next frame but credit and progress, with the checks of every frame.
  RawFrame receive();
  void return_credit();

  std::uint32_t read_register(std::uint32_t offset);
  std::uint32_t read_config(std::uint32_t offset);
  void write_register(std::uint32_t offset, std::uint32_t value);
  void write_memory(std::uint64_t address, const Bytes& bytes);
  Bytes read_memory(std::uint64_t address, std::uint64_t length);
  std::uint64_t counter(const std::string& name);

  std::uint32_t command(const Bytes& payload) { return post(FrameType::kCommand, payload); }
  // Waits for a command and returns its completion.
  RawFrame completion(std::uint32_t ticket);
  // The completion's payload of a command that must not fail.
  Bytes run(const Bytes& payload);
  // The command must fail with that error and a text that has the word; the session lives.
  void refused(const Bytes& payload, ErrorCode error, const std::string& word);
  template <wire::Record T>
  void refused(const T& record, const std::string& word) {
    refused(wire::encoded(record), ErrorCode::kBadValue, word);
  }
  // Completions that came with answers, in their order.
  std::deque<RawFrame> completions;

  // The session must end with this error as the board's last frame, and the connection with it.
  static void ends(RawClient& client, ErrorCode error, std::optional<std::uint32_t> id = {});
  void ends(ErrorCode error, std::optional<std::uint32_t> id = {}) {
    ends(client_, error, id);
    ended_ = true;
  }
  // No goodbye: the connection is cut.
  void cut() {
    client_.close();
    ended_ = true;
  }

 private:
  Place& place_;
  wire::VersionInfo mine_, board_;
  RawClient client_;
  wire::ReliableWindow window_;
  std::uint32_t last_id_ = 100;
  std::uint64_t last_time_ = 0;
  bool ended_ = false;
};

// The handshake's answer on a new connection.
RawFrame shake_hands(Place& place, RawClient& client, const wire::VersionInfo& mine);

}  // namespace gicube::conformance
