// Whole, undamaged frames over one stream socket, on a thread of its own, which reads while it writes.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "fd.h"
#include "gicube/error.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/reliable_window.h"
#include "tls.h"

namespace gicube {

// Why a stream has to end. No text: it does not.
struct StreamFault {
  std::string text;
  Loss cause = Loss::kEnded;
};

// Receives the reports of a FrameStream, on its thread. The first two return the fault that ends the stream, or
// nothing.
class FrameSink {
 public:
  // A header was received; its payload has not been read, has no memory yet, and may be damaged.
  virtual StreamFault check_header(const wire::FrameHeader& header) = 0;
  virtual StreamFault take_frame(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) = 0;
  // The last report: the stream has ended, because of the peer, a fault or close().
  virtual void stream_ended(const StreamFault& reason) = 0;

 protected:
  ~FrameSink() = default;
};

// Is called with every frame as it is on the wire: `sent` by us, or received undamaged. On any thread; must not block.
// An exception from it ends the stream.
using FrameTap = std::function<void(bool sent, std::span<const std::uint8_t, wire::kFrameHeaderBytes> header,
                                    std::span<const std::uint8_t> payload)>;

// A tap that writes every frame to a file (docs/guide/capture.md). For session `number` of a board, from 0: to `file`,
// session i > 0 to FILE.i. If `file` is empty, to what the environment variable GICUBE_CAPTURE names: the first session
// of this process to that file, the next ones to FILE.1, FILE.2; without it, to none: an empty tap. The file is whole,
// and has its name, when the last copy of the tap is gone (proto/gicube/whole_file.h). On a full disk the tap throws,
// and no file is left. Throws OpenFailed that names the file.
FrameTap capture_session(const std::string& file, unsigned number);

class FrameStream {
 public:
  // `tls`: null for plain bytes.
  FrameStream(Fd socket, FrameSink& sink, FrameTap tap = {}, std::shared_ptr<Tls> tls = {});
  // Closes the socket; reports nothing more once it returns.
  ~FrameStream();

  FrameStream(const FrameStream&) = delete;
  FrameStream& operator=(const FrameStream&) = delete;

  // Starts the reports. Call it once.
  void start() {
    boost::asio::post(io_, [this] { begin(); });
    thread_ = std::thread([this] { run(); });
  }

  // Queues a frame; `size` and `checksum` are set. Any thread, never blocks: the caller's credits bound what is queued.
  // The tap does not see the last `secret_bytes` of the payload.
  void send(wire::FrameHeader header, wire::Payload payload, std::size_t secret_bytes = 0);

  // Any thread.
  void close(const StreamFault& reason) {
    boost::asio::post(io_, [this, reason] { end(reason); });
  }

 private:
  struct Outgoing {
    std::array<std::uint8_t, wire::kFrameHeaderBytes> header;
    wire::Payload payload;
  };

  struct Secured;

  void run();
  void begin();
  void read_bytes(boost::asio::mutable_buffer bytes, const auto& handler);
  // False: the tap has failed, and the stream ends.
  bool tapped_without(std::size_t secret_bytes, const wire::FrameHeader& header, const wire::Payload& payload);
  bool tapped(bool sent, std::span<const std::uint8_t, wire::kFrameHeaderBytes> header,
              std::span<const std::uint8_t> payload);
  void read_header();
  void read_payload(const wire::FrameHeader& header);
  void take_payload(const wire::FrameHeader& header);
  void write_queued();
  void end(const StreamFault& reason);

  FrameSink& sink_;
  const FrameTap tap_;
  boost::asio::io_context io_{1};
  boost::asio::generic::stream_protocol::socket socket_{io_};
  const std::shared_ptr<Tls> tls_;
  std::unique_ptr<Secured> secured_;  // null: plain
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
