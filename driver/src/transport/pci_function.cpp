#include "pci_function.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

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
constexpr std::uint32_t kRing = 512 << 10;          // two of them and their indices are within a huge page
constexpr std::uint16_t kInterruptsOff = 1u << 10;  // of the command register: INTx disable
constexpr auto kHandOver = 1s;       // chosen: for the thread of a lost session to let go of the function
constexpr auto kOpenPatience = 10s;  // chosen: twice what gicube-pci takes to give up on a board
constexpr auto kGoodbye = 1s;        // chosen: for a board to take the last frames
// An interrupt may never come: only KVM delivers it. So memory is looked at, at first often, then in proportion to the
// time that it has been quiet, which makes what comes late by a sixteenth at most.
constexpr std::chrono::nanoseconds kFirstLook = 20us, kLastLook = 10ms;
constexpr auto kSignOfLife =
    10ms;  // chosen: between two reads of a register, of 16 us, which tell that the function was removed

std::string text_of_errno() { return std::strerror(errno); }

Fd open_file(const fs::path& path, int flags) {
  Fd file(::open(path.c_str(), flags | O_CLOEXEC));
  if (file.get() < 0) throw OpenFailed(fmt::format("cannot open {}: {}", path.string(), text_of_errno()));
  return file;
}

void check_conditions(const std::string& address) {
  for (const PciCondition& each : pci_conditions(address)) {
    if (!each.holds)
      throw OpenFailed(
          fmt::format("cannot open the PCI function {}: {} {}; {}", address, each.question, each.answer, each.advice));
  }
}

// The lock goes with the process. Only a thread of a session that was lost gives it up soon.
void take_lock(const Fd& file, const std::string& address) {
  for (const auto end = PumpClock::now() + kHandOver; ::flock(file.get(), LOCK_EX | LOCK_NB) != 0;) {
    if (PumpClock::now() > end) throw BoardBusy(fmt::format("another process has opened the PCI function {}", address));
    std::this_thread::sleep_for(1ms);
  }
}

// Makes the kernel give the function its addresses, unless a driver has.
void enable(const fs::path& folder) {
  if (!kernel_driver_of(folder).empty()) return;
  const Fd file = open_file(folder / "enable", O_RDWR);
  char count = '0';
  if (::read(file.get(), &count, 1) == 1 && count != '0') return;
  if (::pwrite(file.get(), "1", 1, 0) != 1)
    throw OpenFailed(fmt::format("cannot enable the PCI function in {}: {}", folder.string(), text_of_errno()));
}

// The file that uio_pci_generic has for the function: tells of interrupts, and takes the bus from the function when
// this process ends.
Fd open_uio(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / "uio", error)) {
    return open_file("/dev" / entry.path().filename(), O_RDONLY | O_NONBLOCK);
  }
  return {};
}

}  // namespace

PciFunction::Mapping::Mapping(std::size_t bytes, int flags, int file, const std::string& what) {
  void* const at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, flags, file, 0);
  if (at == MAP_FAILED) throw OpenFailed(fmt::format("cannot map {}: {}", what, text_of_errno()));
  bytes_ = {static_cast<std::byte*>(at), bytes};
}

PciFunction::Mapping::~Mapping() {
  if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
}

PciFunction::PciFunction(const std::string& address) : address_(address) {
  check_conditions(address);
  const fs::path folder = pci_folder(address);
  registers_file_ = open_file(folder / "resource0", O_RDWR | O_SYNC);
  take_lock(registers_file_, address);
  enable(folder);
  config_ = open_file(folder / "config", O_RDWR);
  interrupts_ = open_uio(folder);
  registers_ = Mapping(wire::kBar0Bytes, MAP_SHARED, registers_file_.get(), "the registers of " + address);
  const std::uint32_t identity = read(fn::kIdentity), version = read(fn::kVersion);
  if (identity == fn::kGone)
    throw OpenFailed(fmt::format("the PCI function {} does not answer: was it removed?", address));
  if (identity != fn::kIdentityValue || version != fn::kVersionValue) {
    throw OpenFailed(fmt::format("the PCI function {} has identity {:08x}, version {}; expected {:08x}, {}", address,
                                 identity, version, fn::kIdentityValue, fn::kVersionValue));
  }
  // A killed process must not leave a function that writes into memory that is no longer ours.
  write(fn::kControl, fn::kCloseSession);
  // Shared: a child of fork() must not make this process write into a copy that the function does not know.
  rings_ = Mapping(kHugePage, MAP_SHARED | MAP_ANONYMOUS | MAP_HUGETLB | (21 << MAP_HUGE_SHIFT) | MAP_POPULATE, -1,
                   "a huge page for the rings of " + address);
  ::madvise(rings_.data(), kHugePage, MADV_DONTFORK);
  const std::span<std::byte> all(rings_.data(), kHugePage);
  down_ = all.subspan(fn::kIndexBytes, kRing);
  up_ = all.subspan(fn::kIndexBytes + kRing, kRing);
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw OpenFailed(fmt::format("no sockets for {}: {}", address, text_of_errno()));
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
  return *reinterpret_cast<const volatile std::uint32_t*>(registers_.data() + offset);
}

void PciFunction::write(std::uint32_t offset, std::uint32_t value) const {
  *reinterpret_cast<volatile std::uint32_t*>(registers_.data() + offset) = value;
}

