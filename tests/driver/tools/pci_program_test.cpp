// gicube-pci with this process in QEMU's place, byte by byte: its messages with their files, and KVM's side of the two
// eventfds that carry INTx. A guest under TCG never gets one, and KVM is not everywhere. Records after QEMU 7.2,
// include/hw/remote/mpqemu-link.h and include/hw/remote/proxy.h, written down here once more.
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <initializer_list>
#include <type_traits>

#include "board_process.h"
#include "gicube/wire/pci_function.h"
#include "temporary_directory.h"
#include "test.h"
#include "transport/fd.h"
#include "transport/ring.h"

namespace gicube::system_test {
namespace {

namespace fn = wire::function;

constexpr int kPatience = 10'000;  // ms, far beyond what anything takes
constexpr std::uint64_t kBar = 0xFEBF'0000, kMemory = 0x10'0000, kMemoryBytes = 1 << 20;

struct Map {  // SyncSysmemMsg
  std::uint64_t addresses[8], sizes[8], offsets[8];
};
struct Config {  // PciConfDataMsg
  std::uint32_t address, value, length;
};
struct Bar {  // BarAccessMsg
  std::uint64_t address, value;
  std::uint32_t size;
  bool is_memory;
};
struct Nothing {};
static_assert(sizeof(Map) == 192 && sizeof(Config) == 12 && sizeof(Bar) == 24);

bool is_readable(const Fd& file, int milliseconds) {
  pollfd waits{file.get(), POLLIN, 0};
  return ::poll(&waits, 1, milliseconds) == 1;
}
std::uint64_t taken_from(const Fd& event) {
  std::uint64_t count = 0;
  return ::read(event.get(), &count, sizeof count) == sizeof count ? count : 0;
}

class PciProgram : public testing::Test {
 protected:
  PciProgram() {
    sockaddr_un address{AF_UNIX, {}};
    folder_.file("board").copy(address.sun_path, sizeof address.sun_path - 1);
    if (::bind(boards_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(boards_.get(), 1) != 0 || ::ftruncate(guest_.get(), kMemoryBytes) != 0)
      throw std::runtime_error("no board or no memory");
    memory_ = map_shared(kMemoryBytes, guest_.get());
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) throw std::runtime_error("no sockets");
    socket_ = Fd(ends[0]);
    const Fd theirs(ends[1]);
    bridge_ = std::make_unique<BoardProcess>(
        std::vector<std::string>{"--fd", std::to_string(theirs.get()), "unix:" + folder_.file("board")}, theirs.get(),
        GICUBE_BIN_DIR "/gicube-pci");
  }

