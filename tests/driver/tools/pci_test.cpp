// The bridge of gicube-pci as QEMU and a guest see it, without either; and what the driver asks of sysfs.
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <future>

#include "bridge.h"
#include "temporary_directory.h"
#include "test.h"
#include "transport/event.h"
#include "transport/pci_devices.h"

namespace gicube::pci {
namespace {

namespace fn = wire::function;

constexpr std::uint64_t kBar = 0xFEBF'0000, kMemory = 0x10'0000, kMemoryBytes = 1 << 20;
constexpr std::uint32_t kRing = fn::kMinRingBytes;

class PciBridge : public testing::Test {
 protected:
  PciBridge() {
    if (::ftruncate(file_.get(), kMemoryBytes) != 0) throw std::runtime_error("no memory");
    rings_ = static_cast<std::byte*>(::mmap(nullptr, kMemoryBytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0));
    Message map{MessageKind::kMemoryMap};
    map.map.push_back({kMemory, kMemoryBytes, 0, duplicate(file_)});
    EXPECT_FALSE(bridge_.take(std::move(map)));
  }
  ~PciBridge() override { ::munmap(rings_, kMemoryBytes); }

  std::uint32_t config(std::uint32_t at, std::uint32_t size = 4) {
    return static_cast<std::uint32_t>(*bridge_.take({MessageKind::kConfigRead, at, 0, size}));
  }
  void set_config(std::uint32_t at, std::uint32_t value, std::uint32_t size = 4) {
    bridge_.take({MessageKind::kConfigWrite, at, value, size});
  }
  std::uint64_t read(std::uint32_t at, std::uint64_t size = 4) {
    return *bridge_.take({MessageKind::kBarRead, kBar + at, 0, size});
  }
  void write(std::uint32_t at, std::uint64_t value, std::uint64_t size = 4) {
    bridge_.take({MessageKind::kBarWrite, kBar + at, value, size});
  }
  void open(std::uint64_t address = kMemory, std::uint32_t bytes = kRing) {
    set_config(4, 6, 2);
    write(fn::kRingLow, address & 0xFFFF'FFFF);
    write(fn::kRingHigh, address >> 32);
    write(fn::kRingBytes, bytes);
    write(fn::kControl, fn::kOpenSession);
  }
  fn::State state() { return static_cast<fn::State>(read(fn::kState)); }
  fn::Error error() { return static_cast<fn::Error>(read(fn::kError)); }
  std::uint32_t index(std::uint32_t at) { return fn::index_at(rings_, at).load(); }
  void set_index(std::uint32_t at, std::uint32_t value) { fn::index_at(rings_, at).store(value); }
  Fd board() { return std::move(*boards_.get_future().get()); }

  Fd file_{::memfd_create("guest", MFD_CLOEXEC)};
  std::byte* rings_ = nullptr;
  std::promise<std::shared_ptr<Fd>> boards_;
  Bridge bridge_{[this] {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) throw std::runtime_error("no sockets");
    boards_.set_value(std::make_shared<Fd>(ends[1]));
    return Connection{Fd(ends[0]), {}};
  }};
};

TEST_F(PciBridge, HasTheIdsOfTheBoardAndOneBarOfItsSize) {
  const wire::PciConfigSpace board = wire::pci_config_at_reset(0);
  EXPECT_EQ(config(0), board[0]);
  EXPECT_EQ(config(8), board[2]);
  EXPECT_EQ(config(0x2C), board[0x2C / 4]);
  // As QEMU asks for the sizes of BARs: seven words from 0x10 on.
  for (std::uint32_t at = 0x10; at <= 0x28; at += 4) {
    set_config(at, 0xFFFF'FFFF);
    EXPECT_EQ(config(at), at == 0x10 ? ~(wire::kBar0Bytes - 1) : 0);
  }
  EXPECT_EQ(config(254, 4), 0xFFFF'0000);
  EXPECT_EQ(config(0xFFFF'FFFF), 0xFFFF'FFFF);
}

TEST_F(PciBridge, ListsCapabilitiesThatAreTrue) {
  EXPECT_EQ(config(0x34, 1), 0x40u);
  EXPECT_EQ(config(0x40, 2), 0x4801u);  // power management, next
  EXPECT_EQ(config(0x48),
            0x0306'0013u);  // advanced features, last: 6 bytes, transactions pending, function-level reset
  open();
  set_config(0x4C, 1, 1);  // function-level reset
  EXPECT_EQ(state(), fn::State::kClosed);
  EXPECT_EQ(config(4, 2), 0u);
  EXPECT_EQ(read(fn::kRingBytes), 0u);
  set_config(4, 6, 2);
  set_config(0x44, 3, 1);
  EXPECT_EQ(config(4, 2), 6u);
  set_config(0x44, 0, 1);  // from D3hot to D0
  EXPECT_EQ(config(4, 2), 0u);
}

TEST_F(PciBridge, CarriesBytesBothWaysRoundItsRings) {
  open();
  ASSERT_EQ(state(), fn::State::kOpen);
  const Fd board = this->board();
  std::vector<std::uint8_t> sent(3 * kRing), came;
  std::iota(sent.begin(), sent.end(), std::uint8_t{0});
  std::array<std::uint8_t, 1000> part{};
  for (std::uint32_t put = 0; put < sent.size(); put += 1000) {
    const std::uint32_t count = std::min<std::uint32_t>(1000, static_cast<std::uint32_t>(sent.size()) - put);
    for (std::uint32_t i = 0; i < count; ++i) rings_[fn::kIndexBytes + (put + i) % kRing] = std::byte{sent[put + i]};
    set_index(fn::kDownPut, put + count);
    write(fn::kBell, 1);
    EXPECT_EQ(index(fn::kDownTaken), put + count);
    ASSERT_EQ(::recv(board.get(), part.data(), part.size(), MSG_DONTWAIT), count);
    EXPECT_EQ(std::memcmp(part.data(), sent.data() + put, count), 0);
  }
  ASSERT_EQ(::send(board.get(), sent.data(), sent.size(), 0), static_cast<ssize_t>(sent.size()));
  while (came.size() < sent.size()) {
    bridge_.wait(-1, 0);
    const auto taken = static_cast<std::uint32_t>(came.size()), put = index(fn::kUpPut);
    ASSERT_GT(put, taken);
    EXPECT_EQ(index(fn::kUpWaits), put - taken == kRing ? 1u : 0u);
    for (std::uint32_t i = taken; i < put; ++i)
      came.push_back(std::to_integer<std::uint8_t>(rings_[fn::kIndexBytes + kRing + i % kRing]));
    set_index(fn::kUpTaken, put);
    write(fn::kBell, 1);
  }
  EXPECT_EQ(came, sent);
}

TEST_F(PciBridge, RaisesIntxAsALevelUntilItIsAcknowledged) {
  const Fd raise(::eventfd(0, EFD_NONBLOCK)), acknowledged(::eventfd(0, EFD_NONBLOCK));
  Message files{MessageKind::kInterruptFiles};
  files.files.push_back(duplicate(raise));
  files.files.push_back(duplicate(acknowledged));
  EXPECT_FALSE(bridge_.take(std::move(files)));
  const auto raised = [&raise] {
    std::uint64_t count = 0;
    return ::read(raise.get(), &count, sizeof count) == sizeof count ? count : 0;
  };
  constexpr std::uint32_t kPending = 1u << 19;  // of the command and status register
  open();
  const Fd board = this->board();
  write(fn::kInterruptMask, 0);
  ASSERT_EQ(::send(board.get(), "x", 1, 0), 1);
  bridge_.wait(-1, 1000);
  EXPECT_EQ(read(fn::kInterruptStatus), fn::kMoved);
  EXPECT_EQ(raised(), 0u);
  write(fn::kInterruptMask, fn::kMoved);
  EXPECT_EQ(raised(), 1u);
  EXPECT_NE(config(4) & kPending, 0u);
  bridge_.wait(-1, 0);
  EXPECT_EQ(raised(), 0u);  // KVM keeps the level
  const std::uint64_t one = 1;
  ASSERT_EQ(::write(acknowledged.get(), &one, sizeof one), 8);
  bridge_.wait(-1, 1000);
  EXPECT_EQ(raised(), 1u);  // it is still there
  set_config(5, 4, 1);      // INTx disable
  ASSERT_EQ(::write(acknowledged.get(), &one, sizeof one), 8);
  bridge_.wait(-1, 1000);
  EXPECT_EQ(raised(), 0u);
  set_config(5, 0, 1);
  EXPECT_EQ(raised(), 1u);
  write(fn::kInterruptStatus, fn::kMoved);
  EXPECT_EQ(config(4) & kPending, 0u);
  ASSERT_EQ(::write(acknowledged.get(), &one, sizeof one), 8);
  bridge_.wait(-1, 1000);
  EXPECT_EQ(raised(), 0u);
}

TEST_F(PciBridge, NamesWhatIsWrong) {
  write(fn::kControl, fn::kOpenSession);
  EXPECT_EQ(error(), fn::Error::kNoBusMaster);
  const std::array<std::pair<std::uint64_t, std::uint32_t>, 7> wrong{{{kMemory + 64, kRing},
                                                                      {kMemory, kRing - 1},
                                                                      {kMemory, 0},
                                                                      {kMemory, 2 * fn::kMaxRingBytes},
                                                                      {kMemory + kMemoryBytes - 4096, kRing},
                                                                      {kMemory - 4096, kRing},
                                                                      {~std::uint64_t{4095}, kRing}}};
  for (const auto& [address, bytes] : wrong) {
    open(address, bytes);
    EXPECT_EQ(state(), fn::State::kFailed);
    EXPECT_EQ(error(), fn::Error::kBadRing);
  }
  open();
  EXPECT_EQ(error(), fn::Error::kNone);
  EXPECT_EQ(read(fn::kBell + 1, 1), ~std::uint64_t{0});
  EXPECT_EQ(error(), fn::Error::kBadAccess);
  EXPECT_EQ(state(), fn::State::kOpen);
  set_index(fn::kDownPut, kRing + 1);
  write(fn::kBell, 1);
  EXPECT_EQ(state(), fn::State::kFailed);
  EXPECT_EQ(index(fn::kStreamEnded), 1u);
}

TEST_F(PciBridge, EndsASessionWhoseMemoryIsTakenAway) {
  open();
  EXPECT_FALSE(bridge_.take(Message{MessageKind::kMemoryMap}));
  EXPECT_EQ(state(), fn::State::kFailed);
  EXPECT_EQ(error(), fn::Error::kBadRing);
}

TEST_F(PciBridge, TellsWhenTheBoardIsGone) {
  open();
  board().reset();
  bridge_.wait(-1, 1000);
  EXPECT_EQ(state(), fn::State::kFailed);
  EXPECT_EQ(error(), fn::Error::kBoardGone);
}

TEST(QemuMessages, AreTakenOnlyAsQemuSendsThem) {
  std::array<std::uint8_t, kMessageHeaderBytes> header{};
  const std::vector<std::uint8_t> data(kMaxMessageBytes);
  for (int kind = 0; kind < 256; ++kind) {
    header[0] = static_cast<std::uint8_t>(kind);
    for (std::size_t size = 0; size <= data.size(); ++size) {
      const bool is_one = (kind == 0 && size == 192) || ((kind == 2 || kind == 3) && size == 12) ||
                          ((kind == 4 || kind == 5) && size == 24) || (kind == 7 && size == 0);
      EXPECT_EQ(decode(header, std::span(data).first(size), {}).has_value(), is_one) << kind << ", " << size;
    }
  }
}

TEST(QemuMessages, AreRefusedIfTheyAnnounceMoreBytesThanAnyHas) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
  const Fd ours(ends[0]), qemu(ends[1]);
  for (const std::uint64_t bytes : {std::uint64_t{193}, ~std::uint64_t{0}}) {
    const std::array<std::uint64_t, 2> header{0, bytes};
    ASSERT_EQ(::send(qemu.get(), header.data(), sizeof header, 0), 16);
    EXPECT_THROW(receive(ours.get()), std::runtime_error);
  }
}

// A machine with one function, in a folder.
class Sysfs : public testing::Test {
 protected:
  void SetUp() override {
    put("vendor", "0x4749");
    put("device", "0x0c5b");
    put("resource0", "");
    put("config", std::string(64, '\0'));
    pages("3");
  }
  void put(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(folder());
    std::ofstream(folder() / name) << text << '\n';
  }
  void pages(const std::string& count) const {
    const auto place = root() / "kernel/mm/hugepages/hugepages-2048kB";
    std::filesystem::create_directories(place);
    std::ofstream(place / "free_hugepages") << count << '\n';
  }
  std::filesystem::path root() const { return folder_.path(); }
  std::filesystem::path folder() const { return pci_folder("0000:00:04.0", root()); }
  // The answer that does not hold, and its advice.
  std::string fault(const std::string& address = "0000:00:04.0") const {
    const auto found = pci_conditions(address, root());
    for (const PciCondition& each : found) {
      if (!each.holds) return each.question + " " + each.answer + " -> " + each.advice;
    }
    return "none of " + std::to_string(found.size());
  }

  reference::TemporaryDirectory folder_;
};

TEST_F(Sysfs, SaysWhatAFunctionNeeds) {
  EXPECT_EQ(fault(), "none of 5");
  EXPECT_THAT(fault("0000:00:05.0"), HasSubstr("is there a PCI function? 0000:00:05.0 -> lspci"));
  pages("0");
  EXPECT_THAT(fault(), HasSubstr("0 free pages of 2 MiB -> echo 4 > /proc/sys/vm/nr_hugepages"));
  std::filesystem::create_directory_symlink("/sys/bus/pci/drivers/vfio-pci", folder() / "driver");
  EXPECT_THAT(fault(), HasSubstr("it is bound to vfio-pci -> echo 0000:00:04.0 > "));
  put("device", "0x0c5c");
  EXPECT_THAT(fault(), HasSubstr("4749:0c5c -> a board is 4749:0c5b"));
}

TEST_F(Sysfs, ListsFunctionsThatAreBoards) {
  const auto found = pci_devices(root());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].address, "0000:00:04.0");
  EXPECT_FALSE(found[0].in_use);
  std::string config(64, '\0');
  config[4] = 6;  // memory space, bus master
  put("config", config);
  EXPECT_TRUE(pci_devices(root()).at(0).in_use);
  put("vendor", "0x8086");
  EXPECT_TRUE(pci_devices(root()).empty());
}

}  // namespace
}  // namespace gicube::pci