void PciFunction::set_command(std::uint16_t set, std::uint16_t clear) const {
  std::uint16_t command = 0;
  bool done = ::pread(config_.get(), &command, sizeof command, wire::pci::kCommandStatus) == sizeof command;
  command = static_cast<std::uint16_t>((command & ~clear) | set);
  done = done && ::pwrite(config_.get(), &command, sizeof command, wire::pci::kCommandStatus) == sizeof command;
  if (!done && set != 0)
    throw OpenFailed(fmt::format("cannot write the command register of {}: {}", address_, text_of_errno()));
}

std::uint64_t PciFunction::physical_address() const {
  const long page = ::sysconf(_SC_PAGESIZE);
  const Fd pagemap = open_file("/proc/self/pagemap", O_RDONLY);
  std::uint64_t entry = 0;
  const auto at =
      static_cast<off_t>(reinterpret_cast<std::uintptr_t>(rings_.data()) / static_cast<std::size_t>(page) * 8);
  // Documentation/admin-guide/mm/pagemap.rst of Linux: bits 0-54 are the frame's number, 0 for who may not know it.
  const bool known = ::pread(pagemap.get(), &entry, sizeof entry, at) == sizeof entry;
  const std::uint64_t frame = entry & ((std::uint64_t{1} << 55) - 1);
  if (!known || frame == 0) {
    throw OpenFailed(fmt::format(
        "the kernel does not say where the rings of {} are in memory: run as root (CAP_SYS_ADMIN)", address_));
  }
  return frame * static_cast<std::uint64_t>(page);
}

void PciFunction::open_session() {
  set_command(wire::pci::kCommandMemorySpace | wire::pci::kCommandBusMaster,
              interrupts_.get() >= 0 ? kInterruptsOff : 0);
  const std::uint64_t address = physical_address();
  write(fn::kRingLow, static_cast<std::uint32_t>(address));
  write(fn::kRingHigh, static_cast<std::uint32_t>(address >> 32));
  write(fn::kRingBytes, kRing);
  write(fn::kInterruptStatus, fn::kMoved | fn::kEnded);
  write(fn::kInterruptMask, interrupts_.get() >= 0 ? fn::kMoved | fn::kEnded : 0);
  write(fn::kControl, fn::kOpenSession);
  for (const auto end = PumpClock::now() + kOpenPatience;;) {
    const std::uint32_t state = read(fn::kState);
    if (state == static_cast<std::uint32_t>(fn::State::kOpen)) return;
    if (state != static_cast<std::uint32_t>(fn::State::kOpening) || PumpClock::now() > end) {
      throw OpenFailed(
          fmt::format("the PCI function {} cannot be opened: {}", address_,
                      state == fn::kGone ? "it was removed" : fn::text_of(static_cast<fn::Error>(read(fn::kError)))));
    }
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
  const std::uint32_t before = put_;
  const std::uint32_t held = put_ - fn::index_at(rings_.data(), fn::kDownTaken).load(std::memory_order_acquire);
  std::uint32_t space = held <= kRing ? kRing - held : 0;
  while (space > 0 && !link_has_closed_) {
    const auto piece = fn::piece_of(down_, put_, space);
    const ssize_t got = ::recv(socket_.get(), piece.data(), piece.size(), MSG_DONTWAIT);
    if (got < 0) break;
    link_has_closed_ = got == 0;
    put_ += static_cast<std::uint32_t>(got);
    space -= static_cast<std::uint32_t>(got);
  }
  ring_is_full_ = space == 0;
  if (put_ == before) return false;
  fn::index_at(rings_.data(), fn::kDownPut).store(put_, std::memory_order_release);
  write(fn::kBell, 1);
  return true;
}

// Bytes of the board to the link.
bool PciFunction::move_up() {
  const std::uint32_t before = taken_;
  has_ended_ = fn::index_at(rings_.data(), fn::kStreamEnded).load(std::memory_order_acquire) != 0;
  std::uint32_t count = fn::index_at(rings_.data(), fn::kUpPut).load(std::memory_order_acquire) - taken_;
  if (count > kRing) return false;  // a function that is none of ours
  socket_is_full_ = false;
  while (count > 0) {
    const auto piece = fn::piece_of(up_, taken_, count);
    ssize_t sent = ::send(socket_.get(), piece.data(), piece.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) {
      socket_is_full_ = errno == EAGAIN;
      if (socket_is_full_) break;
      sent = static_cast<ssize_t>(piece.size());  // the link has closed: nobody wants them
    }
    taken_ += static_cast<std::uint32_t>(sent);
    count -= static_cast<std::uint32_t>(sent);
  }
  if (taken_ == before) return false;
  fn::index_at(rings_.data(), fn::kUpTaken).store(taken_);
  if (fn::index_at(rings_.data(), fn::kUpWaits).load() != 0) write(fn::kBell, 1);
  return true;
}

// Nothing has moved: is there a reason that nothing will?
bool PciFunction::is_over() {
  if (link_has_closed_ && fn::index_at(rings_.data(), fn::kDownTaken).load() == put_) return true;
  if (has_ended_ && !socket_is_full_) return true;
  const auto now = PumpClock::now();
  if (now - looked_ < kSignOfLife) return false;
  looked_ = now;
  return read(fn::kState) != static_cast<std::uint32_t>(fn::State::kOpen) && !socket_is_full_ &&
         fn::index_at(rings_.data(), fn::kUpPut).load() == taken_;
}

void PciFunction::wait(std::chrono::nanoseconds idle) {
  const auto longest = std::clamp(idle / 16, kFirstLook, kLastLook);
  const timespec limit{0, static_cast<long>(longest.count())};
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
