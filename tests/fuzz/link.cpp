// A board's bytes into the driver's link: calls return or throw one of the driver's errors, and nothing hangs.
#include "transport/link.h"

#include <sys/socket.h>

#include <array>
#include <thread>

#include "frames.h"
#include "gicube/error.h"
#include "gicube/wire/checksum.h"

namespace gicube::fuzz {
namespace {

using wire::FrameHeader;
using wire::FrameType;

// Answers each frame of the driver as the input says, and closes at its end.
class HostileBoard {
 public:
  HostileBoard(Fd socket, Input& input) : socket_(std::move(socket)), input_(input) {}

  void run() {
    FrameHeader request;
    while (receive(request)) {
      if (request.type == FrameType::kCredit) continue;
      if (input_.empty() && request.type != FrameType::kVersion) break;
      const std::size_t count = request.type == FrameType::kVersion ? 1 : 1 + input_.below(3);
      for (std::size_t i = 0; i < count; ++i) send(answer(request, i));
    }
    socket_.reset();
  }

 private:
  bool receive(FrameHeader& header) {
    std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
    if (!read(bytes)) return false;
    const auto decoded = wire::decode_frame_header(bytes);
    expect(decoded.has_value(), "the driver sends frames");
    header = *decoded;
    std::vector<std::uint8_t> payload(header.size);
    if (!read(payload)) return false;
    expect(wire::frame_checksum(bytes, payload) == header.checksum, "with their checksums");
    if (header.type == FrameType::kCommand) ticket_ = header.id;
    return true;
  }

  bool read(std::span<std::uint8_t> bytes) const {
    return bytes.empty() ||
           ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_WAITALL) == static_cast<ssize_t>(bytes.size());
  }

  void send(const std::vector<std::uint8_t>& bytes) const {
    if (!bytes.empty()) ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }

  std::vector<std::uint8_t> answer(const FrameHeader& request, std::size_t i) {
    FrameHeader header{request.type, wire::kResponse, request.id};
    if (request.type == FrameType::kVersion) return frame_bytes(header, version_payload(input_), input_, spoilt_);
    header.time_ps = request.time_ps + input_.u16();
    if (i == 0) header.credit_slots = 1, header.credit_bytes = request.size;
    std::vector<std::uint8_t> payload = input_.bytes(input_.below(32));
    switch (input_.u8() % 8) {
      case 0: header.type = FrameType::kCompletion, header.flags = wire::kPosted, header.id = ticket_; break;
      case 1:
        header.type = FrameType::kProgress, header.flags = wire::kPosted, header.id = ticket_, payload.resize(8);
        break;
      case 2: header.type = FrameType::kCredit, header.flags = wire::kPosted, payload.clear(); break;
      case 3: header.type = static_cast<FrameType>(1 + input_.below(16)); break;
      default: break;
    }
    if (!wire::is_free(header.type)) header.sequence = ++sent_;
    return frame_bytes(header, payload, input_, spoilt_);
  }

  Fd socket_;
  Input& input_;
  bool spoilt_ = false;
  std::uint32_t ticket_ = 1, sent_ = 0;
};

// What a driver asks for.
void use(Link& link) {
  std::uint64_t now = 0;
  std::uint32_t ticket = 0;
  for (int i = 0; i < 30; ++i) {
    link.check();
    switch (i % 5) {
      case 0: link.post(FrameType::kRegisterWrite, now, std::vector<std::uint8_t>(8)); break;
      case 1: now = link.request(FrameType::kRegisterRead, now, std::vector<std::uint8_t>(4)).time_ps; break;
      case 2: ticket = link.command(now, wire::share(std::vector<std::uint8_t>(16))); break;
      case 3: link.request(FrameType::kWait, now, {static_cast<std::uint8_t>(ticket), 0, 0, 0}); break;
      default:
        if (!link.take(ticket)) link.forget(ticket);
        break;
    }
  }
}

}  // namespace

void link(Bytes bytes) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) throw std::runtime_error("no sockets");
  Input input(bytes);
  HostileBoard hostile(Fd(ends[1]), input);
  std::thread board([&hostile] { hostile.run(); });
  try {
    LinkOptions options;
    options.watchdog = std::chrono::milliseconds(100);
    Link link{Fd(ends[0]), options};
    // A refusal by the board leaves the link as it was.
    for (int i = 0; i < 4; ++i) {
      try {
        use(link);
      } catch (const Rejected&) {
      } catch (const Unsupported&) {
      }
    }
  } catch (const Error&) {
  }
  board.join();
}

}  // namespace gicube::fuzz
