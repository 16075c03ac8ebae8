#include "pci_function.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "gicube/error.h"
#include "gicube/wire/pci_config.h"
#include "gicube/wire/pci_function.h"
#include "pci_devices.h"

namespace gicube {
namespace {

namespace fs = std::filesystem;
namespace fn = wire::function;
using namespace std::chrono_literals;
using PumpClock = std::chrono::steady_clock;

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::uint32_t kRing = 512 << 10;     // two of them and their indices fit into a huge page
constexpr unsigned kInterruptsOff = 1u << 10;  // of the command register: INTx disable
constexpr auto kGoodbye = 1s;                  // chosen: the time a board has to take the last frames
// An interrupt may never arrive: only KVM delivers it. So the memory is polled, at first often, then in proportion to
// the time without news, which adds a sixteenth to that time at most.
constexpr std::chrono::nanoseconds kFirstLook = 20us, kLastLook = 10ms;
// Chosen: between reads of a register, which take 16 us and show that the function was removed.
constexpr auto kSignOfLife = 10ms;

[[noreturn]] void fail(const std::string& address, const std::string& why) {
  throw OpenFailed(fmt::format("cannot open the PCI function {}: {}", address, why));
}

void expect(bool good, const std::string& address, const std::string& what) {
  if (!good) fail(address, what + ": " + std::strerror(errno));
}

Fd open_file(const std::string& address, const fs::path& path, int flags) {
  Fd file(::open(path.c_str(), flags | O_CLOEXEC));
  expect(file.get() >= 0, address, path.string());
  return file;
}

// Makes the kernel assign the function's addresses, unless a driver has.
void enable(const std::string& address, const fs::path& folder) {
  if (!kernel_driver_of(folder).empty()) return;
  const Fd file = open_file(address, folder / "enable", O_WRONLY);
  expect(::write(file.get(), "1", 1) == 1, address, "cannot enable it");
}

// The file of uio_pci_generic for the function: it reports interrupts, and ends the function's bus mastering when this
// process ends.
Fd open_uio(const std::string& address, const fs::path& folder) {
  std::error_code error;
  const fs::directory_iterator first(folder / "uio", error);
  if (first == fs::directory_iterator()) return {};
  return open_file(address, "/dev" / first->path().filename(), O_RDONLY | O_NONBLOCK);
}

std::uint64_t physical_address(const std::string& address, const std::byte* of) {
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const Fd pagemap = open_file(address, "/proc/self/pagemap", O_RDONLY);
  std::uint64_t entry = 0;
  const auto at = static_cast<off_t>(reinterpret_cast<std::uintptr_t>(of) / page * sizeof entry);
  // Documentation/admin-guide/mm/pagemap.rst of Linux: bits 0-54 are the frame's number, or 0 without the right to know
  // it.
  const bool known = ::pread(pagemap.get(), &entry, sizeof entry, at) == sizeof entry;
  const std::uint64_t frame = entry & ((std::uint64_t{1} << 55) - 1);
  if (!known || frame == 0) fail(address, "the kernel does not say where its rings are: run as root (CAP_SYS_ADMIN)");
  return frame * page;
}

}  // namespace

PciFunction::PciFunction(const std::string& address) {
  for (const auto& [holds, question, answer, advice] : pci_conditions(address)) {
    if (!holds) fail(address, fmt::format("{} {}; {}", question, answer, advice));
  }
  const fs::path folder = pci_folder(address);
  registers_file_ = open_file(address, folder / "resource0", O_RDWR | O_SYNC);
  // The lock ends with the process.
  if (::flock(registers_file_.get(), LOCK_EX | LOCK_NB) != 0)
    throw BoardBusy("another process has opened the PCI function " + address);
  enable(address, folder);
  config_ = open_file(address, folder / "config", O_RDWR);
  interrupts_ = open_uio(address, folder);
  registers_ = map_shared(wire::kBar0Bytes, registers_file_.get());
  expect(registers_ != nullptr, address, "cannot map its registers");
  const std::uint32_t identity = read(fn::kIdentity), version = read(fn::kVersion);
  if (identity == fn::kGone) fail(address, "it does not answer; was it removed?");
  if (identity != fn::kIdentityValue || version != fn::kVersionValue) {
    fail(address, fmt::format("it has identity {:08x}, version {}; expected {:08x}, {}", identity, version,
                              fn::kIdentityValue, fn::kVersionValue));
  }
  // A killed process may have left a function that still writes into memory, which is no longer ours.
  write(fn::kControl, fn::kCloseSession);
  // Shared: a child of fork() must not make this process write into a copy that the function does not know.
  rings_ = map_shared(kHugePage, -1, 0, MAP_ANONYMOUS | MAP_HUGETLB | (21 << MAP_HUGE_SHIFT) | MAP_POPULATE);
  expect(rings_ != nullptr, address, "cannot map a huge page");
  ::madvise(rings_.get(), kHugePage, MADV_DONTFORK);
  down_ = {rings_.get() + fn::kIndexBytes, kRing};
  up_ = {rings_.get() + fn::kIndexBytes + kRing, kRing};
  std::array<int, 2> ends{};
  expect(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0, address, "cannot make sockets");
  socket_ = Fd(ends[0]);
  link_end_ = Fd(ends[1]);
  const std::uint64_t at = physical_address(address, rings_.get());
  const bool has_interrupts = interrupts_.get() >= 0;
  expect(
      set_command(wire::pci::kCommandMemorySpace | wire::pci::kCommandBusMaster, has_interrupts ? kInterruptsOff : 0),
      address, "cannot write its command register");
  write(fn::kRingLow, static_cast<std::uint32_t>(at));
  write(fn::kRingHigh, static_cast<std::uint32_t>(at >> 32));
  write(fn::kRingBytes, kRing);
  write(fn::kInterruptStatus, fn::kMoved | fn::kEnded);
  write(fn::kInterruptMask, has_interrupts ? fn::kMoved | fn::kEnded : 0);
  write(fn::kControl, fn::kOpenSession);
  const std::uint32_t state = read(fn::kState);
  if (state != static_cast<std::uint32_t>(fn::State::kOpen)) {
    set_command(0, wire::pci::kCommandBusMaster);
    fail(address, state == fn::kGone ? "it was removed" : fn::text_of(static_cast<fn::Error>(read(fn::kError))));
  }
  looked_ = PumpClock::now();
  thread_ = std::thread([this] { run(); });
}

PciFunction::~PciFunction() {
  end_ = PumpClock::now() + kGoodbye;
  thread_.join();
}

std::uint32_t PciFunction::read(std::uint32_t offset) const {
  return *reinterpret_cast<const volatile std::uint32_t*>(registers_.get() + offset);
}

void PciFunction::write(std::uint32_t offset, std::uint32_t value) const {
  *reinterpret_cast<volatile std::uint32_t*>(registers_.get() + offset) = value;
}

std::uint32_t PciFunction::index(std::uint32_t of) const {
  return fn::index_at(rings_.get(), of).load(std::memory_order_acquire);
}

bool PciFunction::set_command(unsigned set, unsigned clear) const {
  std::uint16_t command = 0;
  if (::pread(config_.get(), &command, sizeof command, wire::pci::kCommandStatus) != sizeof command) return false;
  command = static_cast<std::uint16_t>((command & ~clear) | set);
  return ::pwrite(config_.get(), &command, sizeof command, wire::pci::kCommandStatus) == sizeof command;
}

void PciFunction::run() {
  for (auto now = PumpClock::now(), moved = now; now < end_.load(); now = PumpClock::now()) {
    const bool down = move_down(), up = move_up();
    if (down || up)
      moved = now;
    else if (is_over(now))
      break;
    else
      wait(now - moved);
  }
  write(fn::kInterruptMask, 0);
  write(fn::kControl, fn::kCloseSession);
  set_command(0, wire::pci::kCommandBusMaster);
  ::flock(registers_file_.get(), LOCK_UN);  // before the link is told that the session has ended
  socket_.reset();
}

// Moves the link's bytes into the ring. True if there were any.
bool PciFunction::move_down() {
  const std::uint32_t before = put_, held = put_ - index(fn::kDownTaken);
  const std::uint32_t space = held <= kRing && !link_has_closed_ ? kRing - held : 0;
  const RingStop stop = socket_to_ring(socket_.get(), down_, put_, space);
  link_has_closed_ = link_has_closed_ || stop == RingStop::kClosed;
  ring_is_full_ = stop == RingStop::kAllMoved;
  if (put_ == before) return false;
  fn::index_at(rings_.get(), fn::kDownPut).store(put_, std::memory_order_release);
  write(fn::kBell, 1);
  return true;
}

// Moves the board's bytes to the link. True if there were any.
bool PciFunction::move_up() {
  const std::uint32_t before = taken_;
  has_ended_ = index(fn::kStreamEnded) != 0;
  const std::uint32_t put = index(fn::kUpPut);
  if (put - taken_ > kRing) return false;  // a function that is not one of ours
  const RingStop stop = ring_to_socket(up_, taken_, put - taken_, socket_.get());
  socket_is_full_ = stop == RingStop::kMustWait;
  if (stop == RingStop::kClosed) taken_ = put;  // the link has closed: the bytes are dropped
  if (taken_ == before) return false;
  fn::index_at(rings_.get(), fn::kUpTaken).store(taken_);
  if (fn::index_at(rings_.get(), fn::kUpWaits).load() != 0) write(fn::kBell, 1);
  return true;
}

// Nothing was moved. Returns whether there is a reason that nothing will be.
bool PciFunction::is_over(PumpClock::time_point now) {
  if (link_has_closed_ && index(fn::kDownTaken) == put_) return true;
  if (has_ended_ && !socket_is_full_) return true;
  if (now - looked_ < kSignOfLife) return false;
  looked_ = now;
  return read(fn::kState) != static_cast<std::uint32_t>(fn::State::kOpen) && !socket_is_full_ &&
         index(fn::kUpPut) == taken_;
}

void PciFunction::wait(std::chrono::nanoseconds idle) {
  const timespec limit{0, static_cast<long>(std::clamp(idle / 16, kFirstLook, kLastLook).count())};
  const bool reads = !ring_is_full_ && !link_has_closed_;
  std::array<pollfd, 2> files{
      {{socket_.get(), static_cast<short>((reads ? POLLIN : 0) | (socket_is_full_ ? POLLOUT : 0)), 0},
       {interrupts_.get(), POLLIN, 0}}};
  if (files[0].events == 0) files[0].fd = -1;  // otherwise poll() would report a closed one each time
  if (::ppoll(files.data(), files.size(), &limit, nullptr) <= 0 || files[1].revents == 0) return;
  std::uint32_t count = 0;
  if (::read(interrupts_.get(), &count, sizeof count) != sizeof count) return interrupts_.reset();
  write(fn::kInterruptStatus, fn::kMoved | fn::kEnded);
  set_command(0, kInterruptsOff);  // uio_pci_generic has set it
}

}  // namespace gicube
