// QEMU's messages, a guest's memory and a board's bytes into the bridge of gicube-pci: it answers what wants an answer,
// and touches no byte outside of the memory that was shared.
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include "bridge.h"
#include "input.h"
#include "targets.h"
#include "transport/event.h"

namespace gicube::fuzz {
namespace {

namespace fn = wire::function;

constexpr std::uint64_t kFile = 64 << 10, kShared = 48 << 10,
                        kMargin = 8 << 10;     // shared: all but a margin at both ends
constexpr std::uint64_t kAddress = 0x10'0000;  // in the guest

class Guest {
 public:
  Guest() : file_(::memfd_create("guest", MFD_CLOEXEC)) {
    if (::ftruncate(file_.get(), kFile) != 0) throw std::runtime_error("no memory");
    bytes_ = static_cast<std::byte*>(::mmap(nullptr, kFile, PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0));
    if (bytes_ == MAP_FAILED) throw std::runtime_error("no memory");
    std::fill(bytes_, bytes_ + kFile, std::byte{0x5A});
  }
  ~Guest() { ::munmap(bytes_, kFile); }
  Guest(const Guest&) = delete;
  Guest& operator=(const Guest&) = delete;

  Fd file() const { return duplicate(file_); }
  std::byte* shared() { return bytes_ + kMargin; }
  bool margins_are_whole() const {
    const auto whole = [](std::byte byte) { return byte == std::byte{0x5A}; };
    return std::all_of(bytes_, bytes_ + kMargin, whole) &&
           std::all_of(bytes_ + kMargin + kShared, bytes_ + kFile, whole);
  }

 private:
  Fd file_;
  std::byte* bytes_ = nullptr;
};

void use_board(Fd& board, Input& input) {
  std::array<std::uint8_t, 4096> bytes{};
  const std::size_t count = 16 * input.u8();
  switch (input.below(4)) {
    case 0: board.reset(); return;
    case 1: {
      [[maybe_unused]] const auto got = ::recv(board.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
      return;
    }
    default: {
      [[maybe_unused]] const auto sent = ::send(board.get(), bytes.data(), count, MSG_DONTWAIT | MSG_NOSIGNAL);
    }
  }
}

// Bytes as they could come over the socket, with files.
std::optional<pci::Message> any_message(Input& input, const Guest& guest) {
  std::array<std::uint8_t, pci::kMessageHeaderBytes> header{};
  header[0] = input.u8();
  const std::uint64_t size = input.u8();
  std::memcpy(header.data() + 8, &size, sizeof size);
  std::vector<Fd> files;
  for (std::uint32_t i = input.below(10); i > 0; --i) {
    files.push_back(header[0] == 6 ? Fd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) : guest.file());
  }
  auto data = input.bytes(size);
  data.resize(size);
  return pci::decode(header, data, std::move(files));
}

pci::Message memory_map(Input& input, const Guest& guest) {
  pci::Message message{pci::MessageKind::kMemoryMap};
  const std::uint64_t less = 4096 * input.below(4);
  message.map.push_back({kAddress, kShared - less, kMargin, guest.file()});
  return message;
}

// Values that mean something to a register, or any.
std::uint64_t value_of(Input& input) {
  const std::array<std::uint64_t, 10> values{
      0, 1, 4096, 8192, 16384, kAddress, kAddress + 4096, kAddress + kShared - 4096, 0xFFFFFFFF, 6};
  const std::uint8_t kind = input.u8();
  return kind < values.size() ? values[kind] : input.u64();
}

pci::Message access(pci::MessageKind kind, Input& input) {
  pci::Message message{kind};
  const bool is_bar = kind == pci::MessageKind::kBarRead || kind == pci::MessageKind::kBarWrite;
  const std::uint8_t how = input.u8();
  message.address = how < 128 ? how & 0x3Cu : how < 192 ? how : input.u64();
  if (is_bar) message.address += 0xFEBF'0000;
  message.size = how % 8 != 7 ? 4 : input.u8();
  message.value = value_of(input);
  return message;
}

}  // namespace

void pci(Bytes bytes) {
  Input input(bytes);
  Guest guest;
  Fd board;  // its end of the last session
  pci::Bridge bridge([&board] {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) throw std::runtime_error("no sockets");
    board = Fd(ends[1]);
    return pci::Connection{Fd(ends[0]), {}};
  });
  bridge.take(memory_map(input, guest));
  while (!input.empty()) {
    std::optional<pci::Message> message;
    switch (input.below(10)) {
      case 0: message = any_message(input, guest); break;
      case 1: message = access(pci::MessageKind::kBarRead, input); break;
      case 2:
      case 3: message = access(pci::MessageKind::kBarWrite, input); break;
      case 4: message = access(pci::MessageKind::kConfigRead, input); break;
      case 5: message = access(pci::MessageKind::kConfigWrite, input); break;
      case 6: message = pci::Message{pci::MessageKind::kReset}; break;
      case 7: message = memory_map(input, guest); break;
      case 8: {
        const std::uint32_t page = input.below(2), which = input.below(6),
                            value = input.below(2) == 0 ? input.u32() : input.u16();
        fn::index_at(guest.shared() + std::size_t{4096} * page, 64 * which).store(value);
        break;
      }
      default: use_board(board, input); break;
    }
    if (message) {
      const auto kind = message->kind;
      const bool wants_answer = kind != pci::MessageKind::kMemoryMap && kind != pci::MessageKind::kInterruptFiles;
      expect(bridge.take(std::move(*message)).has_value() == wants_answer,
             "QEMU gets an answer where it waits for one");
    }
    expect(!bridge.wait(-1, 0), "without QEMU there is no message");
    expect(guest.margins_are_whole(), "nothing is written outside of the shared memory");
  }
}

}  // namespace gicube::fuzz
