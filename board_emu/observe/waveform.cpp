#include "observe/waveform.h"

#include <fmt/format.h>

#include <iterator>
#include <optional>

namespace gicube::emu {

namespace {

constexpr unsigned kCauseBits = 4, kCountBits = 32, kFifoBits = 8;
static_assert(kCauses <= 1u << kCauseBits);
constexpr std::uint64_t kPicosecondsPerKhz = 1'000'000'000;  // of a 1 kHz period

}  // namespace

Waveform::~Waveform() {
  end_machine();
  if (state_ != State::kWaiting) return;
  vcd_.comment(fmt::format("no machine came to core cycle {}", window_.begin));
  vcd_.timescale(0);
  vcd_.begin(0);
  vcd_.end(0);
}

void Waveform::end_machine() {
  if (state_ != State::kWriting) return;
  vcd_.end(time(next_));
  state_ = State::kEnded;
}

// A clock whose period is a whole number of picoseconds has times without rounding, in the coarsest unit that fits.
std::uint64_t Waveform::time(Cycle cycle) const { return cycles_to_ps(cycle, core_khz_) / unit_ps_; }

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
  declare(machine.processors().size());
  vcd_.begin(time(now));
  state_ = State::kWriting;
}

void Waveform::declare(std::size_t processors) {
  vcd_.open_scope("board");
  board_ = {.dsp_busy = vcd_.declare("dsp_busy", 1),
            .ray_bus_busy = vcd_.declare("ray_bus_busy", 1),
            .down = vcd_.declare("fifo_down", kFifoBits),
            .runs = vcd_.declare("fifo_runs", kFifoBits),
            .up = vcd_.declare("fifo_up", kFifoBits),
            .link_rays = vcd_.declare("link_rays", kCountBits)};
  for (std::size_t i = 0; i < processors; ++i) {
    vcd_.open_scope(fmt::format("processor{}", i));
    processors_.push_back({.cause = vcd_.declare("cause", kCauseBits),
                           .active_queue = vcd_.declare("active_queue", kCountBits),
                           .rays_waiting = vcd_.declare("rays_waiting", kCountBits),
                           .prefetch = vcd_.declare("prefetch", kCountBits),
                           .compute = vcd_.declare("compute", kCountBits),
                           .packets = vcd_.declare("packets_under_way", kCountBits),
                           .from_bus = vcd_.declare("fifo_from_bus", kFifoBits),
                           .from_left = vcd_.declare("fifo_from_left", kFifoBits),
                           .from_right = vcd_.declare("fifo_from_right", kFifoBits),
                           .out_links = vcd_.declare("fifo_out_links", kFifoBits),
                           .done = vcd_.declare("fifo_done", kFifoBits),
                           .overflow = vcd_.declare("fifo_overflow", kFifoBits)});
    vcd_.close_scope();
  }
  vcd_.close_scope();
}

void Waveform::set(std::size_t number, const Processor& processor) {
  const ProcessorSignals& signals = processors_[number];
  const Sorter& sorter = processor.sorter();
  vcd_.set(signals.cause, static_cast<std::uint64_t>(processor.latest()));
  vcd_.set(signals.active_queue, active_[number].queue());
  vcd_.set(signals.rays_waiting, sorter.waiting());
  vcd_.set(signals.prefetch, processor.stages().prefetching());
  vcd_.set(signals.compute, processor.stages().computing());
  vcd_.set(signals.packets, processor.misses().size());
  vcd_.set(signals.from_bus, processor.from_bus.size());
  vcd_.set(signals.from_left, processor.from_left.size());
  vcd_.set(signals.from_right, processor.from_right.size());
  vcd_.set(signals.out_links, processor.out_links.size());
  vcd_.set(signals.done, processor.done.size());
  vcd_.set(signals.overflow, processor.overflow.size());
}

void Waveform::record(Cycle now, const Machine& machine) {
  if (state_ == State::kWriting && now != next_) return end_machine();  // this is another machine
  const bool bus_moved = machine.ray_bus().counters().busy != bus_cycles_;
  bus_cycles_ = machine.ray_bus().counters().busy;
  active_.resize(machine.processors().size());
  for (std::size_t i = 0; i < active_.size(); ++i) active_[i].see(machine.processors()[i]->sorter());
  if (now < window_.begin) return;  // only to know what was before
  if (state_ == State::kWaiting) begin(now, machine);
  vcd_.time(time(now));
  vcd_.set(board_.dsp_busy, machine.dsp().busy(now) ? 1 : 0);
  vcd_.set(board_.ray_bus_busy, bus_moved ? 1 : 0);
  vcd_.set(board_.down, machine.down().size());
  vcd_.set(board_.runs, machine.runs().size());
  vcd_.set(board_.up, machine.up().size());
  vcd_.set(board_.link_rays, machine.links().inside());
  for (std::size_t i = 0; i < processors_.size(); ++i) set(i, *machine.processors()[i]);
  next_ = now + 1;
  if (next_ >= window_.end) end_machine();
}

}  // namespace gicube::emu
