// A client's bytes into a session of a board process: it answers in good frames or ends with a word, and the board
// works for the next client as on its first day.
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "board_moves.h"
#include "config/config.h"
#include "frames.h"
#include "server/bus/board_slot.h"
#include "server/bus/bus_server.h"
#include "temporary_directory.h"
#include "transport/fd.h"

namespace gicube::fuzz {
namespace {

using wire::FrameHeader;
using wire::FrameType;

// Wall time, of a machine that may be busy: only for what hangs. libFuzzer's own limit for an input is shorter.
constexpr std::chrono::milliseconds kPatience{60'000};
constexpr std::chrono::milliseconds kLittlePatience{10};

// A board process in this process, on a Unix socket.
class Server {
 public:
  Server() : slot_(0, emu::parse_config(kConfig).config), server_(options()) {
    path_ = folder_.file("bus");
    server_.listen(slot_, emu::parse_endpoint("unix:" + path_));
    thread_ = std::thread([this] { server_.run(); });
  }
  ~Server() {
    server_.stop();
    thread_.join();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // A new connection.
  Fd connect() const {
    Fd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    const int failed = ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
    expect(failed == 0, "a board takes connections");
    ::fcntl(socket.get(), F_SETFL, O_NONBLOCK);
    return socket;
  }

 private:
  static constexpr const char* kConfig =
      "threads: 1 asic { max_volume_voxels: 32 block_voxels: 8 } dsp { framebuffer_mb: 1 }";

  static emu::BusOptions options() {
    emu::BusOptions options;
    options.handshake_deadline = kPatience;
    return options;
  }

  reference::TemporaryDirectory folder_;
  std::string path_;
  emu::BoardSlot slot_;
  emu::BusServer server_;
  std::thread thread_;
};

class Client {
 public:
  explicit Client(const Server& server) : server_(server), socket_(server.connect()) {}

  // A new connection in place of the old one; what the board has not taken by then is lost.
  void reconnect() {
    socket_ = server_.connect();
    open_ = true;
    reader_.lose_rest();
    back_ = {};
  }
  std::uint32_t taken() const { return reader_.taken(); }
  // What the board may send again is no longer known.
  void expect_any_number() { reader_.expect_any_number(); }
  void go_on_after(std::uint32_t sequence) { sent_ = sequence; }
  void begin_anew() {
    sent_ = 0;
    reader_ = {};
  }

  // Sends all of it, and reads meanwhile. False once the board has closed.
  bool send(Bytes bytes) {
    while (!bytes.empty() && open_) {
      pump(POLLIN | POLLOUT);
      const ssize_t count = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
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
    pollfd ready{socket_.get(), events, 0};
    ::poll(&ready, 1, spoilt ? static_cast<int>(kLittlePatience.count()) : 100);
    std::array<std::uint8_t, 65536> bytes;
    while (open_) {
      const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
      if (count > 0) reader_.add(Bytes(bytes).first(static_cast<std::size_t>(count)));
      if (count == 0 || (count < 0 && errno != EAGAIN)) open_ = false;
      if (count <= 0) return;
    }
  }

  const Server& server_;
  Fd socket_;
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

// Shakes hands, to open a session or to go on with one; waits as long for the board. False if there is none then.
bool shake_hands(Client& client, Input& input, std::uint64_t& session, std::chrono::milliseconds waits = {}) {
  wire::VersionInfo version = version_of(input);
  version.wait_ms = static_cast<std::uint32_t>(waits.count());
  const std::uint64_t asked = version.session ^ session;
  if (session != 0) {
    if (version.taken != 0 || version.consumed != 0) client.expect_any_number();
    version.taken += client.taken();
    version.consumed += client.taken();
    version.session = asked;
  }
  std::vector<std::uint8_t> payload(wire::kVersionBytes);
  wire::encode(version, payload);
  if (!client.send(frame_bytes(version_header(), payload, input, client.spoilt))) return false;
  if (input.u8() == 255) return true;  // does not wait
  const auto answer = client.await(FrameType::kVersion);
  if (!answer || answer->header.error != wire::ErrorCode::kNone) return false;
  expect(answer->payload.size() >= wire::kVersionBytes, "a version has all of its fields");
  const auto theirs = wire::decode<wire::VersionInfo>(answer->payload);
  const bool resumed = asked != 0 && theirs.session == asked;
  if (!resumed) client.begin_anew();
  if (resumed) client.go_on_after(theirs.taken);
  session = theirs.session;
  return true;
}

void play(const Server& server, Input& input) {
  Client client(server);
  std::uint64_t session = 0, now = 0;
  if (!shake_hands(client, input, session)) return;
  for (std::uint32_t id = 2; !input.empty() && id < 60; ++id) {
    Move move = next_move(input, id);
    if (move.header.time_ps == 0) move.header.time_ps = now;
    const bool posted = (move.header.flags & wire::kPosted) != 0;
    const bool sent = client.send(frame_bytes(client.next(move.header), move.payload, input, client.spoilt));
    const std::uint8_t then = input.u8();
    if (then >= 240 || !sent) {  // the connection breaks
      client.reconnect();
      if (!shake_hands(client, input, session)) return;
      continue;
    }
    if (posted || then % 4 == 3) continue;
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
std::vector<std::uint8_t> known_scene(const Server& server) {
  Client client(server);
  std::vector<std::uint8_t> all;
  Input nothing({});
  std::uint64_t session = 0;
  // Clients that have just left may still stand in line, or have the board.
  expect(shake_hands(client, nothing, session, kPatience / 2), "a board takes the next client");
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
  static const Server server;
  static const std::vector<std::uint8_t> first_day = known_scene(server);
  Input input(bytes);
  play(server, input);
  if (bytes.size() % 4 == 0) {
    expect(known_scene(server) == first_day, "the next client finds the board as on its first day");
  }
}

}  // namespace gicube::fuzz
