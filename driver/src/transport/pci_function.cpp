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
#include "ring.h"

namespace gicube {
namespace {

namespace fs = std::filesystem;
namespace fn = wire::function;
using namespace std::chrono_literals;
using PumpClock = std::chrono::steady_clock;

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::uint32_t kRing = 512 << 10;     // two of them and their indices are within a huge page
constexpr unsigned kInterruptsOff = 1u << 10;  // of the command register: INTx disable
constexpr auto kHandOver = 1s;                 // chosen: for the thread of a lost session to let go of the function
constexpr auto kOpenPatience = 10s;            // chosen: twice what gicube-pci takes to give up on a board
constexpr auto kGoodbye = 1s;                  // chosen: for a board to take the last frames
// An interrupt may never come: only KVM delivers it. So memory is looked at, at first often, then in proportion to the
// time that it has been quiet, which makes what comes late by a sixteenth at most.
constexpr std::chrono::nanoseconds kFirstLook = 20us, kLastLook = 10ms;
constexpr auto kSignOfLife =
    10ms;  // chosen: between reads of a register, of 16 us, which tell that the function was removed

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

// The lock goes with the process. Only a thread of a session that was lost gives it up soon.
void take_lock(const Fd& file, const std::string& address) {
  for (const auto end = PumpClock::now() + kHandOver; ::flock(file.get(), LOCK_EX | LOCK_NB) != 0;) {
    if (PumpClock::now() > end) throw BoardBusy("another process has opened the PCI function " + address);
    std::this_thread::sleep_for(1ms);
  }
}

// Makes the kernel give the function its addresses, unless a driver has.
void enable(const std::string& address, const fs::path& folder) {
  if (!kernel_driver_of(folder).empty()) return;
  const Fd file = open_file(address, folder / "enable", O_RDWR);
  char count = '0';
  if (::read(file.get(), &count, 1) == 1 && count != '0') return;
  expect(::pwrite(file.get(), "1", 1, 0) == 1, address, "it cannot be enabled");
}

// The file that uio_pci_generic has for the function: tells of interrupts, and takes the bus from the function when
// this process ends.
Fd open_uio(const std::string& address, const fs::path& folder) {
  std::error_code error;
  const fs::directory_iterator first(folder / "uio", error);
  if (first == fs::directory_iterator()) return {};
  return open_file(address, "/dev" / first->path().filename(), O_RDONLY | O_NONBLOCK);
}

}  // namespace

PciFunction::PciFunction(const std::string& address) : address_(address) {
  for (const auto& [holds, question, answer, advice] : pci_conditions(address)) {
    if (!holds) fail(address, fmt::format("{} {}; {}", question, answer, advice));
  }
  const fs::path folder = pci_folder(address);
  registers_file_ = open_file(address, folder / "resource0", O_RDWR | O_SYNC);
  take_lock(registers_file_, address);
  enable(address, folder);
  config_ = open_file(address, folder / "config", O_RDWR);
  interrupts_ = open_uio(address, folder);
  registers_ = map_shared(wire::kBar0Bytes, registers_file_.get());
  expect(registers_ != nullptr, address, "its registers cannot be mapped");
  const std::uint32_t identity = read(fn::kIdentity), version = read(fn::kVersion);
  if (identity == fn::kGone) fail(address, "it does not answer; was it removed?");
  if (identity != fn::kIdentityValue || version != fn::kVersionValue) {
    fail(address, fmt::format("it has identity {:08x}, version {}; expected {:08x}, {}", identity, version,
                              fn::kIdentityValue, fn::kVersionValue));
  }
  // A killed process must not leave a function that writes into memory that is no longer ours.
  write(fn::kControl, fn::kCloseSession);
  // Shared: a child of fork() must not make this process write into a copy that the function does not know.
  rings_ = map_shared(kHugePage, -1, 0, MAP_ANONYMOUS | MAP_HUGETLB | (21 << MAP_HUGE_SHIFT) | MAP_POPULATE);
  expect(rings_ != nullptr, address, "a huge page cannot be mapped");
  ::madvise(rings_.get(), kHugePage, MADV_DONTFORK);
  down_ = {rings_.get() + fn::kIndexBytes, kRing};
  up_ = {rings_.get() + fn::kIndexBytes + kRing, kRing};
  std::array<int, 2> ends{};
  expect(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0, address, "no sockets");
  socket_ = Fd(ends[0]);
  link_end_ = Fd(ends[1]);
  open_session();
  looked_ = PumpClock::now();
  thread_ = std::thread([this] { run(); });
}

PciFunction::~PciFunction() {
  for (const auto end = PumpClock::now() + kGoodbye; link_end_.get() < 0 && PumpClock::now() < end;) {
    pollfd over{stop_.get(), POLLIN, 0};
    if (::poll(&over, 1, 1) > 0) break;  // by the thread
  }
  stops_ = true;
  stop_.happen();
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

std::uint64_t PciFunction::physical_address() const {
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const Fd pagemap = open_file(address_, "/proc/self/pagemap", O_RDONLY);
  std::uint64_t entry = 0;
  const auto at = static_cast<off_t>(reinterpret_cast<std::uintptr_t>(rings_.get()) / page * sizeof entry);
  // Documentation/admin-guide/mm/pagemap.rst of Linux: bits 0-54 are the frame's number, 0 for who may not know it.
  const bool known = ::pread(pagemap.get(), &entry, sizeof entry, at) == sizeof entry;
  const std::uint64_t frame = entry & ((std::uint64_t{1} << 55) - 1);
  if (!known || frame == 0) fail(address_, "the kernel does not say where its rings are: run as root (CAP_SYS_ADMIN)");
  return frame * page;
}

void PciFunction::open_session() {
  const bool hears = interrupts_.get() >= 0;
  expect(set_command(wire::pci::kCommandMemorySpace | wire::pci::kCommandBusMaster, hears ? kInterruptsOff : 0),
         address_, "its command register cannot be written");
  const std::uint64_t address = physical_address();
  write(fn::kRingLow, static_cast<std::uint32_t>(address));
  write(fn::kRingHigh, static_cast<std::uint32_t>(address >> 32));
  write(fn::kRingBytes, kRing);
  write(fn::kInterruptStatus, fn::kMoved | fn::kEnded);
  write(fn::kInterruptMask, hears ? fn::kMoved | fn::kEnded : 0);
  write(fn::kControl, fn::kOpenSession);
  for (const auto end = PumpClock::now() + kOpenPatience;;) {
    const std::uint32_t state = read(fn::kState);
    if (state == static_cast<std::uint32_t>(fn::State::kOpen)) return;
    if (state == fn::kGone) fail(address_, "it was removed");
    if (state != static_cast<std::uint32_t>(fn::State::kOpening) || PumpClock::now() > end)
      fail(address_, fn::text_of(static_cast<fn::Error>(read(fn::kError))));
    std::this_thread::sleep_for(1ms);
  }
}

void PciFunction::run() {
  auto moved = PumpClock::now();
  while (!stops_) {
    const bool down = move_down(), up = move_up();
    const auto now = PumpClock::now();
    if (down || up)
      moved = now;
    else if (is_over())
      break;
    else
      wait(now - moved);
  }
  write(fn::kInterruptMask, 0);
  write(fn::kControl, fn::kCloseSession);
  set_command(0, wire::pci::kCommandBusMaster);
  socket_.reset();
  ::flock(registers_file_.get(), LOCK_UN);
  stop_.happen();
}

// Bytes of the link into the ring. True: some were moved.
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

// Bytes of the board to the link.
bool PciFunction::move_up() {
  const std::uint32_t before = taken_;
  has_ended_ = index(fn::kStreamEnded) != 0;
  const std::uint32_t put = index(fn::kUpPut);
  if (put - taken_ > kRing) return false;  // a function that is none of ours
  const RingStop stop = ring_to_socket(up_, taken_, put - taken_, socket_.get());
  socket_is_full_ = stop == RingStop::kMustWait;
  if (stop == RingStop::kClosed) taken_ = put;  // the link has closed: nobody wants them
  if (taken_ == before) return false;
  fn::index_at(rings_.get(), fn::kUpTaken).store(taken_);
  if (fn::index_at(rings_.get(), fn::kUpWaits).load() != 0) write(fn::kBell, 1);
  return true;
}

// Nothing has moved: is there a reason that nothing will?
bool PciFunction::is_over() {
  if (link_has_closed_ && index(fn::kDownTaken) == put_) return true;
  if (has_ended_ && !socket_is_full_) return true;
  const auto now = PumpClock::now();
  if (now - looked_ < kSignOfLife) return false;
  looked_ = now;
  return read(fn::kState) != static_cast<std::uint32_t>(fn::State::kOpen) && !socket_is_full_ &&
         index(fn::kUpPut) == taken_;
}

void PciFunction::wait(std::chrono::nanoseconds idle) {
  const timespec limit{0, static_cast<long>(std::clamp(idle / 16, kFirstLook, kLastLook).count())};
  const bool reads = !ring_is_full_ && !link_has_closed_;
  std::array<pollfd, 3> files{
      {{socket_.get(), static_cast<short>((reads ? POLLIN : 0) | (socket_is_full_ ? POLLOUT : 0)), 0},
       {stop_.get(), POLLIN, 0},
       {interrupts_.get(), POLLIN, 0}}};
  if (files[0].events == 0) files[0].fd = -1;  // or a closed one would be reported without end
  if (::ppoll(files.data(), files.size(), &limit, nullptr) <= 0 || files[2].revents == 0) return;
  std::uint32_t count = 0;
  if (::read(interrupts_.get(), &count, sizeof count) != sizeof count) return interrupts_.reset();
  write(fn::kInterruptStatus, fn::kMoved | fn::kEnded);
  set_command(0, kInterruptsOff);  // uio_pci_generic has set it
}

}  // namespace gicube
