// Runs in the guest and on the host: what an application sees of a board, a line of text for each thing.
//
//   gicube-guest-probe work URI             pictures, rays and times of a round, as a hash
//   gicube-guest-probe hold URI             works until the board is lost; says why
//   gicube-guest-probe found                gicube::enumerate()
//   gicube-guest-probe speed URI            rates through the rings or the socket, in wall-clock time
//   gicube-guest-probe doorbell [PCI]       time of one; without PCI, of a byte to another process and back
//   gicube-guest-probe interrupts PCI       how many of 100 uio_pci_generic hands on
//   gicube-guest-probe hostile PCI SEED N   does N things to the function that no driver does
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <random>
#include <stdexcept>
#include <string>

#include "gicube/enumerate.h"
#include "gicube/wire/pci_function.h"
#include "good_client.h"

namespace gicube::system_test {
namespace {

namespace fn = wire::function;

class Hash {
 public:
  void add(double number) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &number, sizeof bits);
    for (int i = 0; i < 8; ++i) value_ = (value_ ^ (bits >> 8 * i & 0xFF)) * 0x100000001b3;
  }
  unsigned long long value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;  // FNV-1a
};

void print(const Round& round) {
  Hash pictures, rays;
  for (const Image& image : round.pictures) {
    for (const auto& [red, green, blue, alpha] : image.pixels) {
      for (const int part : {int{red}, int{green}, int{blue}, int{alpha}}) pictures.add(part);
    }
  }
  std::size_t count = 0;
  for (const RayBatch& batch : round.batches) {
    rays.add(static_cast<double>(batch.completed));
    for (const TracedRay& ray : batch.rays) {
      ++count;
      for (const double part :
           {double{1} * ray.id, ray.position.x, ray.position.y, ray.position.z, ray.direction.x, ray.direction.y,
            ray.direction.z, ray.colour[0], ray.colour[1], ray.colour[2], ray.opacity}) {
        rays.add(part);
      }
    }
  }
  std::printf("pictures %016llx, %zu rays %016llx, from %llu ps to %llu ps\n", pictures.value(), count, rays.value(),
              static_cast<unsigned long long>(round.begin), static_cast<unsigned long long>(round.end));
  std::fflush(stdout);
}

int work_once(const std::string& uri) {
  OpenOptions options;
  options.reopen_attempts = 20;
  Board board = Board::open(uri, options);
  prepare(board);
  print(work(board));
  return 0;
}

int hold(const std::string& uri) {
  OpenOptions options;
  options.watchdog = std::chrono::seconds(10);
  Board board = Board::open(uri, options);
  prepare(board);
  std::puts("holding");
  std::fflush(stdout);
  try {
    for (;;) work(board);
  } catch (const DeviceLost& lost) {
    std::printf("lost (%d): %s\n", static_cast<int>(lost.cause()), lost.what());
  }
  return 0;
}

int found() {
  for (const FoundBoard& each : enumerate()) {
    std::printf("%s: %s, %s\n", each.uri.c_str(), each.product.c_str(), each.in_use ? "in use" : "free");
  }
  return 0;
}

int speed(const std::string& uri) {
  using Clock = std::chrono::steady_clock;
  const auto seconds = [](Clock::time_point since) {
    return std::chrono::duration<double>(Clock::now() - since).count();
  };
  const auto begin = Clock::now();
  Board board = Board::open(uri);
  const double opened = seconds(begin);
  std::vector<double> trips;
  for (int i = 0; i < 400; ++i) {
    const auto start = Clock::now();
    board.rays().poll();
    trips.push_back(1e6 * seconds(start));
  }
  std::ranges::sort(trips);
  constexpr int kLarge = 128;
  const std::vector<std::byte> voxels(std::size_t{kLarge} * kLarge * kLarge, std::byte{100});
  const auto volume = [&voxels] {
    return VolumeView{.samples = voxels, .type = SampleType::kUint8, .dims = {kLarge, kLarge, kLarge}};
  };
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 0.5}}});
  Counters before = board.counters();
  auto start = Clock::now();
  board.load_volume(volume());
  const double load = seconds(start);
  const double down = static_cast<double>((board.counters() - before).value("bus.down.bytes"));
  const auto all = board.dims();
  before = board.counters();
  start = Clock::now();
  board.read_volume({.low = {0, 0, 0}, .size = all});
  const double read = seconds(start);
  const double up = static_cast<double>((board.counters() - before).value("bus.up.bytes"));
  constexpr std::size_t kRays = 20000;
  std::vector<HostRay> rays;
  for (std::uint32_t i = 0; i < kRays; ++i) {
    rays.push_back({.id = i, .position = {1. + i % 120, 1. + i / 120 % 120, 0}, .direction = {0, 0, 1}});
  }
  start = Clock::now();
  board.receive(board.submit(rays));
  const double traced = seconds(start);
  std::printf(
      "open %.1f ms, round trip %.0f us (median of %zu; fastest %.0f), down %.1f MB/s, up %.1f MB/s, %.0f rays/s\n",
      1e3 * opened, trips[trips.size() / 2], trips.size(), trips.front(), down / load / 1e6, up / read / 1e6,
      kRays / traced);
  return 0;
}

