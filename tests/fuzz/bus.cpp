// A client's bytes into a session of a board process: it answers in good frames or ends with a word, and the board works
// for the next client as on its first day.
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "board_moves.h"
#include "board_slot.h"
#include "bus_server.h"
#include "config.h"
#include "frames.h"

namespace gicube::fuzz {
namespace {

using wire::FrameHeader;
using wire::FrameType;

constexpr std::chrono::milliseconds kPatience{5000}, kLittlePatience{10};

// A board process in this process, for one connection.
class Server {
 public:
  explicit Server(emu::BoardSlot& slot) : server_(options()) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) throw std::runtime_error("no sockets");
    client_ = ends[0];
    ::fcntl(client_, F_SETFL, O_NONBLOCK);
    server_.adopt(slot, ends[1], true);
    thread_ = std::thread([this] { server_.run(); });
  }
  ~Server() {
    close();
    thread_.join();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  int client() const { return client_; }
  void close() {
    if (client_ >= 0) ::close(client_);
    client_ = -1;
  }

 private:
  static emu::BusOptions options() {
    emu::BusOptions options;
    options.handshake_deadline = std::chrono::milliseconds(500);
    return options;
  }

  emu::BusServer server_;
  int client_ = -1;
  std::thread thread_;
};

class Client {
 public:
  explicit Client(int fd) : fd_(fd) {}

  // Sends all of it, and reads meanwhile. False once the board has closed.
  bool send(Bytes bytes) {
    while (!bytes.empty() && open_) {
      pump(POLLIN | POLLOUT);
      const ssize_t count = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (count > 0) bytes = bytes.subspan(static_cast<std::size_t>(count));
      if (count < 0 && errno != EAGAIN) open_ = false;
    }
    return open_;
  }

  // Reads until a frame of this type has come, as a response or last word; nothing if the board closes or is silent.
  // A session that got a spoilt frame may be silent.
  std::optional<FrameReader::Frame> await(FrameType type) {
    const auto end = std::chrono::steady_clock::now() + (spoilt ? kLittlePatience : kPatience);
    for (;;) {
      FrameReader::Frame frame;
      while (reader_.take(frame)) {
        back_.credit_slots += wire::is_free(frame.header.type) ? 0 : 1;
        back_.credit_bytes += wire::is_free(frame.header.type) ? 0 : frame.payload.size();
        if (on_frame) on_frame(frame);
        if (frame.header.type == type && (frame.header.flags & wire::kResponse) != 0) return frame;
        if (frame.header.type == FrameType::kVersion && frame.header.error != wire::ErrorCode::kNone) open_ = false;
      }
      if (!open_) return std::nullopt;
      const bool is_late = std::chrono::steady_clock::now() >= end;
      expect(!is_late || spoilt, "a session answers or ends");
      if (is_late) return std::nullopt;
      if (back_.credit_slots > 0) send(good_frame(next(credit_header()), {}));  // it may be waiting for that
      pump(POLLIN);
    }
  }

  // The credit that the board is owed goes with the next frame.
  FrameHeader next(FrameHeader header) {
    if (!wire::is_free(header.type)) header.sequence = ++sent_;
    header.credit_slots = back_.credit_slots;
    header.credit_bytes = back_.credit_bytes;
    back_ = {};
    return header;
  }

  std::function<void(const FrameReader::Frame&)> on_frame;
  bool spoilt = false;

 private:
  FrameHeader credit_header() const {
    FrameHeader header;
    header.type = FrameType::kCredit;
    header.flags = wire::kPosted;
    header.id = sent_;
    return header;
  }

  void pump(short events) {
    pollfd ready{fd_, events, 0};
    ::poll(&ready, 1, spoilt ? static_cast<int>(kLittlePatience.count()) : 100);
    std::array<std::uint8_t, 65536> bytes;
    while (open_) {
      const ssize_t count = ::recv(fd_, bytes.data(), bytes.size(), 0);
      if (count > 0) reader_.add(Bytes(bytes).first(static_cast<std::size_t>(count)));
      if (count == 0 || (count < 0 && errno != EAGAIN)) open_ = false;
      if (count <= 0) return;
    }
  }

  int fd_;
  bool open_ = true;
  FrameReader reader_;
  FrameHeader back_;
  std::uint32_t sent_ = 0;
};

FrameHeader version_header() {
  FrameHeader header;
  header.type = FrameType::kVersion;
  header.id = 1;
  return header;
}

void play(int fd, Input& input) {
  Client client(fd);
  const std::vector<std::uint8_t> version = version_payload(input);
  if (!client.send(frame_bytes(version_header(), version, input, client.spoilt))) return;
  if (input.u8() != 255 && !client.await(FrameType::kVersion)) return;
  std::uint64_t now = 0;
  for (std::uint32_t id = 2; !input.empty() && id < 60; ++id) {
    Move move = next_move(input, id);
    if (move.header.time_ps == 0) move.header.time_ps = now;
    const bool posted = (move.header.flags & wire::kPosted) != 0;
    if (!client.send(frame_bytes(client.next(move.header), move.payload, input, client.spoilt))) return;
    if (posted || input.below(4) == 3) continue;
    const auto answer = client.await(move.header.type);
    if (!answer) return;
    now = std::max(now, answer->header.time_ps);
  }
  FrameHeader last;
  last.type = FrameType::kCounters;
  last.id = 1000;
  last.time_ps = now;
  if (client.send(good_frame(client.next(last), {}))) client.await(FrameType::kCounters);
}

// What a good client gets out of the board, with its times.
std::vector<std::uint8_t> known_scene(emu::BoardSlot& slot) {
  const Server server(slot);
  Client client(server.client());
  std::vector<std::uint8_t> all;
  Input nothing({});
  client.send(good_frame(version_header(), version_payload(nothing)));
  expect(client.await(FrameType::kVersion).has_value(), "a board takes the next client");
  client.on_frame = [&all](const FrameReader::Frame& frame) {
    if (frame.header.type == FrameType::kCredit || frame.header.type == FrameType::kProgress) return;
    all.insert(all.end(), frame.payload.begin(), frame.payload.end());
    for (int shift = 0; shift < 64; shift += 8) {
      all.push_back(static_cast<std::uint8_t>(frame.header.time_ps >> shift));
    }
  };
  std::uint64_t now = 0;
  for (Move move : known_moves()) {
    move.header.time_ps = now;
    expect(client.send(good_frame(client.next(move.header), move.payload)), "a good client is not sent away");
    if ((move.header.flags & wire::kPosted) != 0) continue;
    const auto answer = client.await(move.header.type);
    expect(answer.has_value(), "a good client is answered");
    now = answer->header.time_ps;
  }
  return all;
}

}  // namespace

void bus(Bytes bytes) {
  static emu::BoardSlot slot(
      0,
      emu::parse_config("threads: 1 asic { max_volume_voxels: 32 block_voxels: 8 } dsp { framebuffer_mb: 1 }").config);
  static const std::vector<std::uint8_t> first_day = known_scene(slot);
  Input input(bytes);
  {
    const Server server(slot);
    play(server.client(), input);
  }
  if (bytes.size() % 4 == 0)
    expect(known_scene(slot) == first_day, "the next client finds the board as on its first day");
}

}  // namespace gicube::fuzz
