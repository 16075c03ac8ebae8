#include "dsp.h"

#include <algorithm>
#include <cstring>
#include <span>

namespace gicube::emu {

namespace {

constexpr std::uint64_t kCodeOfLoop = Dsp::kProgramBytes;  // chosen: the most code that a loop may have

// Loops have different names. A loop from a checkpoint is not at the address of the process's own loop of its name.
bool is_same(const DspLoop* a, const DspLoop* b) {
  return a == b || (a != nullptr && b != nullptr && std::strcmp(a->name, b->name) == 0);
}
std::size_t place_of(const DspLoop* loop, std::span<const DspLoop* const> list) {
  const auto found = std::ranges::find_if(list, [loop](const DspLoop* each) { return is_same(each, loop); });
  return static_cast<std::size_t>(found - list.begin());
}

}  // namespace

Dsp::Dsp(const v1::BoardConfig& config)
    : ideal_(config.ideal().dsp() != 0),
      to_memory_(config.dsp().clock_khz(), config.sdram().clock_khz()),
      to_dsp_(config.sdram().clock_khz(), config.dsp().clock_khz()),
      memory_clocks_(config.sdram().clock_khz() / config.dsp().clock_khz() + 1),
      latency_(config.sdram().controller_latency()),
      memory_(config.sdram(), config.sdram().ranks()),
      sets_(kDataBytes / kLineBytes / kWays) {}

// Returns the cycle in which the data have arrived.
DspCycle Dsp::read(std::uint64_t line, DspCycle at) {
  const dram::Access access = memory_.read(sdram::locate(line * kLineBytes), to_memory_.from(at));
  return to_dsp_.from(access.data_end) + latency_;
}

// Returns the cycle in which the write is in the buffer.
DspCycle Dsp::write(std::uint64_t line, DspCycle at) {
  at = std::max(at, written_[next_write_]);
  const dram::Access access = memory_.write(sdram::locate(line * kLineBytes), to_memory_.from(at));
  written_[next_write_] = to_dsp_.from(access.data_end);
  next_write_ = (next_write_ + 1) % kWrites;
  return at;
}

// Returns the cycle in which the DSP can continue.
DspCycle Dsp::access_line(std::uint64_t line, SdramUse::Kind kind, DspCycle at) {
  auto& set = sets_[line % sets_.size()];
  if (set[0].number != line && set[1].number == line) std::swap(set[0], set[1]);
  if (set[0].number == line) {
    ++counters_.hits;
    set[0].changed |= kind != SdramUse::Kind::kRead;
    return at;
  }
  ++counters_.misses;
  if (kind == SdramUse::Kind::kWrite) return write(line, at);
  if (set[1].changed) at = write(set[1].number, at);
  set[1] = set[0];
  set[0] = {line, kind == SdramUse::Kind::kChange};
  return read(line, at);
}

// Returns the cycle in which the loop's code has arrived.
DspCycle Dsp::fetch(const DspLoop& loop, DspCycle at) {
  const std::uint64_t place = place_of(&loop, linked_);
  if (place == linked_.size()) linked_.push_back(&loop);
  const std::uint64_t first = (sdram_map::kCode + place * kCodeOfLoop) / kLineBytes;
  const std::uint64_t lines = (std::min(loop.code_bytes(), kProgramBytes) + kLineBytes - 1) / kLineBytes;
  DspCycle there = at;
  for (std::uint64_t i = 0; i < lines; ++i) there = read(first + i, at);
  counters_.code += lines * kLineBytes;
  return there;
}

// Returns the cycle in which the loop can start. If the code does not fit, the least recently used loops are evicted.
DspCycle Dsp::begin_loop(const DspLoop& loop, DspCycle at) {
  loop_ = &loop;
  ++counters_.loops;
  const std::size_t cached = place_of(&loop, program_);
  const bool miss = cached == program_.size();
  if (!miss) program_.erase(program_.begin() + static_cast<std::ptrdiff_t>(cached));
  program_.insert(program_.begin(), &loop);
  std::uint32_t bytes = loop.code_bytes();
  const auto fits = [&bytes](const DspLoop* each) { return (bytes += each->code_bytes()) <= kProgramBytes; };
  program_.erase(std::find_if_not(program_.begin() + 1, program_.end(), fits), program_.end());
  return miss ? fetch(loop, at) : at;
}

void Dsp::state(Archive& archive) {
  // The memory's clock may be faster than the DSP's.
  const std::uint64_t most = (std::uint64_t{1} << 54) / memory_clocks_;
  archive.in_clock(std::min(archive.latest(), most) * memory_clocks_, [&] { archive("sdram", memory_); });
  archive("data_cache", sets_);
  std::vector<std::string> names;  // in the order of their code
  std::vector<std::array<std::uint32_t, 3>> costs;
  for (const DspLoop* loop : linked_) {
    names.emplace_back(loop->name);
    costs.push_back({loop->multiplies, loop->operations, loop->accesses});
  }
  archive.texts("loops", names);
  archive.list("loop_costs", costs, names.size());
  if (archive.loads()) {
    archive.expect(costs.size() == names.size(), "loop_costs", std::to_string(names.size()) + " loops", costs.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      NamedLoop& each = named_.emplace_back(names[i]);
      each.loop = {each.name.c_str(), costs[i][0] & 0xFFFF, costs[i][1] & 0xFFFF, costs[i][2] & 0xFFFF};
      linked_.push_back(&each.loop);
    }
  }
  std::vector<std::uint32_t> cached;
  for (const DspLoop* loop : program_) cached.push_back(static_cast<std::uint32_t>(place_of(loop, linked_)));
  auto current = static_cast<std::uint32_t>(place_of(loop_, linked_));
  archive.list("program_cache", cached, linked_.size());
  archive.at_most("loop", current, static_cast<std::uint32_t>(linked_.size()));
  if (archive.loads()) {
    for (const std::uint32_t place : cached) {
      archive.expect(place < linked_.size(), "program_cache", "places of loops", place);
      program_.push_back(linked_[place]);
    }
    loop_ = current < linked_.size() ? linked_[current] : nullptr;
  }
  archive.field("written", [this](Archive::Record& record) { record.times(written_); });
  archive.at_most("next_write", next_write_, kWrites - 1);
  archive.field("waited_until", [this](Archive::Record& record) { record.times(waited_until_); });
  archive("counters", counters_);
}

DspCycle Dsp::work(const DspTask& task, DspCycle begin) {
  if (task.loop == nullptr || ideal_) return begin;
  DspCycle compute = task.cycles(), there = begin;
  if (!is_same(task.loop, loop_)) {
    there = begin_loop(*task.loop, begin);
    compute += task.loop->setup();
  }
  for (std::size_t i = 0; i < task.use_count; ++i) {
    const SdramUse& use = task.uses[i];
    const std::uint64_t first = use.address / kLineBytes, last = (use.address + use.bytes - 1) / kLineBytes;
    for (std::uint64_t line = first; line <= last; ++line) there = access_line(line, use.kind, there);
  }
  waited_until_ = there;
  counters_.compute += compute;
  counters_.waits += there - begin;
  return there + compute;
}

}  // namespace gicube::emu