// The function as a program sees it that is no driver.
class Raw {
 public:
  explicit Raw(const std::string& address) {
    const std::string folder = "/sys/bus/pci/devices/" + address;
    const int registers = ::open((folder + "/resource0").c_str(), O_RDWR | O_SYNC);
    config_ = ::open((folder + "/config").c_str(), O_RDWR);
    void* const mapped = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, registers, 0);
    void* const page =
        ::mmap(nullptr, kPage, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_HUGETLB | MAP_POPULATE, -1, 0);
    if (mapped == MAP_FAILED || page == MAP_FAILED || config_ < 0) throw std::runtime_error("cannot map the function");
    registers_ = static_cast<volatile std::uint8_t*>(mapped);
    memory_ = static_cast<std::byte*>(page);
    const int pagemap = ::open("/proc/self/pagemap", O_RDONLY);
    std::uint64_t entry = 0;
    if (::pread(pagemap, &entry, 8, static_cast<off_t>(reinterpret_cast<std::uintptr_t>(page) / 4096 * 8)) != 8)
      entry = 0;
    physical_ = (entry & ((std::uint64_t{1} << 55) - 1)) * 4096;
  }

  void write(std::uint32_t offset, std::uint32_t value) {
    *reinterpret_cast<volatile std::uint32_t*>(registers_ + offset) = value;
  }
  std::uint32_t read(std::uint32_t offset) { return *reinterpret_cast<volatile std::uint32_t*>(registers_ + offset); }

  void do_something(std::mt19937_64& random) {
    const auto below = [&random](std::uint64_t bound) { return random() % bound; };
    const std::array<std::uint64_t, 8> values{0, 1, 2, 4096, 0x80000000, 0xFFFFFFFF, random(), physical_};
    const auto value = [&] { return values[below(values.size())]; };
    switch (below(9)) {
      case 0: access(4 * below(16), 4, true, value()); break;
      case 1: access(below(4096), 1u << below(4), false, 0); break;
      case 2: access(below(4096), 1u << below(4), true, value()); break;
      case 3:  // anything into the indices
        for (int i = 0; i < 8; ++i) word(below(6) * 64) = static_cast<std::uint32_t>(value());
        write(fn::kBell, 1);
        break;
      case 4: open(ring_address(random), std::uint32_t{1} << below(32)); break;
      case 5: {  // a good ring, with noise for the board
        std::memset(memory_, 0, 4096);
        open(physical_, 4096u << below(7));
        for (std::uint64_t i = 0; i < 4096; i += 8) std::memcpy(memory_ + 4096 + i, &values[6], 8);
        word(fn::kDownPut) = static_cast<std::uint32_t>(below(8192));
        write(fn::kBell, 1);
        break;
      }
      case 6: {  // the configuration space, but for where its registers are
        const auto at = static_cast<off_t>(below(2) == 0 ? below(13) : 0x14 + below(256 - 0x14));
        const std::uint64_t bytes = value();
        [[maybe_unused]] const auto written = ::pwrite(config_, &bytes, std::size_t{1} << below(3), at);
        break;
      }
      case 7: write(fn::kControl, static_cast<std::uint32_t>(below(3))); break;
      default: ::usleep(static_cast<useconds_t>(below(300))); break;
    }
    enable();
  }

  void open_session() {
    std::memset(memory_, 0, 4096);
    open(physical_, 4096);
  }

  // Memory accesses and bus mastering are on, and the function is not asleep.
  void enable() {
    constexpr std::uint16_t kOn = 6, kAwake = 0;
    if (::pwrite(config_, &kAwake, 2, 0x44) != 2 || ::pwrite(config_, &kOn, 2, 4) != 2)
      throw std::runtime_error("cannot write the configuration space");
  }

 private:
  static constexpr std::size_t kPage = std::size_t{2} << 20;

  std::uint32_t& word(std::uint64_t at) { return *reinterpret_cast<std::uint32_t*>(memory_ + at); }

  // Within this program's memory, beyond the guest's, across its end, not aligned, near the end of all addresses.
  std::uint64_t ring_address(std::mt19937_64& random) const {
    const std::array<std::uint64_t, 7> places{physical_ + kPage - 4096,
                                              std::uint64_t{512} << 20,
                                              (std::uint64_t{512} << 20) - 4096,
                                              physical_ + 64,
                                              ~std::uint64_t{4095},
                                              std::uint64_t{1} << 40 | (random() & ~4095ull),
                                              0xFEBF0000};
    return places[random() % places.size()];
  }
  // Rings that begin in this program's memory must end there: the function may write where the guest tells it to.
  void open(std::uint64_t address, std::uint32_t bytes) {
    const bool ours = address >= physical_ && address < physical_ + kPage;
    if (ours && address + 4096 + 2 * std::uint64_t{bytes} > physical_ + kPage) return;
    write(fn::kRingLow, static_cast<std::uint32_t>(address));
    write(fn::kRingHigh, static_cast<std::uint32_t>(address >> 32));
    write(fn::kRingBytes, bytes);
    write(fn::kControl, fn::kOpenSession);
  }
  void access(std::uint64_t offset, std::uint64_t size, bool writes, std::uint64_t value) {
    volatile std::uint8_t* const at = registers_ + (offset & ~(size - 1));
    const auto go = [&](auto* number) {
      if (writes)
        *number = static_cast<std::remove_volatile_t<std::remove_pointer_t<decltype(number)>>>(value);
      else
        sink_ = sink_ + static_cast<std::uint64_t>(*number);
    };
    // A random write must not give the function memory of others.
    const bool is_ring = writes && offset / 4 * 4 >= fn::kRingLow && offset < fn::kControl + 4;
    if (is_ring) return;
    if (size == 1) go(at);
    if (size == 2) go(reinterpret_cast<volatile std::uint16_t*>(at));
    if (size == 4) go(reinterpret_cast<volatile std::uint32_t*>(at));
    if (size == 8) go(reinterpret_cast<volatile std::uint64_t*>(at));
  }

  int config_ = -1;
  volatile std::uint8_t* registers_ = nullptr;
  std::byte* memory_ = nullptr;
  std::uint64_t physical_ = 0;
  std::uint64_t sink_ = 0;
};

