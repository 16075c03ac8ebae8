// Simulated time.
#include <algorithm>
#include <thread>

#include "gicube/wire/pci_config.h"
#include "tools/conformance/host.h"
#include "tools/conformance/scene.h"
#include "tools/conformance/traced.h"

namespace gicube::conformance {
namespace {

// The bus of P810 and P811.
struct Bus {
  std::uint64_t clock_ps = 30'000;
  std::uint64_t rate = 0;  // dwords a clock of an AGP read; 0: PCI

  explicit Bus(Host& host) {
    namespace pci = wire::pci;
    if ((host.read_config(pci::kPowerManagement) >> 8 & 0xFF) != pci::kAgp) return;
    clock_ps = 15'000;
    rate = ((host.read_config(pci::kAgp + 4) & 7) + 1) / 2;
  }
  static std::uint64_t bursts(std::uint64_t bytes, std::uint64_t longest, auto clocks) {
    std::uint64_t sum = 0;
    for (std::uint64_t left = (bytes + 3) / 4; left > 0;) {
      const std::uint64_t n = std::min(left, longest);
      sum += clocks(n);
      left -= n;
    }
    return sum;
  }
  static std::uint64_t written(std::uint64_t n) { return n + 3; }
  std::uint64_t down(std::uint64_t bytes) const {
    if (rate == 0) return clock_ps * bursts(bytes, 256, written);
    return clock_ps * bursts(bytes, 64, [this](std::uint64_t n) { return (n + rate - 1) / rate + 2; });
  }
  std::uint64_t up(std::uint64_t bytes) const { return clock_ps * bursts(bytes, 256, written); }
  std::uint64_t access() const { return clock_ps * 12; }
};

Volume fog(Host& host) { return fog(host, {9, 9, 9}, 3000); }

Bytes one_ray() { return trace_command({.type = wire::RayType::kIntegrate}, {host_ray(1, {4, 4, 4}, {0, 0, 1})}); }

Bytes picture(const Volume& volume, int size = 16) {
  return wire::encoded(along(2, true, volume, size, size, 8.0 / size));
}

constexpr Case kCases[] = {
    {3, "time.access", "P810",
     [](Host& host) {
       const Bus bus(host);
       for (const auto& [type, payload] : {std::pair{FrameType::kRegisterRead, words({reg::kId})},
                                           {FrameType::kConfigRead, words({0})},
                                           {FrameType::kConfigWrite, words({0x3C, 1})},
                                           {FrameType::kCancel, words({9})}}) {
         check_same("ps of an access", host.time_of([&] { host.request(type, payload); }), bus.access());
       }
     }},
    {3, "time.writes", "P810",
     [](Host& host) {
       const Bus bus(host);
       for (const std::size_t bytes : {4u, 5u, 256u, 1024u, 1028u, 10'000u}) {
         const std::uint64_t time = host.time_of([&] {
           const std::uint64_t before = host.now;
           host.write_memory(wire::kReflectanceMap.base, Bytes(bytes));
           check_same("the host's clock after a posted write", host.now, before);
           host.read_register(reg::kId);
         });
         check_same("ps of a memory write and a register read", time, bus.down(bytes) + bus.access());
       }
     }},
    {3, "time.register_write", "P810",
     [](Host& host) {
       const Bus bus(host);
       const std::uint64_t time = host.time_of([&] {
         for (int i = 0; i < 3; ++i) host.write_register(reg::kSeed, 1);
         host.read_register(reg::kId);
       });
       check_same("ps of three register writes and a read", time, 3 * 4 * bus.clock_ps + bus.access());
     }},
    {3, "time.reads", "P811",
     [](Host& host) {
       const Bus bus(host);
       for (const std::uint64_t bytes : {4u, 1024u, 1025u, 9000u}) {
         const Bytes read = long_words({wire::kReflectanceMap.base, bytes});
         const std::uint64_t time = host.time_of([&] { host.request(FrameType::kMemoryRead, read); });
         check_same("ps of a memory read", time, 7 * bus.clock_ps + bus.up(bytes));
       }
     }},
    {3, "time.free", "P805",
     [](Host& host) {
       const std::uint64_t time = host.time_of([&] {
         host.request(FrameType::kPoll, {});
         host.request(FrameType::kCounters, {});
       });
       check_same("ps of kPoll and kCounters", time, 0);
     }},
    {3, "time.thinks", "P801",
     [](Host& host) {
       const Bus bus(host);
       host.read_register(reg::kId);
       host.now += 123'456'789;
       const std::uint64_t asked = host.now;
       host.read_register(reg::kId);
       check_same("the answer's time", host.now, asked + bus.access());
     }},
    {3, "time.wall_clock", "P813",
     [](Place& place) {
       std::vector<std::uint64_t> runs[2];
       for (int slow = 0; slow < 2; ++slow) {
         Host host(place);
         const auto pause = [slow] {
           if (slow != 0) std::this_thread::sleep_for(std::chrono::milliseconds(40));
         };
         const Volume volume = fog(host);
         pause();
         const std::uint32_t first = host.command(picture(volume)), second = host.command(picture(volume, 24));
         pause();
         runs[slow].push_back(host.completion(second).header.time_ps);
         runs[slow].push_back(host.completion(first).header.time_ps);
         pause();
         host.read_memory(wire::kFramebuffer.base, 100);
         runs[slow].push_back(host.now);
       }
       check(runs[0] == runs[1], "expected the same times, got {} and {} ps at the end", runs[0].back(),
             runs[1].back());
     }},
    {3, "time.commands", "P808",
     [](Host& host) {
       const Volume volume = fog(host);
       host.command(picture(volume, 64));
       const std::uint64_t before = host.now;
       host.request(FrameType::kMemoryRead, long_words({wire::kFramebuffer.base, 64}));
       check_same("completions before the bytes", host.completions.size(), 1);
       check(host.completions[0].header.time_ps > before && host.completions[0].header.time_ps <= host.now,
             "expected the command to complete within the read's time");
     }},
    {3, "time.serial", "P814",
     [](Host& host) {
       const Volume volume = fog(host);
       const std::uint64_t alone = host.time_of([&] { host.run(picture(volume, 48)); });
       const std::uint64_t both = host.time_of([&] {
         host.command(picture(volume, 48));
         host.run(picture(volume, 48));
       });
       check(both > alone + alone / 2, "expected two commands to take longer than one with {} ps, got {}", alone, both);
     }},
    {3, "time.deadline", "P407",
     [](Host& host) {
       const Volume volume = fog(host);
       host.read_register(reg::kId);
       const std::uint32_t ticket = host.command(picture(volume, 64));
       const std::uint64_t deadline = host.now + 1'000'000;
       Bytes wait(12);
       wire::store(std::span(wait), 0, ticket);
       wire::store(std::span(wait), 4, deadline);
       const RawFrame late = host.refused_request(FrameType::kWait, wait, ErrorCode::kDeadline);
       check_same("its time", late.header.time_ps, deadline);
       const RawFrame done = host.completion(ticket);
       check(done.header.error == ErrorCode::kNone && done.header.time_ps > deadline,
             "expected the command to complete later");
     }},
    {3, "time.cancel", "P408",
     [](Host& host) {
       const Volume volume = fog(host);
       host.read_register(reg::kId);
       const std::uint32_t first = host.command(picture(volume, 200));
       const std::uint32_t second = host.command(one_ray());
       check(host.request(FrameType::kCancel, words({second})) == words({1}), "expected 1 for a trace that waits");
       check(host.request(FrameType::kCancel, words({first})) == words({0}), "expected 0 for a rendering");
       const RawFrame cancelled = host.completion(second);
       check_same("the error", cancelled.header.error, ErrorCode::kCancelled);
       check(cancelled.header.time_ps >= host.completion(first).header.time_ps, "expected it after the rendering");
     }},
    {3, "time.too_late", "P409",
     [](Host& host) {
       fog(host);
       const std::uint32_t ticket = host.command(one_ray());
       check_same("the error", host.completion(ticket).header.error, ErrorCode::kNone);
       check(host.request(FrameType::kCancel, words({ticket})) == words({0}),
             "expected 0 for a trace that has completed");
     }},
    {3, "time.counters", "P815",
     [](Host& host) {
       const std::uint64_t down = host.counter("bus.down.bytes"), up = host.counter("bus.up.bytes");
       host.write_memory(wire::kReflectanceMap.base, Bytes(1000));
       host.request(FrameType::kMemoryRead, long_words({wire::kReflectanceMap.base, 2000}));
       check_same("bytes down", host.counter("bus.down.bytes") - down, 1016u);
       check_same("bytes up", host.counter("bus.up.bytes") - up, 2000u);
     }},
    {3, "time.rays", "P815",
     [](Host& host) {
       const Volume volume = fog(host);
       host.read_register(reg::kId);
       const std::uint64_t rays = host.counter("dsp.viewing_rays"), down = host.counter("bus.down.bytes"),
                           up = host.counter("bus.up.bytes");
       host.completion(host.command(picture(volume, 20)));
       check_same("viewing rays", host.counter("dsp.viewing_rays") - rays, 400u);
       check_same("bytes of a command", host.counter("bus.down.bytes") - down, wire::kRenderCommandBytes);
       check_same("bytes of a completion", host.counter("bus.up.bytes") - up, 4u);
     }},
};

}  // namespace

std::span<const Case> time_cases() { return kCases; }

}  // namespace gicube::conformance
