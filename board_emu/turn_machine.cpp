#include "turn_machine.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace gicube::emu {

namespace {

constexpr Cycle kSlack = 64;            // chosen: cycles by which a part may run ahead of the next
constexpr Cycle kToProcessor = 3;       // from the DSP over the ray bus into a sorter
constexpr std::size_t kOnTheWay = 4;    // rays between the DSP and one sorter before they hold the bus up
constexpr std::size_t kChunk = 65'536;  // chosen: rays whose values are worked out at a time

}  // namespace

TurnMachine::TurnMachine(const v1::BoardConfig& config, const std::array<int, 3>& blocks)
    : config_(config),
      blocks_(blocks),
      partition_(config.asic().partition(), config.asic().processors(), blocks),
      ratio_(static_cast<double>(config.asic().core_khz()) / config.dsp().clock_khz()) {
  const auto most = static_cast<std::uint32_t>(std::max<std::size_t>(1, partition_.most_blocks()));
  for (std::uint32_t i = 0; i < config_.asic().processors(); ++i) {
    memories_.push_back(std::make_unique<TurnMemory>(config_, most));
    const TurnProcessor::Surroundings with{&config_, &partition_, blocks_, &processors_, memories_.back().get(), &up_};
    processors_.push_back(std::make_unique<TurnProcessor>(static_cast<std::uint8_t>(i), with));
  }
}

void TurnMachine::invalidate_caches() {
  for (const auto& processor : processors_) processor->invalidate_cache();
}

// It begins one thing a core cycle at most.
void TurnMachine::dsp_works(std::uint64_t cycles) {
  dsp_.now += std::max(static_cast<double>(cycles) * ratio_, 1.0);
  dsp_.busy += cycles;
}

void TurnMachine::send(const TurnRay& ray) {
  const Home& home = partition_.home(ray.block);
  const auto ready = static_cast<Cycle>(std::ceil(dsp_.now)) + kToProcessor;
  bus_.push({home.processor, {ray, ready, home.number, false, false}});
  ++dsp_.sent;
  run_bus();
}

// Hands rays on in their order.
void TurnMachine::run_bus() {
  while (!bus_.empty()) {
    TurnProcessor& to = *processors_[bus_.front().processor];
    if (to.holds_bus() && to.from_bus() >= kOnTheWay) {
      held_ = true;
      return;
    }
    if (std::exchange(held_, false)) bus_free_ = std::max(bus_free_, to.taken_from_bus());
    to.send(TurnProcessor::From::kBus, bus_.pop().ray);
  }
}

TurnRay& TurnMachine::next_made(TurnWork& work) {
  if (dsp_.made == chunk_begin_ + chunk_.size()) {
    chunk_begin_ = dsp_.made;
    chunk_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kChunk, count_ - dsp_.made)));
    work.make(chunk_begin_, chunk_);
  }
  return chunk_[static_cast<std::size_t>(dsp_.made++ - chunk_begin_)];
}

// One ray, or a run of them.
void TurnMachine::make_rays(TurnWork& work) {
  const std::uint64_t run = config_.dsp().run_rays(), row = work.row_end(dsp_.made);
  const bool in_run = run > 1 && row > dsp_.made + 1;
  const std::uint64_t last = in_run ? std::min(row, dsp_.made + run) : dsp_.made + 1;
  dsp_works(in_run ? config_.dsp().run_cycles() : work.make_cycles());
  while (dsp_.made < last) {
    TurnRay& ray = next_made(work);
    if (ray.left <= 0) continue;
    ray.block = static_cast<std::uint32_t>(grid_.block(ray.position));
    send(ray);
  }
}

// What comes back goes first, then new rays, then overflowed ones. False if there is nothing to be done yet.
bool TurnMachine::dsp_acts(TurnWork& work) {
  const std::uint32_t overflow = config_.dsp().overflow_ray_cycles();
  if (!up_.empty() && static_cast<double>(up_.front().ready) <= dsp_.now) {
    const Coming back = up_.pop();
    if (back.overflowed) {
      dsp_works(overflow / 2);
      ++dsp_.overflows;
      dsp_.kept.push_back(back.ray);
    } else {
      dsp_works(work.take_cycles());
      ++dsp_.taken;
    }
    return true;
  }
  if (!bus_.empty() || (dsp_.made == count_ && dsp_.kept.empty())) return false;
  dsp_.now = std::max(dsp_.now, static_cast<double>(bus_free_));
  if (dsp_.made < count_) {
    make_rays(work);
  } else {
    dsp_works(overflow - overflow / 2);
    send(dsp_.kept.front());
    dsp_.kept.pop_front();
  }
  return true;
}