  // mpqemu_msg_send(): a header of 16 bytes with the files, then the data.
  template <typename Data = Nothing>
  void send(std::uint32_t command, const Data& data = {}, std::initializer_list<int> files = {}) {
    constexpr std::uint64_t kBytes = std::is_empty_v<Data> ? 0 : sizeof data;
    std::array<char, 16> header{};
    std::memcpy(header.data(), &command, sizeof command);
    std::memcpy(header.data() + 8, &kBytes, sizeof kBytes);
    alignas(cmsghdr) std::array<char, CMSG_SPACE(8 * sizeof(int))> control{};
    iovec part{header.data(), header.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    if (files.size() > 0) {
      message.msg_control = control.data();
      message.msg_controllen = CMSG_SPACE(files.size() * sizeof(int));
      cmsghdr* const rights = CMSG_FIRSTHDR(&message);
      *rights = {CMSG_LEN(files.size() * sizeof(int)), SOL_SOCKET, SCM_RIGHTS};
      std::memcpy(CMSG_DATA(rights), files.begin(), files.size() * sizeof(int));
    }
    ASSERT_EQ(::sendmsg(socket_.get(), &message, MSG_NOSIGNAL), 16);
    if (kBytes == 0) return;
    ASSERT_EQ(::send(socket_.get(), &data, kBytes, MSG_NOSIGNAL), static_cast<ssize_t>(kBytes));
  }
  // mpqemu_msg_send_and_await_reply()
  template <typename Data>
  std::uint64_t ask(std::uint32_t command, const Data& data) {
    send(command, data);
    std::array<std::uint64_t, 3> answer{};
    EXPECT_EQ(::recv(socket_.get(), answer.data(), sizeof answer, MSG_WAITALL), static_cast<ssize_t>(sizeof answer));
    EXPECT_EQ(answer[0] & 0xFFFF'FFFF, 1u);
    EXPECT_EQ(answer[1], 8u);
    return answer[2];
  }
  std::uint64_t read(std::uint32_t offset) { return ask(5, Bar{kBar + offset, 0, 4, true}); }
  void write(std::uint32_t offset, std::uint64_t value) { ask(4, Bar{kBar + offset, value, 4, true}); }

  // A driver's session whose board is this process.
  void open() {
    send(0, Map{{kMemory}, {kMemoryBytes}, {0}}, {guest_.get()});
    send(6, Nothing{}, {raised_.get(), acknowledged_.get()});
    ask(2, Config{4, 6, 2});
    write(fn::kRingLow, kMemory);
    write(fn::kRingBytes, fn::kMinRingBytes);
    write(fn::kInterruptMask, fn::kMoved | fn::kEnded);
    write(fn::kControl, fn::kOpenSession);
    ASSERT_TRUE(is_readable(boards_, kPatience));
    board_ = Fd(::accept(boards_.get(), nullptr, nullptr));
    ASSERT_EQ(read(fn::kState), static_cast<std::uint32_t>(fn::State::kOpen));
  }
  std::uint32_t index(std::uint32_t of) { return fn::index_at(memory_.get(), of).load(); }
  // KVM at the end of a guest's interrupt routine; the bridge has seen it when it has answered what came behind it.
  void acknowledge() {
    const std::uint64_t one = 1;
    ASSERT_EQ(::write(acknowledged_.get(), &one, sizeof one), 8);
    for (int i = 0; i < 2; ++i) read(fn::kIdentity);
  }

  reference::TemporaryDirectory folder_;
  Fd boards_{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)}, board_, socket_;
  Fd guest_{::memfd_create("guest", MFD_CLOEXEC)};
  Fd raised_{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)}, acknowledged_{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
  Mapping memory_;
  std::unique_ptr<BoardProcess> bridge_;
};

TEST_F(PciProgram, RaisesTwoHundredInterruptsThatAreEachReceived) {
  open();
  for (std::uint32_t i = 1; i <= 200; ++i) {
    ASSERT_EQ(::send(board_.get(), "x", 1, 0), 1);
    ASSERT_TRUE(is_readable(raised_, kPatience)) << i;
    EXPECT_EQ(taken_from(raised_), 1u);
    EXPECT_EQ(read(fn::kInterruptStatus), fn::kMoved);
    EXPECT_EQ(index(fn::kUpPut), i);  // bytes are there before the interrupt
    EXPECT_NE(ask(3, Config{4, 0, 4}) & 1u << 19, 0u);
    write(fn::kInterruptStatus, fn::kMoved);
    fn::index_at(memory_.get(), fn::kUpTaken).store(i);
    acknowledge();
    EXPECT_EQ(taken_from(raised_), 0u);
  }
}

TEST_F(PciProgram, RaisesTheLevelAgainIfItIsNotCleared) {
  open();
  ASSERT_EQ(::send(board_.get(), "x", 1, 0), 1);
  ASSERT_TRUE(is_readable(raised_, kPatience));
  EXPECT_EQ(taken_from(raised_), 1u);
  acknowledge();
  EXPECT_EQ(taken_from(raised_), 1u);
  ask(2, Config{5, 4, 1});  // as uio_pci_generic does in its routine: INTx disable
  acknowledge();
  EXPECT_EQ(taken_from(raised_), 0u);
  ask(2, Config{5, 0, 1});
  EXPECT_EQ(taken_from(raised_), 1u);
  write(fn::kInterruptStatus, fn::kMoved);
  board_.reset();
  acknowledge();
  ASSERT_TRUE(is_readable(raised_, kPatience));
  EXPECT_EQ(read(fn::kInterruptStatus), fn::kEnded);
}

TEST_F(PciProgram, PassesADoorbellsBytesToTheBoardBeforeItAnswers) {
  open();
  std::memcpy(memory_.get() + fn::kIndexBytes, "doorbell", 8);
  fn::index_at(memory_.get(), fn::kDownPut).store(8);
  write(fn::kBell, 1);
  EXPECT_EQ(index(fn::kDownTaken), 8u);
  std::array<char, 16> came{};
  EXPECT_EQ(::recv(board_.get(), came.data(), came.size(), MSG_DONTWAIT), 8);
  EXPECT_STREQ(came.data(), "doorbell");
}

TEST_F(PciProgram, ReportsABoardThatCannotBeConnected) {
  boards_.reset();
  send(0, Map{{kMemory}, {kMemoryBytes}, {0}}, {guest_.get()});
  ask(2, Config{4, 6, 2});
  write(fn::kRingLow, kMemory);
  write(fn::kRingBytes, fn::kMinRingBytes);
  write(fn::kControl, fn::kOpenSession);
  EXPECT_EQ(read(fn::kState), static_cast<std::uint32_t>(fn::State::kFailed));
  EXPECT_EQ(read(fn::kError), static_cast<std::uint32_t>(fn::Error::kNoBoard));
  EXPECT_EQ(index(fn::kStreamEnded), 1u);
}

TEST_F(PciProgram, EndsWithQemu) {
  open();
  socket_.reset();
  EXPECT_EQ(bridge_->exit_code(), 0);
}

TEST_F(PciProgram, NamesAMessageOfAnotherQemu) {
  send(17);
  EXPECT_EQ(bridge_->exit_code(), 1);
  EXPECT_THAT(bridge_->read_errors(), HasSubstr("got command 17 with 0 bytes; it was written for QEMU 7.2"));
}

}  // namespace
}  // namespace gicube::system_test
