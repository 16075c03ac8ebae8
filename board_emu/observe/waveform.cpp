#include "observe/waveform.h"

#include <fmt/format.h>

#include <iterator>
#include <optional>

namespace gicube::emu {

namespace {

constexpr unsigned kCauseBits = 4, kCountBits = 32, kFifoBits = 8;
static_assert(kCauses <= 1u << kCauseBits);
constexpr std::uint64_t kPicosecondsPerKhz = 1'000'000'000;  // period of 1 kHz

// The signals of a part, in the order in which they are declared and set.
using Value = std::optional<std::uint64_t>;
template <typename Part>
struct Signal {
  const char* name;
  unsigned bits;
  Value (*value)(const Part& part);
};

struct SeenBoard {
  const Machine& machine;
  Cycle now;
  bool bus_moved;
};
constexpr Signal<SeenBoard> kBoardSignals[] = {
    {"dsp_busy", 1, [](const SeenBoard& b) -> Value { return b.machine.dsp().busy(b.now) ? 1 : 0; }},
    {"ray_bus_busy", 1, [](const SeenBoard& b) -> Value { return b.bus_moved ? 1 : 0; }},
    {"fifo_down", kFifoBits, [](const SeenBoard& b) -> Value { return b.machine.down().size(); }},
    {"fifo_runs", kFifoBits, [](const SeenBoard& b) -> Value { return b.machine.runs().size(); }},
    {"fifo_up", kFifoBits, [](const SeenBoard& b) -> Value { return b.machine.up().size(); }},
    {"link_rays", kCountBits, [](const SeenBoard& b) -> Value { return b.machine.links().inside(); }}};

struct SeenProcessor {
  const Processor& part;
  const ActiveQueue& active;
};
constexpr Signal<SeenProcessor> kProcessorSignals[] = {
    {"cause", kCauseBits, [](const SeenProcessor& p) -> Value { return static_cast<std::uint64_t>(p.part.latest()); }},
    {"active_queue", kCountBits, [](const SeenProcessor& p) -> Value { return p.active.queue(); }},
    {"rays_waiting", kCountBits, [](const SeenProcessor& p) -> Value { return p.part.sorter().waiting(); }},
    {"prefetch", kCountBits, [](const SeenProcessor& p) -> Value { return p.part.stages().prefetching(); }},
    {"compute", kCountBits, [](const SeenProcessor& p) -> Value { return p.part.stages().computing(); }},
    {"packets_under_way", kCountBits, [](const SeenProcessor& p) -> Value { return p.part.misses().size(); }},
    {"fifo_from_bus", kFifoBits, [](const SeenProcessor& p) -> Value { return p.part.from_bus.size(); }},
    {"fifo_from_left", kFifoBits, [](const SeenProcessor& p) -> Value { return p.part.from_left.size(); }},
    {"fifo_from_right", kFifoBits, [](const SeenProcessor& p) -> Value { return p.part.from_right.size(); }},
    {"fifo_out_links", kFifoBits, [](const SeenProcessor& p) -> Value { return p.part.out_links.size(); }},
    {"fifo_done", kFifoBits, [](const SeenProcessor& p) -> Value { return p.part.done.size(); }},
    {"fifo_overflow", kFifoBits, [](const SeenProcessor& p) -> Value { return p.part.overflow.size(); }}};

}  // namespace

Waveform::~Waveform() {
  end_machine();
  if (state_ != State::kWaiting) return;
  vcd_.comment(fmt::format("no machine came to core cycle {}", window_.begin));
  vcd_.timescale(0);
  vcd_.begin(0);
  vcd_.end(0);
}

void Waveform::begin(Cycle now, const Machine& machine) {
  std::string causes;
  for (std::size_t i = 0; i < kCauses; ++i) {
    fmt::format_to(std::back_inserter(causes), "{}{} {}", i > 0 ? ", " : "", i, kCauseNames[i]);
  }
  vcd_.comment("cause: " + causes);
  int exponent = 0;
  unit_ps_ = 1;
  if (kPicosecondsPerKhz % core_khz_ == 0) {
    const std::uint64_t period_ps = kPicosecondsPerKhz / core_khz_;
    for (; period_ps % (unit_ps_ * 10) == 0; unit_ps_ *= 10) ++exponent;
  }
  vcd_.timescale(exponent);
  vcd_.open_scope("board");
  for (const auto& signal : kBoardSignals) vcd_.declare(signal.name, signal.bits);
  for (std::size_t i = 0; i < machine.processors().size(); ++i) {
    vcd_.open_scope(fmt::format("processor{}", i));
    for (const auto& signal : kProcessorSignals) vcd_.declare(signal.name, signal.bits);
    vcd_.close_scope();
  }
  vcd_.close_scope();
  vcd_.begin(time(now));
  state_ = State::kWriting;
}

void Waveform::record(Cycle now, const Machine& machine) {
  if (state_ == State::kWriting && now != next_) return end_machine();  // another machine
  const bool bus_moved = machine.ray_bus().counters().busy != bus_cycles_;
  bus_cycles_ = machine.ray_bus().counters().busy;
  active_.resize(machine.processors().size());
  for (std::size_t i = 0; i < active_.size(); ++i) active_[i].see(machine.processors()[i]->sorter());
  if (now < window_.begin) return;  // this cycle only gives the state before the window
  if (state_ == State::kWaiting) begin(now, machine);
  vcd_.time(time(now));
  VcdFile::Signal next{};
  for (const auto& signal : kBoardSignals) vcd_.set(next++, signal.value({machine, now, bus_moved}));
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const SeenProcessor seen{*machine.processors()[i], active_[i]};
    for (const auto& signal : kProcessorSignals) vcd_.set(next++, signal.value(seen));
  }
  next_ = now + 1;
  if (next_ >= window_.end) end_machine();
}

}  // namespace gicube::emu