Ran TurnMachine::run(TurnWork& work, const Frame& frame, Work& progress) {
  const Cycle begin = now_;
  const std::uint64_t busy = dsp_.busy, taken = dsp_.taken;
  count_ = work.count();
  chunk_.clear();
  chunk_begin_ = dsp_.made = 0;
  dsp_.now = static_cast<double>(now_);
  grid_ = BlockGrid(*frame.volume);
  for (const auto& processor : processors_) processor->begin(now_, frame);
  progress.all = static_cast<std::uint32_t>(count_);
  while (true) {
    TurnProcessor* behind = nullptr;
    Cycle least = kNoCycle, second = kNoCycle;
    for (const auto& processor : processors_) {
      const Cycle next = processor->next();
      second = std::min(second, std::max(least, next));
      if (next < least) {
        least = next;
        behind = processor.get();
      }
    }
    // While the DSP is not behind the processors it has seen all that comes.
    if (static_cast<double>(least) >= dsp_.now) {
      if (dsp_acts(work)) continue;
      if (!up_.empty() && up_.front().ready <= least) {
        dsp_.now = std::max(dsp_.now, static_cast<double>(up_.front().ready));
        continue;
      }
      if (behind == nullptr) break;
    }
    const bool dsp_has_work = dsp_.made < count_ || !dsp_.kept.empty();
    Cycle until = second == kNoCycle ? least + 16 * kSlack : second + kSlack;
    if (dsp_has_work) until = std::min(until, std::max(least, static_cast<Cycle>(dsp_.now)) + kSlack);
    behind->work(std::max(until, least), !bus_.empty() && processors_[bus_.front().processor].get() == behind);
    run_bus();
    progress.done = static_cast<std::uint32_t>(dsp_.taken - taken);
    if (progress.cancel) return {now_ - begin, dsp_.busy - busy, true};
  }
  now_ = static_cast<Cycle>(std::ceil(dsp_.now));
  for (const auto& processor : processors_) now_ = std::max(now_, processor->now());
  return {now_ - begin, dsp_.busy - busy, false};
}

void TurnMachine::count(std::vector<wire::Counter>& list) const {
  const auto sum = [&](const std::string& name, const char* unit, const auto& of, const auto& parts) {
    std::uint64_t value = 0;
    for (const auto& part : parts) value += of(*part);
    list.push_back({name, unit, value});
  };
  const auto processors = [&](const std::string& name, const char* unit, const auto& of) {
    sum("processor." + name, unit, of, processors_);
  };
  const auto memories = [&](const std::string& name, const char* unit, std::uint64_t rdram::ChannelCounters::*field) {
    sum(
        "rdram." + name, unit, [field](const TurnMemory& m) { return m.channel.counters().*field; }, memories_);
  };
  using P = TurnProcessor;
  list.push_back({"asic.cycles", "cycle", now_});
  processors("cycles.busy", "cycle", [](const P& p) { return p.counters().samples; });
  processors("cycles.leap", "cycle", [](const P& p) { return p.counters().leaps; });
  processors("samples", "sample", [](const P& p) { return p.counters().samples; });
  processors("rays_held", "cycle", [](const P& p) { return p.counters().held; });
  processors("cache.checks", "sample", [](const P& p) { return p.cache().checks; });
  processors("cache.packets", "packet", [](const P& p) { return p.cache().packets; });
  processors("cache.missed_voxels", "voxel", [](const P& p) { return p.cache().missed_voxels; });
  processors("cache.filled_voxels", "voxel", [](const P& p) { return p.cache().filled_voxels; });
  processors("sorter.written", "ray", [](const P& p) { return p.counters().written; });
  processors("sorter.overflows", "ray", [](const P& p) { return p.counters().overflows; });
  processors("sorter.issued", "ray", [](const P& p) { return p.counters().samples + p.counters().leaps; });
  processors("sorter.activations", "activation", [](const P& p) { return p.counters().activations; });
  sum(
      "link.rays_sent", "ray", [](const P& p) { return p.counters().rays_sent; }, processors_);
  sum(
      "link.hops", "ray", [](const P& p) { return p.counters().hops; }, processors_);
  list.push_back({"rdram.cycles", "tCYCLE",
                  now_ * config_.rdram().clocks_per_core_cycle() * static_cast<std::uint64_t>(memories_.size())});
  memories("reads", "packet", &rdram::ChannelCounters::packets_read);
  memories("writes", "packet", &rdram::ChannelCounters::packets_written);
  memories("row_hits", "packet", &rdram::ChannelCounters::row_hits);
  memories("row_misses", "packet", &rdram::ChannelCounters::row_misses);
  memories("row_conflicts", "packet", &rdram::ChannelCounters::conflicts);
  memories("data_busy", "tCYCLE", &rdram::ChannelCounters::dq_busy);
  list.push_back({"dsp.rays_sent", "ray", dsp_.sent});
  list.push_back({"dsp.rays_taken", "ray", dsp_.taken});
  list.push_back({"dsp.overflows", "ray", dsp_.overflows});
  list.push_back({"dsp.busy_cycles", "DSP cycle", dsp_.busy});
}

}  // namespace gicube::emu
