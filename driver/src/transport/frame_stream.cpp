#include "frame_stream.h"

#include <sys/socket.h>

#include <chrono>
#include <exception>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include "gicube/wire/checksum.h"
#include "tls_stream.h"

namespace gicube {
namespace {

// chosen: a peer that refuses us sends the reason and closes: it is read even if our own write fails first.
constexpr std::chrono::seconds kLastWords{1};

// A board closes its socket without a TLS shutdown: each frame says where it ends.
bool is_end(const boost::system::error_code& error) {
  return error == boost::asio::error::eof || error == boost::asio::ssl::error::stream_truncated;
}

constexpr const char* kMiddle = "the connection ended in the middle of a frame";

}  // namespace

struct FrameStream::Secured {
  TlsStream stream;
};

FrameStream::FrameStream(Fd socket, FrameSink& sink, FrameTap tap, std::shared_ptr<Tls> tls)
    : sink_(sink), tap_(std::move(tap)), tls_(std::move(tls)) {
  // The family matters only for sockets that are opened or bound: this one is connected.
  socket_.assign(boost::asio::generic::stream_protocol(AF_UNIX, 0), socket.get());
  socket.release();
  if (!tls_) return;
  secured_.reset(new Secured{TlsStream(socket_, tls_->context)});
  ::SSL_set_tlsext_host_name(secured_->stream.native_handle(), tls_->host.c_str());
  writing_ = true;  // the handshake comes first
}

FrameStream::~FrameStream() {
  close({"closed", Loss::kClosed});
  if (thread_.joinable()) thread_.join();
}

void FrameStream::run() {
  for (;;) {
    try {
      io_.run();
      return;
    } catch (const std::exception& error) {  // no memory for a payload
      end({error.what(), Loss::kEnded});
    }
  }
}

void FrameStream::send(wire::FrameHeader header, wire::Payload payload, std::size_t secret_bytes) {
  header.size = static_cast<std::uint32_t>(payload->size());
  Outgoing frame;
  wire::encode_sealed(header, *payload, frame.header);
  const bool goes_on =
      secret_bytes > 0 ? tapped_without(secret_bytes, header, payload) : tapped(true, frame.header, *payload);
  if (!goes_on) return;
  frame.payload = std::move(payload);
  {
    const std::lock_guard lock(mutex_);
    queued_.push_back(std::move(frame));
    if (writing_) return;
    writing_ = true;
  }
  boost::asio::post(io_, [this] { write_queued(); });
}

bool FrameStream::tapped_without(std::size_t secret_bytes, const wire::FrameHeader& header,
                                 const wire::Payload& payload) {
  const auto shown = std::span(*payload).first(payload->size() - secret_bytes);
  wire::FrameHeader shorter = header;
  shorter.size = static_cast<std::uint32_t>(shown.size());
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  wire::encode_sealed(shorter, shown, bytes);
  return tapped(true, bytes, shown);
}

bool FrameStream::tapped(bool sent, std::span<const std::uint8_t, wire::kFrameHeaderBytes> header,
                         std::span<const std::uint8_t> payload) {
  try {
    if (tap_) tap_(sent, header, payload);
    return true;
  } catch (const std::exception& error) {
    close({error.what(), Loss::kEnded});
    return false;
  }
}

void FrameStream::begin() {
  if (!secured_) return read_header();
  secured_->stream.async_handshake(boost::asio::ssl::stream_base::client,
                                   [this](const boost::system::error_code& error) {
                                     if (error) return end({"no connection by TLS: " + error.message(), Loss::kClosed});
                                     write_queued();
                                     read_header();
                                   });
}

void FrameStream::read_bytes(boost::asio::mutable_buffer bytes, const auto& handler) {
  if (secured_) {
    boost::asio::async_read(secured_->stream, bytes, handler);
  } else {
    boost::asio::async_read(socket_, bytes, handler);
  }
}

void FrameStream::read_header() {
  read_bytes(boost::asio::buffer(header_bytes_), [this](const boost::system::error_code& error, std::size_t bytes) {
    if (is_end(error)) {
      return end({bytes == 0 ? "the board closed the connection" : kMiddle, Loss::kClosed});
    }
    if (error) return end({error.message(), Loss::kClosed});
    const auto header = wire::decode_frame_header(header_bytes_);
    if (!header) return end({"the board sent something that is not a frame", Loss::kCorrupted});
    const StreamFault fault = sink_.check_header(*header);
    if (!fault.text.empty()) return end(fault);
    read_payload(*header);
  });
}

void FrameStream::read_payload(const wire::FrameHeader& header) {
  payload_.resize(header.size);
  if (header.size == 0) return take_payload(header);
  read_bytes(boost::asio::buffer(payload_), [this, header](const boost::system::error_code& error, std::size_t) {
    if (is_end(error)) return end({kMiddle, Loss::kClosed});
    if (error) return end({error.message(), Loss::kClosed});
    take_payload(header);
  });
}

void FrameStream::take_payload(const wire::FrameHeader& header) {
  if (wire::frame_checksum(header_bytes_, payload_) != header.checksum) {
    return end({"a frame of the board has a wrong checksum", Loss::kCorrupted});
  }
  if (!tapped(false, header_bytes_, payload_)) return;
  const StreamFault fault = sink_.take_frame(header, std::exchange(payload_, {}));
  if (!fault.text.empty()) return end(fault);
  read_header();
}

void FrameStream::write_queued() {
  {
    const std::lock_guard lock(mutex_);
    if (ended_ || queued_.empty()) {
      writing_ = false;
      return;
    }
    in_flight_.swap(queued_);
  }
  std::vector<boost::asio::const_buffer> buffers;
  for (const Outgoing& frame : in_flight_) {
    buffers.push_back(boost::asio::buffer(frame.header));
    if (!frame.payload->empty()) buffers.push_back(boost::asio::buffer(*frame.payload));
  }
  const auto written = [this](const boost::system::error_code& error, std::size_t) {
    in_flight_.clear();
    if (!error) return write_queued();
    if (ended_) return;
    last_words_.expires_after(kLastWords);
    last_words_.async_wait([this, text = error.message()](const boost::system::error_code& cancelled) {
      if (!cancelled) end({text, Loss::kClosed});
    });
  };
  if (secured_) {
    boost::asio::async_write(secured_->stream, buffers, written);
  } else {
    boost::asio::async_write(socket_, buffers, written);
  }
}

void FrameStream::end(const StreamFault& reason) {
  if (ended_) return;
  ended_ = true;
  last_words_.cancel();
  boost::system::error_code ignored;
  socket_.shutdown(boost::asio::socket_base::shutdown_both, ignored);
  socket_.close(ignored);
  sink_.stream_ended(reason);
}

}  // namespace gicube
