// A client of the data plane without checks: it sends any frame, right or wrong, and returns the frames that it gets.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gicube/wire/frame.h"

namespace gicube::reference {

struct RawFrame {
  wire::FrameHeader header;
  std::vector<std::uint8_t> payload;

  std::string text() const { return {payload.begin(), payload.end()}; }
};

class RawClient {
 public:
  // Both throw std::runtime_error if they cannot connect.
  static RawClient connect_unix(const std::string& path);
  static RawClient connect_tcp(std::uint16_t port, const char* source = "127.0.0.1");  // to 127.0.0.1, from `source`
  // Takes over a connected stream socket.
  explicit RawClient(int fd);
  ~RawClient() { close(); }

  RawClient(RawClient&& other) noexcept : fd_(other.fd_), sent_(other.sent_) { other.fd_ = -1; }
  RawClient& operator=(RawClient&&) = delete;

  void close();
  void end_sending();
  int socket() const { return fd_; }

  void limit_silence(std::chrono::milliseconds most);

  // False if the peer has closed.
  bool send_bytes(std::span<const std::uint8_t> bytes);
  // `size`, `sequence` and `checksum` are set.
  bool send(wire::FrameHeader header, std::span<const std::uint8_t> payload = {});
  bool send(wire::FrameType type, std::uint32_t id, std::uint16_t flags, std::span<const std::uint8_t> payload);

  // The next frame; nothing at the end of the stream. Throws std::runtime_error after the silence that limit_silence()
  // allows, 60 s by default.
  std::optional<RawFrame> receive();
  // The next frame that is neither kCredit nor kProgress.
  std::optional<RawFrame> receive_answer();

  // Sends a version frame, with an access token if there is one, and returns the answer.
  std::optional<RawFrame> handshake(const wire::VersionInfo& mine = {}, const std::string& token = "");
  // A request and its answer.
  std::optional<RawFrame> call(wire::FrameType type, std::uint32_t id, std::span<const std::uint8_t> payload);

  // The next frame gets the number after `sequence`.
  void continue_from(std::uint32_t sequence) { sent_ = sequence; }

  void write_register(std::uint32_t offset, std::uint32_t value);
  // 2^64 - 1 if there is no valid answer.
  std::uint64_t read_register(std::uint32_t offset);

 private:
  std::size_t read_fully(std::span<std::uint8_t> bytes);

  int fd_;
  std::uint32_t sent_ = 0;  // sequence number of the last frame
};

}  // namespace gicube::reference
