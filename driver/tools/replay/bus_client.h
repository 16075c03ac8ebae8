// The plainest client of the bus: sends frames in a captured order, with the numbers that they had.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gicube/wire/frame.h"
#include "gicube/wire/reliable_window.h"
#include "transport/fd.h"
#include "transport/frame_stream.h"

namespace gicube::replay {

// The board refused the session, closed it, or does not answer.
struct BusError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class BusClient : private FrameSink {
 public:
  struct Frame {
    wire::FrameHeader header;
    std::vector<std::uint8_t> payload;
  };
  // Everything that the board says but credit and progress; on the caller's thread, within send() and await_answer().
  using OnFrame = std::function<void(const Frame&)>;

  // Takes a connected socket, shakes hands. `largest_payload`: that will be sent or received. Throws BusError.
  BusClient(Fd socket, std::uint32_t largest_payload, std::chrono::milliseconds watchdog, OnFrame on_frame);

  // Its credit and number are filled in, its id and time stay. Waits for credit. Throws BusError.
  void send(const wire::FrameHeader& header, const std::vector<std::uint8_t>& payload);
  // Reads up to the response with this id. Throws BusError.
  void await_answer(std::uint32_t id);

 private:
  StreamFault check_header(const wire::FrameHeader& header) override;
  StreamFault take_frame(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) override;
  void stream_ended(const StreamFault& reason) override;

  void shake_hands();
  Frame receive();
  void take(const Frame& frame);

  const std::chrono::milliseconds watchdog_;
  const OnFrame on_frame_;
  const wire::VersionInfo mine_;
  wire::ReliableWindow window_;
  std::uint32_t max_payload_ = 0;
  std::uint32_t answered_ = 0;  // the id of the last response

  std::mutex mutex_;  // guards what the stream's thread brings
  std::condition_variable changed_;
  std::deque<Frame> arrived_;
  std::optional<std::string> ended_;

  FrameStream stream_;  // last: its thread ends before what it reports to
};

}  // namespace gicube::replay
