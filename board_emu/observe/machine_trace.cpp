#include "observe/machine_trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>

namespace gicube::emu {

namespace {

constexpr std::uint64_t kKhzPerMhz = 1000;  // cycles in a microsecond

Track active_track(std::size_t lane) {
  const int process = MachineTrace::kProcessor + static_cast<int>(lane);
  return {process, 10 * process + 1};
}
Track cause_track(std::size_t lane) {
  const int process = MachineTrace::kProcessor + static_cast<int>(lane);
  return {process, 10 * process + 2};
}

constexpr const char* kRaysWaiting = "rays waiting";
constexpr const char* kRaysOnLinks = "rays on links";

}  // namespace

void MachineTrace::begin(Picoseconds at, const v1::BoardConfig& config) {
  end();
  begin_ps_ = at;
  core_khz_ = config.asic().core_khz();
  single_queue_ = config.sorter().queues() == v1::single;
  memory_label_ = memory_standard(config).label;
}

std::string MachineTrace::memory_counter(std::size_t memory) const {
  return fmt::format("{} {} packets/us", memory_label_, memory);
}

// In core cycles, at least one.
Cycle MachineTrace::microsecond() const { return std::max<Cycle>(1, core_khz_ / kKhzPerMhz); }

void MachineTrace::name_tracks(const Machine& machine) {
  if (named_lanes_ == 0) {
    file_.name_process(kLinks, "links");
    file_.name_process(kMemory, "memory");
  }
  for (; named_lanes_ < machine.processors().size(); ++named_lanes_) {
    file_.name_process(kProcessor + static_cast<int>(named_lanes_), fmt::format("processor {}", named_lanes_));
    file_.name_track(active_track(named_lanes_), "active block");
    file_.name_track(cause_track(named_lanes_), "pipeline");
  }
}

void MachineTrace::first_cycle(Cycle now, const Machine& machine) {
  seen_ = true;
  begin_cycle_ = now;
  next_sample_ = now + microsecond();
  name_tracks(machine);
  lanes_.resize(machine.processors().size());
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    const Sorter& sorter = machine.processors()[i]->sorter();
    lanes_[i].causes.start(now);
    lanes_[i].active = {};
    lanes_[i].active.see(sorter);  // no ray has come to it yet in this command
    lanes_[i].issued = sorter.counters().issued;
  }
  packets_.resize(machine.memories().size());
  for (std::size_t i = 0; i < packets_.size(); ++i) {
    packets_[i].count = machine.memories()[i]->channel().counters().packets_read;
  }
}

void MachineTrace::see(Cycle now, const Machine& machine) {
  if (!seen_) [[unlikely]]
    first_cycle(now, machine);
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    lanes_[i].causes.add(now, machine.processors()[i]->latest(), [this, i](const CauseSlice& s) { write_cause(i, s); });
    follow_active(i, now, machine);
  }
  next_ = now + 1;
  if (next_ >= next_sample_) sample(machine);
}

void MachineTrace::write_cause(std::size_t lane, const CauseSlice& slice) {
  std::string args;
  for (std::size_t i = 0; i < kCauses; ++i) {
    if (slice.counts[i] == 0) continue;
    fmt::format_to(std::back_inserter(args), R"({}"{}":{})", args.empty() ? "" : ",", kCauseNames[i], slice.counts[i]);
  }
  file_.slice(cause_track(lane), kCauseNames[static_cast<std::size_t>(slice.cause())], time(slice.begin),
              time(slice.end), args);
}

std::string MachineTrace::block_name(std::size_t lane, std::uint32_t queue, const Machine& machine) const {
  if (single_queue_) return "all blocks";
  const std::size_t block = machine.partition().block(static_cast<unsigned>(lane), queue);
  const auto across = static_cast<std::size_t>(machine.blocks()[0]);
  const auto down = static_cast<std::size_t>(machine.blocks()[1]);
  return fmt::format("block {} {} {}", block % across, block / across % down, block / (across * down));
}

void MachineTrace::follow_active(std::size_t lane, Cycle now, const Machine& machine) {
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

void MachineTrace::close_active(std::size_t lane, Cycle end) {
  Lane& at = lanes_[lane];
  if (!at.open) return;
  at.open = false;
  file_.slice(active_track(lane), at.block, time(at.since), time(end),
              fmt::format(R"("queue":{},"rays":{})", at.queue, at.issued - at.issued_before));
}

void MachineTrace::sample(const Machine& machine) {
  const Picoseconds at = time(next_);
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    const std::uint64_t waiting = machine.processors()[i]->sorter().waiting();
    if (waiting == lanes_[i].waiting) continue;
    file_.counter(kProcessor + static_cast<int>(i), kRaysWaiting, at, waiting);
    lanes_[i].waiting = waiting;
  }
  if (machine.links().inside() != on_links_) {
    on_links_ = machine.links().inside();
    file_.counter(kLinks, kRaysOnLinks, at, on_links_);
  }
  for (std::size_t i = 0; i < packets_.size(); ++i) {
    const std::uint64_t count = machine.memories()[i]->channel().counters().packets_read;
    if (count - packets_[i].count != packets_[i].shown) {
      packets_[i].shown = count - packets_[i].count;
      // What came in the microsecond is shown over it.
      file_.counter(kMemory, memory_counter(i), time(next_ - microsecond()), packets_[i].shown);
    }
    packets_[i].count = count;
  }
  next_sample_ += microsecond();
}

// Between commands nothing waits and nothing moves.
void MachineTrace::quiet() {
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    if (lanes_[i].waiting != 0) file_.counter(kProcessor + static_cast<int>(i), kRaysWaiting, time(next_), 0);
    lanes_[i].waiting = 0;
  }
  if (on_links_ != 0) file_.counter(kLinks, kRaysOnLinks, time(next_), 0);
  on_links_ = 0;
  for (std::size_t i = 0; i < packets_.size(); ++i) {
    if (packets_[i].shown != 0) file_.counter(kMemory, memory_counter(i), time(next_), 0);
    packets_[i].shown = 0;
  }
}

void MachineTrace::end() {
  if (!seen_) return;
  seen_ = false;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    lanes_[i].causes.finish(next_, [this, i](const CauseSlice& slice) { write_cause(i, slice); });
    close_active(i, next_);
  }
  quiet();
  end_ps_ = time(next_);
}

}  // namespace gicube::emu
