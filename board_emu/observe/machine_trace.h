// Writes the activity of processors, links and memories in each cycle to a trace.
//
// Each processor has a track of its active blocks, a track of its pipeline's causes (cause_runs.h) and a counter of
// waiting rays. Counters are sampled every simulated microsecond and written when they change. Only open slices are
// kept in memory.
//
// The power of each part (config/energy.h) is the mean over windows of ten microseconds, of the DSP that over its turn,
// of the host bus that over a transfer. Its integral over all simulated time is the energy that the board counts.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/energy.h"
#include "cycle/machine.h"
#include "cycle/machine_counters.h"
#include "observe/active_queue.h"
#include "observe/cause_runs.h"
#include "observe/trace_file.h"

namespace gicube::emu {

class MachineTrace : public Observer {
 public:
  // Process numbers of the file; processor i is kProcessor + i.
  static constexpr int kLinks = 4, kMemory = 5, kPower = 6, kProcessor = 10;

  // Records the cycles in `window`.
  explicit MachineTrace(TraceFile& file, const CycleWindow& window = {}) : file_(file), window_(window) {}

  // A board of this configuration is at rest from `at` on.
  void power_up(Picoseconds at, const v1::BoardConfig& config) {
    core_khz_ = config.asic().core_khz();
    single_queue_ = config.sorter().queues() == v1::single;
    energy_.emplace(config);
    at_rest_ = energy_->parts({}, kSecond);
    shown_power_.assign(at_rest_.size(), ~std::uint64_t{0});
    if (!at_rest_.empty()) file_.name_process(kPower, "power, mW");
    for (std::size_t i = 0; i < at_rest_.size(); ++i) {
      if (!is_bus(i)) show_rest(i, at);
    }
  }
  // The machine's next run begins at `at`.
  void begin(Picoseconds at) {
    end();
    begin_ps_ = at;
    has_begun_ = false;
  }
  void begins(Cycle now, Machine& machine) override {
    if (has_begun_) return;
    has_begun_ = true;
    begin_cycle_ = power_since_ = now;
    spent_ = energy(machine, now);
  }
  // A turn of the DSP, in which it works for `busy`.
  void served(Picoseconds begin, Picoseconds end, Picoseconds busy) {
    if (at_rest_.empty()) return;
    const auto dsp = static_cast<std::size_t>(std::ranges::find_if(at_rest_, is_dsp) - at_rest_.begin());
    show_mean(at_rest_[dsp].part, begin, end, energy_->dsp_pj(busy, end - begin), shown_power_[dsp]);
    show_rest(dsp, end);
  }
  void transferred(bool is_down, Picoseconds begin, Picoseconds end, std::uint64_t bytes) {
    if (at_rest_.empty()) return;
    std::uint64_t shown = 0;
    const char* const name = is_down ? "host_bus down" : "host_bus up";
    show_mean(name, begin, end, energy_->host_bus_pj(bytes), shown);
    show_power(name, end, 0, shown);
  }
  Cycle next(Cycle from) override { return from < window_.end ? std::max(from, window_.begin) : kNoCycle; }
  void see(Cycle now, const Machine& machine) override {
    if (!seen_) [[unlikely]]
      first_cycle(now, machine);
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      lanes_[i].causes.add(now, machine.processors()[i]->latest(),
                           [this, i](const CauseSlice& s) { write_cause(i, s); });
      follow_active(i, now, machine);
    }
    next_ = now + 1;
    if (next_ >= next_sample_) sample(machine);
    machine_ = &machine;
    if (next_ >= next_power_) end_window(machine);
    if (next_ >= window_.end) end();
  }
  void removed(const Machine& machine) override {
    if (seen_ && next_ > power_since_) end_window(machine);
    machine_ = nullptr;
  }
  // Closes all open slices. To be called after the last cycle of a command.
  void end() {
    if (!seen_) return;
    seen_ = false;
    if (machine_ != nullptr && next_ > power_since_) end_window(*machine_);
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      lanes_[i].causes.finish(next_, [this, i](const CauseSlice& slice) { write_cause(i, slice); });
      close_active(i, next_);
    }
    quiet();
    end_ps_ = time(next_);
  }
  // End of the last recorded cycle, updated by end().
  Picoseconds end_ps() const { return end_ps_; }

 private:
  static constexpr std::uint64_t kKhzPerMhz = 1000;  // cycles in a microsecond
  static constexpr Cycle kPowerWindow = 10;  // microseconds: a count of all events takes as long as some 500 cycles
  static constexpr Picoseconds kSecond = 1'000'000'000'000;
  static constexpr const char* kRaysWaiting = "rays waiting";
  static constexpr const char* kRaysOnLinks = "rays on links";

  static int process_of(std::size_t lane) { return kProcessor + static_cast<int>(lane); }
  static Track active_track(std::size_t lane) { return {process_of(lane), 10 * process_of(lane) + 1}; }
  static Track cause_track(std::size_t lane) { return {process_of(lane), 10 * process_of(lane) + 2}; }

  struct Lane {
    CauseRuns causes;
    ActiveQueue active;
    std::uint32_t queue = 0;  // queue of the open slice
    bool open = false;
    Cycle since = 0;
    std::string block;  // name of its block
    std::uint64_t issued_before = 0;
    std::uint64_t issued = 0;   // rays so far
    std::uint64_t waiting = 0;  // value in the trace
  };
  struct Rate {
    std::string name;
    std::uint64_t count = 0;
    std::uint64_t shown = 0;
  };

  Picoseconds time(Cycle cycle) const { return begin_ps_ + cycles_to_ps(cycle - begin_cycle_, core_khz_); }
  void first_cycle(Cycle now, const Machine& machine) {
    seen_ = true;
    next_sample_ = now + microsecond();
    next_power_ = now + kPowerWindow * microsecond();
    name_tracks(machine);
    if (window_.begin > 0) {
      power_since_ = now;
      spent_ = energy(machine, now);
    }
    lanes_.resize(machine.processors().size());
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      const Sorter& sorter = machine.processors()[i]->sorter();
      lanes_[i].causes.start(now);
      lanes_[i].active = {};
      lanes_[i].active.see(sorter);  // no ray has reached it yet in this command
      lanes_[i].issued = sorter.counters().issued;
    }
    packets_.resize(machine.memories().size());
    for (std::size_t i = 0; i < packets_.size(); ++i) {
      packets_[i].name = fmt::format("{} {} packets/us", machine.memory_standard().label, i);
      packets_[i].count = machine.memories()[i]->channel().counters().packets_read;
    }
  }
  void name_tracks(const Machine& machine) {
    if (named_lanes_ == 0) {
      file_.name_process(kLinks, "links");
      file_.name_process(kMemory, "memory");
    }
    for (; named_lanes_ < machine.processors().size(); ++named_lanes_) {
      file_.name_process(process_of(named_lanes_), fmt::format("processor {}", named_lanes_));
      file_.name_track(active_track(named_lanes_), "active block");
      file_.name_track(cause_track(named_lanes_), "pipeline");
    }
  }
  void follow_active(std::size_t lane, Cycle now, const Machine& machine) {
    const Sorter& sorter = machine.processors()[lane]->sorter();
    Lane& at = lanes_[lane];
    at.active.see(sorter);
    if (at.active.began()) {
      at.open = true;
      at.queue = sorter.latest_active();
      at.since = now;
      at.block = block_name(lane, at.queue, machine);
      at.issued_before = at.issued;
    }
    at.issued = sorter.counters().issued;
    if (at.active.ended()) close_active(lane, now + 1);
  }
  void close_active(std::size_t lane, Cycle end) {
    Lane& at = lanes_[lane];
    if (!at.open) return;
    at.open = false;
    file_.slice(active_track(lane), at.block, time(at.since), time(end),
                fmt::format(R"("queue":{},"rays":{})", at.queue, at.issued - at.issued_before));
  }
  void write_cause(std::size_t lane, const CauseSlice& slice) {
    std::string args;
    for (std::size_t i = 0; i < kCauses; ++i) {
      if (slice.counts[i] == 0) continue;
      fmt::format_to(std::back_inserter(args), R"({}"{}":{})", args.empty() ? "" : ",", kCauseNames[i],
                     slice.counts[i]);
    }
    file_.slice(cause_track(lane), kCauseNames[static_cast<std::size_t>(slice.cause())], time(slice.begin),
                time(slice.end), args);
  }
  std::string block_name(std::size_t lane, std::uint32_t queue, const Machine& machine) const {
    if (single_queue_) return "all blocks";
    const std::size_t block = machine.partition().block(static_cast<unsigned>(lane), queue);
    const auto across = static_cast<std::size_t>(machine.blocks()[0]);
    const auto down = static_cast<std::size_t>(machine.blocks()[1]);
    return fmt::format("block {} {} {}", block % across, block / across % down, block / (across * down));
  }
  // Core cycles per microsecond, at least one.
  Cycle microsecond() const { return std::max<Cycle>(1, core_khz_ / kKhzPerMhz); }
  // Writes the counter if it has changed.
  void show(int process, std::string_view name, Picoseconds at, std::uint64_t value, std::uint64_t& shown) {
    if (value != shown) file_.counter(process, name, at, value);
    shown = value;
  }
  void sample(const Machine& machine) {
    const Picoseconds at = time(next_);
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      show(process_of(i), kRaysWaiting, at, machine.processors()[i]->sorter().waiting(), lanes_[i].waiting);
    }
    show(kLinks, kRaysOnLinks, at, machine.links().inside(), on_links_);
    for (std::size_t i = 0; i < packets_.size(); ++i) {
      Rate& packets = packets_[i];
      const std::uint64_t count = machine.memories()[i]->channel().counters().packets_read;
      // The packets of the past microsecond are shown from its beginning.
      show(kMemory, packets.name, time(next_ - microsecond()), count - packets.count, packets.shown);
      packets.count = count;
    }
    next_sample_ += microsecond();
  }
  static bool is_dsp(const PartEnergy& part) { return std::string_view(part.part) == "dsp"; }
  bool is_bus(std::size_t part) const { return std::string_view(at_rest_[part].part) == "host_bus"; }
  // The parts whose energy follows from the machine's cycles.
  bool is_machines(std::size_t part) const { return !is_dsp(at_rest_[part]) && !is_bus(part); }
  std::vector<PartEnergy> energy(const Machine& machine, Cycle at) const {
    const RayCounters rays = ray_counters(machine);
    std::vector<wire::Counter> counted{{"pipeline.visible_samples", "", rays.visible_samples},
                                       {"pipeline.deposits", "", rays.deposits}};
    count(machine, counted);
    return energy_->parts(counted, time(at) - time(begin_cycle_));
  }
  void show_power(const char* name, Picoseconds at, std::uint64_t microwatts, std::uint64_t& shown) {
    if (microwatts != shown) file_.power(kPower, name, at, microwatts);
    shown = microwatts;
  }
  // The trace has whole nanoseconds.
  void show_mean(const char* name, Picoseconds begin, Picoseconds end, std::uint64_t pj, std::uint64_t& shown) {
    const std::uint64_t ns = std::max<std::uint64_t>(end / 1000 - begin / 1000, 1);
    show_power(name, begin, (pj * 1000 + ns / 2) / ns, shown);
  }
  void show_rest(std::size_t part, Picoseconds at) {
    show_power(at_rest_[part].part, at, (at_rest_[part].pj + 500'000) / 1'000'000, shown_power_[part]);
  }
  // The window's power is shown from its beginning.
  void end_window(const Machine& machine) {
    std::vector<PartEnergy> now = energy(machine, next_);
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (!is_machines(i)) continue;
      show_mean(now[i].part, time(power_since_), time(next_), now[i].pj - spent_[i].pj, shown_power_[i]);
    }
    spent_ = std::move(now);
    power_since_ = next_;
    next_power_ += kPowerWindow * microsecond();
  }
  // Sets the counters to 0, because nothing waits or moves between commands, and power to that of rest.
  void quiet() {
    const Picoseconds at = time(next_);
    for (std::size_t i = 0; i < at_rest_.size(); ++i) {
      if (is_machines(i)) show_rest(i, at);
    }
    for (std::size_t i = 0; i < lanes_.size(); ++i) show(process_of(i), kRaysWaiting, at, 0, lanes_[i].waiting);
    show(kLinks, kRaysOnLinks, at, 0, on_links_);
    for (Rate& packets : packets_) show(kMemory, packets.name, at, 0, packets.shown);
  }

  TraceFile& file_;
  const CycleWindow window_;
  Picoseconds begin_ps_ = 0;
  Picoseconds end_ps_ = 0;
  std::uint64_t core_khz_ = 1;
  bool single_queue_ = false;
  Cycle begin_cycle_ = 0;
  Cycle next_ = 0;  // after the latest recorded cycle
  Cycle next_sample_ = 0;
  bool has_begun_ = false;  // a run has begun since begin()
  bool seen_ = false;       // a cycle was recorded since begin()
  std::vector<Lane> lanes_;
  std::vector<Rate> packets_;  // by memory
  std::uint64_t on_links_ = 0;
  std::optional<EnergyModel> energy_;
  std::vector<PartEnergy> at_rest_;         // in a second; empty at the functional level
  std::vector<PartEnergy> spent_;           // at the window's begin
  std::vector<std::uint64_t> shown_power_;  // microwatts
  const Machine* machine_ = nullptr;        // whose cycles are recorded; null once it was removed
  Cycle power_since_ = 0, next_power_ = 0;
  std::size_t named_lanes_ = 0;
};

}  // namespace gicube::emu
