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

// Little-endian words of 32 and of 64 bits.
Bytes words(std::initializer_list<std::uint32_t> values);
Bytes long_words(std::initializer_list<std::uint64_t> values);
wire::VersionInfo host_version();

// The next frame from the board that is neither kCredit nor kProgress. Throws Failure if the board closed the
// connection.
RawFrame next_answer(RawClient& client);
// Sends a request, and returns its answer. Nothing is checked.
RawFrame call(RawClient& client, FrameType type, std::uint32_t id, const Bytes& payload);

class Host {
 public:
  // Opens a session, waiting while another client has the board. Throws Failure if the board refuses.
  explicit Host(Place& place, const wire::VersionInfo& mine = host_version());
  // Says goodbye.
  ~Host();
  Host(Host&&) = delete;

  Place& place() { return place_; }
  RawClient& wire() { return client_; }
  wire::ReliableWindow& window() { return window_; }
  const wire::VersionInfo& board() const { return board_; }  // its values, not the agreed ones
  std::uint32_t max_payload() const { return std::min(mine_.max_payload_bytes, board_.max_payload_bytes); }

  std::uint64_t now = 0;  // the host's clock, ps

  // Sends a numbered frame with the credit that is due, once the board's window allows it. Returns its id.
  std::uint32_t post(FrameType type, const Bytes& payload, std::uint16_t flags = wire::kPosted);
  // Sends a request, returns its one response, and advances `now` to it. Completions are kept.
  RawFrame ask(FrameType type, const Bytes& payload);
  // ask() for a response without an error, and for one with this error.
  Bytes request(FrameType type, const Bytes& payload);
  RawFrame refused_request(FrameType type, const Bytes& payload, ErrorCode error);
  // The next frame that is neither credit nor progress, after the checks that hold for every frame.
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
  // The command must fail with kBadValue, a text that has the word, and STATUS.bad_command, which is cleared again.
  void refused(const Bytes& payload, const std::string& word);
  void refused(const wire::Record auto& record, const std::string& word) { refused(wire::encoded(record), word); }
  // Picoseconds until the work, and all that was posted before it, is done.
  std::uint64_t time_of(auto work) {
    read_register(reg::kId);
    const std::uint64_t before = now;
    work();
    return now - before;
  }
  // Completions that came before answers, in their order.
  std::deque<RawFrame> completions;

  // The board's last frame must have this error. The board then closes the connection.
  static void ends(RawClient& client, ErrorCode error, std::optional<std::uint32_t> id = {});
  void ends(ErrorCode error, std::optional<std::uint32_t> id = {}) {
    ends(client_, error, id);
    ended_ = true;
  }
  // Closes the connection without a goodbye.
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

// Sends the version frame on a new connection, and returns the board's answer.
RawFrame shake_hands(RawClient& client, const wire::VersionInfo& mine);

}  // namespace gicube::conformance