template <typename Trip>
void print_trips(const char* what, int count, const Trip& trip) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> trips;
  for (int i = 0; i < count; ++i) {
    const auto start = Clock::now();
    trip();
    trips.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
  }
  std::ranges::sort(trips);
  std::printf("%s %.1f us (median of %d; fastest %.1f)\n", what, trips[trips.size() / 2], count, trips.front());
}

int doorbell(const std::string& address) {
  constexpr int kCount = 5000;
  if (!address.empty()) {
    Raw raw(address);
    print_trips("doorbell", kCount, [&raw] { raw.write(fn::kBell, 1); });
    print_trips("register read", kCount, [&raw] { raw.read(fn::kState); });
    return 0;
  }
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) throw std::runtime_error("no sockets");
  char byte = 0;
  if (::fork() == 0) {
    ::close(ends[0]);
    while (::read(ends[1], &byte, 1) == 1 && ::write(ends[1], &byte, 1) == 1) {
    }
    ::_exit(0);
  }
  ::close(ends[1]);
  print_trips("socket", kCount, [&] {
    if (::write(ends[0], &byte, 1) != 1 || ::read(ends[0], &byte, 1) != 1) throw std::runtime_error("no answer");
  });
  return 0;
}

// A session that is closed has ended, which raises INTx.
int interrupts(const std::string& address) {
  const int file = ::open("/dev/uio0", O_RDONLY | O_NONBLOCK);
  Raw raw(address);
  int raised = 0, received = 0;
  for (int i = 0; i < 100; ++i) {
    raw.enable();
    raw.open_session();
    raw.write(fn::kInterruptMask, fn::kEnded);
    raw.write(fn::kControl, fn::kCloseSession);
    raised += (raw.read(fn::kInterruptStatus) & fn::kEnded) != 0 ? 1 : 0;
    pollfd waits{file, POLLIN, 0};
    if (::poll(&waits, 1, 20) == 1) ++received;
    std::uint32_t count = 0;
    [[maybe_unused]] const auto got = ::read(file, &count, sizeof count);
    raw.write(fn::kInterruptStatus, fn::kEnded);
  }
  std::printf("%d interrupts raised, %d received\n", raised, received);
  return file < 0 ? 1 : 0;
}

int hostile(const std::string& address, std::uint64_t seed, int count) {
  Raw raw(address);
  std::mt19937_64 random(seed);
  for (int i = 0; i < count; ++i) {
    raw.do_something(random);
    if (raw.read(fn::kIdentity) == fn::kIdentityValue) continue;
    std::printf("the function does not answer after %d things\n", i + 1);
    return 1;
  }
  raw.write(fn::kControl, fn::kCloseSession);
  std::printf("did %d things, and the function answers\n", count);
  return 0;
}

int run(const std::vector<std::string>& words) {
  const std::string command = words.empty() ? "" : words[0];
  if (command == "work" && words.size() == 2) return work_once(words[1]);
  if (command == "hold" && words.size() == 2) return hold(words[1]);
  if (command == "found" && words.size() == 1) return found();
  if (command == "speed" && words.size() == 2) return speed(words[1]);
  if (command == "doorbell" && words.size() <= 2) return doorbell(words.size() == 2 ? words[1] : "");
  if (command == "interrupts" && words.size() == 2) return interrupts(words[1]);
  if (command == "hostile" && words.size() == 4) return hostile(words[1], std::stoull(words[2]), std::stoi(words[3]));
  std::fputs("usage: the head of guest_probe.cpp\n", stderr);
  return 2;
}

}  // namespace
}  // namespace gicube::system_test

int main(int argc, char** argv) {
  try {
    return gicube::system_test::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::printf("error: %s\n", error.what());
    return 1;
  }
}
