// Whole frames over one stream socket, on a thread of its own: it reads while it writes, so a peer that is slow to read
// never keeps frames from coming in.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>

#include "fd.h"
#include "gicube/wire/frame.h"

namespace gicube {

// What a FrameStream reports, on its thread. The first two answer with the fault that ends the stream, or with nothing.
class FrameSink {
 public:
  // A header has come; its payload is neither read nor given memory yet.
  virtual std::string check_header(const wire::FrameHeader& header) = 0;
  virtual std::string take_frame(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) = 0;
  // The last report: the stream has ended, by itself, by a fault or by close().
  virtual void stream_ended(const std::string& reason) = 0;

 protected:
  ~FrameSink() = default;
};

class FrameStream {
 public:
  FrameStream(Fd socket, FrameSink& sink);
  // Closes the socket; reports nothing more once it returns.
  ~FrameStream();

  FrameStream(const FrameStream&) = delete;
  FrameStream& operator=(const FrameStream&) = delete;

  // Reports begin. Once.
  void start();

  // Queues a frame; `header.size` is set from the payload. Any thread, never blocks. What is queued is bounded by the
  // caller's credits.
  void send(wire::FrameHeader header, std::vector<std::uint8_t> payload);

  // Any thread.
  void close(const std::string& reason);

 private:
  struct Outgoing {
    std::array<std::uint8_t, wire::kFrameHeaderBytes> header;
    std::vector<std::uint8_t> payload;
  };

  void run();
  void read_header();
  void read_payload(const wire::FrameHeader& header);
  void write_queued();
  void end(const std::string& reason);

  FrameSink& sink_;
  boost::asio::io_context io_{1};
  boost::asio::generic::stream_protocol::socket socket_{io_};
  boost::asio::steady_timer last_words_{io_};
  bool ended_ = false;

  std::array<std::uint8_t, wire::kFrameHeaderBytes> header_bytes_{};
  std::vector<std::uint8_t> payload_;

  std::mutex mutex_;  // guards queued_ and writing_
  std::deque<Outgoing> queued_;
  bool writing_ = false;
  std::deque<Outgoing> in_flight_;

  std::thread thread_;
};

}  // namespace gicube
