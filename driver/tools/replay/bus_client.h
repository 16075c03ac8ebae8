// The plainest client of the bus: sends a frame when it has credit, reads frames as they come.
#pragma once

#include <chrono>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gicube/wire/credits.h"
#include "gicube/wire/frame.h"
#include "transport/fd.h"

namespace gicube::replay {

// The board refused the session, closed it, or does not answer.
class BusError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class BusClient {
 public:
  struct Frame {
    wire::FrameHeader header;
    std::vector<std::uint8_t> payload;
  };
  // Everything that the board says but credit and progress; on the caller's thread, within send() and answer_to().
  using OnFrame = std::function<void(const Frame&)>;

  // Takes a connected socket, shakes hands. `largest_payload`: that will be sent or received. Throws BusError.
  BusClient(Fd socket, std::uint32_t largest_payload, std::chrono::milliseconds watchdog, OnFrame on_frame);

  // Its credit and number are filled in, its id and time stay. Waits for credit. Throws BusError.
  void send(wire::FrameHeader header, const std::vector<std::uint8_t>& payload);
  // Reads up to the response with this id. Throws BusError.
  void await_answer(std::uint32_t id);

 private:
  void shake_hands(std::uint32_t largest_payload);
  Frame receive();
  void take(const Frame& frame);
  void write(const std::vector<std::uint8_t>& bytes);
  void read(std::uint8_t* bytes, std::size_t count);

  Fd socket_;
  std::chrono::milliseconds watchdog_;
  OnFrame on_frame_;
  std::uint32_t max_payload_ = 0;
  wire::SendCredits send_credits_{0, 0};
  std::uint32_t owed_slots_ = 0;  // consumed, and not handed back
  std::uint64_t owed_bytes_ = 0;
  std::uint32_t sent_ = 0;
  std::uint32_t answered_ = 0;  // the id of the last response
};

}  // namespace gicube::replay
