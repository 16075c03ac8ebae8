#include "pass_machine.h"

#include <algorithm>
#include <string>
#include <utility>

#include "approximate/traced_passes.h"
#include "asic/latencies.h"
#include "asic/raybus/ray_bus.h"
#include "dsp/count_dsp.h"
#include "levels/counters.h"

namespace gicube::emu {

namespace {

// Chosen: cycles by which a part may run ahead of the next; less where the order of deposits decides what is written,
// or that of requests which rows of a shared memory are open.
constexpr Cycle kSlack = 32, kSlackOfEvents = 16, kSlackOfShared = 4;
constexpr std::size_t kOnTheWay =
    kFifoPlaces;                       // rays between the bus and one sorter, and sends between the DSP and the bus
constexpr std::size_t kChunk = 4'096;  // chosen: rays whose values are worked out at a time

}  // namespace

RayPrefetcher::RayPrefetcher(TracedPasses& work, bool ahead) : work_(work), ahead_(ahead) { begin_chunk(); }

void RayPrefetcher::begin_chunk() {
  coming_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kChunk, work_.count() - begun_)));
  const std::uint64_t begin = std::exchange(begun_, begun_ + coming_.size());
  const auto make = [this, begin] { work_.make(begin, coming_); };
  if (!coming_.empty()) making_ = std::async(ahead_ ? std::launch::async : std::launch::deferred, make);
}

PassRay& RayPrefetcher::next() {
  if (at_ == chunk_.size()) {
    making_.get();
    chunk_.swap(coming_);
    at_ = 0;
    begin_chunk();
  }
  return chunk_[at_++];
}

PassMachine::PassMachine(const v1::BoardConfig& config, const std::array<int, 3>& blocks)
    : config_(config),
      blocks_(blocks),
      partition_(config.asic(), blocks),
      core_khz_(config.asic().core_khz()),
      dsp_khz_(config.dsp().clock_khz()),
      up_(config.asic().processors()),
      standard_(memory_standard(config)),
      dsp_(config),
      store_(config.asic().processors() * std::max<std::size_t>(1, partition_.max_blocks())),
      listeners_(config.asic().processors()) {
  for (std::uint32_t i = 0; i < config_.asic().processors(); ++i) {
    const std::size_t clients = standard_.sharing;
    if (i % clients == 0) {
      memories_.push_back(
          std::make_unique<PassMemory>(config_, clients * blocks_in_memory(config_, partition_.max_blocks())));
    }
    const PassProcessor::Shared with{&config_, &partition_, blocks_, &processors_, memories_.back().get(),
                                     &rays_,   &up_};
    processors_.push_back(std::make_unique<PassProcessor>(static_cast<std::uint8_t>(i), with));
    memories_.back()->clients.push_back(processors_.back().get());
  }
}

bool PassMachine::covers(const v1::BoardConfig& config) { return config.sorter().queues() == v1::per_block; }

void PassMachine::invalidate_caches() {
  for (const auto& processor : processors_) processor->invalidate_cache();
}

// It begins one thing a core cycle at most, at the clock's edge.
void PassMachine::dsp_works(const DspTask& task) {
  const DspCycle begin = (engine_.now * dsp_khz_ + core_khz_ - 1) / core_khz_;
  engine_.free = dsp_.work(task, std::max(engine_.free, begin));
  engine_.now = std::max(engine_.now + 1, (engine_.free * core_khz_ + dsp_khz_ - 1) / dsp_khz_);
}

// A run is two packets, and each processor extrapolates one of its rays a cycle.
void PassMachine::send(std::uint32_t handle, std::uint32_t run, bool first, bool has_slot) {
  PassRay& ray = rays_[handle];
  const Home& home = partition_.home(ray.block);
  Cycle ready = engine_.now + kDspToPipeline;
  if (run != 0) {
    Listener& listener = listeners_[home.processor];
    if (std::exchange(listener.making, run) != run) listener.made = 0;
    ready += RayBus::kRunPackets + listener.made++;
  }
  bus_.push({home.processor,
             first,
             run,
             {ready, handle, home.number, has_slot ? Arrival::Kind::kToItsSlot : Arrival::Kind::kRay}});
  sends_ += first ? 1 : 0;
  ++engine_.sent;
}

// The processor that can't take what is next on the bus, if there is one. A run waits until all have a buffer for it.
PassProcessor* PassMachine::holds(const OnBus& next) const {
  PassProcessor* const to = processors_[next.processor].get();
  if (next.run == 0) return to->holds_bus() && to->from_bus() >= kOnTheWay ? to : nullptr;
  for (std::size_t i = 0; next.first && i < processors_.size(); ++i) {
    const std::uint64_t taken = listeners_[i].sent - processors_[i]->from_bus();
    if (listeners_[i].ends[0] > taken + kOnTheWay) return processors_[i].get();
  }
  return nullptr;
}

void PassMachine::hand_on(const OnBus& next) {
  Listener& listener = listeners_[next.processor];
  ++listener.sent;
  if (next.run != 0) {
    if (std::exchange(listener.run, next.run) != next.run) listener.ends[0] = listener.ends[1];
    listener.ends[1] = listener.sent;
  }
  sends_ -= next.first ? 1 : 0;
  processors_[next.processor]->send(PassProcessor::From::kBus, next.ray);
}

// Hands rays on in their order.
void PassMachine::run_bus() {
  while (!bus_.empty()) {
    PassProcessor* const held_by = holds(bus_.front());
    if (held_by != nullptr) {
      holding_ = held_by;
      return;
    }
    if (holding_ != nullptr) bus_free_ = std::max(bus_free_, std::exchange(holding_, nullptr)->taken_from_bus());
    hand_on(bus_.front());
    bus_.drop();
  }
}

void PassMachine::launch(PassRay& ray, std::uint64_t index, std::uint32_t run, bool first) {
  ray.block = static_cast<std::uint32_t>(grid_.block(ray.position));
  for (std::int32_t& at : ray.position) at &= grid_.size() - 1;
  const std::uint32_t handle = rays_.add(std::move(ray));
  if (index_of_.size() <= handle) index_of_.resize(handle + 1);
  index_of_[handle] = index;
  ++engine_.under_way;
  send(handle, run, first);
}

// The next that goes to the ASIC: those that are not made cost nothing.
void PassMachine::make_ray_that_is_there(TracedPasses& work) {
  while (engine_.made < count_) {
    PassRay& ray = maker_->next();
    const std::uint64_t index = engine_.made++;
    if (ray.left <= 0) continue;
    dsp_works(work.making(index));
    launch(ray, index, 0, true);
    break;
  }
  run_bus();
}

// One ray, or a run of them.
void PassMachine::make_rays(TracedPasses& work) {
  if (work.misses_are_free()) return make_ray_that_is_there(work);
  const std::uint64_t places = may_be_under_way_ - engine_.under_way;
  const std::uint64_t last = std::min(work.run_end(engine_.made), engine_.made + places);
  const std::uint32_t run = last > engine_.made + 1 ? ++runs_ : 0;
  dsp_works(work.making(engine_.made));
  bool first = true;
  for (; engine_.made < last; ++engine_.made) {
    PassRay& ray = maker_->next();
    if (ray.left > 0) launch(ray, engine_.made, run, std::exchange(first, false));
  }
  run_bus();
}

void PassMachine::send_again() {
  const OverflowStore::Sent again = store_.send();
  dsp_works(again.task);
  send(again.ray, 0, true, again.has_slot);
  run_bus();
}

void PassMachine::take_back(TracedPasses& work) {
  const Arrival back = up_.pop(engine_.now);
  processors_[back.processor]->taken_from_tree(engine_.now);
  if (back.kind == Arrival::Kind::kSlot) {
    store_.make_ready(list_of(back.processor, back.queue));
    ++engine_.now;
  } else if (back.kind == Arrival::Kind::kOverflowed) {
    ++engine_.overflows;
    dsp_works(store_.keep(list_of(back.processor, back.queue), back.ray));
  } else if (!scatter(back.ray)) {
    DspTask looking;
    if (rays_[back.ray].route) looking = rays_[back.ray].route->looking;
    rays_.remove(back.ray);
    --engine_.under_way;
    ++engine_.taken;
    if (looking.loop != nullptr) dsp_works(looking);
    dsp_works(work.taking(index_of_[back.ray]));
  }
}

// A trapped ray is told its new direction and goes down again, or is given to the host. False if it has come to its end.
bool PassMachine::scatter(std::uint32_t handle) {
  PassRay& ray = rays_[handle];
  if (!ray.route) return false;
  const TrailEvent& event = ray.route->events[ray.route->next];
  if (!event.trapped) return false;
  DspTask task{.loop = &kTakeTrap};
  task.more_cycles = event.routine_cycles;
  dsp_works(task);
  if (event.waits) {
    rays_.remove(handle);
    --engine_.under_way;
    return true;
  }
  if (event.ends) return false;
  ray.follow(event.way, jitter_);
  ray.block = static_cast<std::uint32_t>(grid_.block(ray.position));
  for (std::int32_t& at : ray.position) at &= grid_.size() - 1;
  const TrailEvent& next = ray.route->events[++ray.route->next];
  ray.begin_way(next.steps, next.contribution);
  dsp_works(store_.keep_ready(handle));
  return true;
}

// What comes back goes first, then overflowed rays that have a slot, then new ones, as many as it makes in a batch. False if there
// is nothing to be done yet.
bool PassMachine::dsp_acts(TracedPasses& work) {
  const bool bus_is_full = sends_ > kOnTheWay;
  if (!bus_is_full && engine_.batch > 0 && !up_.is_full(engine_.now) &&
      (engine_.sends_again ? store_.has_ready() : may_make())) {
    --engine_.batch;
    engine_.now = std::max(engine_.now, bus_free_);
    engine_.sends_again ? send_again() : make_rays(work);
    return true;
  }
  engine_.batch = 0;
  if (up_.ready() <= engine_.now) {
    take_back(work);
    return true;
  }
  engine_.sends_again = store_.has_ready();
  if (bus_is_full || (!engine_.sends_again && !may_make())) return false;
  engine_.now = std::max(engine_.now, bus_free_);
  engine_.batch = Dsp::kBatch - 1;
  engine_.sends_again ? send_again() : make_rays(work);
  return true;
}

// A shared memory sends what no processor can be before any more: false if that is nothing.
bool PassMachine::send_first(Cycle before) {
  for (const auto& memory : memories_) {
    if (!memory->shared() || memory->next() > before || memory->next() == kNoCycle) continue;
    memory->send();
    return true;
  }
  return false;
}

RunResult PassMachine::run(TracedPasses& work, const Frame& frame, Progress& progress, bool ahead) {
  if (std::exchange(caches_sums_, frame.sums != nullptr) != caches_sums_) invalidate_caches();
  const Cycle begin = now_;
  const std::uint64_t busy = dsp_.counters().busy(), taken = engine_.taken;
  count_ = work.count();
  may_be_under_way_ = std::min<std::uint64_t>(config_.dsp().overflow_rays(), work.max_under_way());
  maker_.emplace(work, ahead);
  engine_.made = engine_.under_way = 0;
  engine_.batch = 0;
  engine_.now = now_;
  grid_ = BlockGrid(*frame.volume);
  jitter_ = frame.jitter;
  for (const auto& processor : processors_) processor->begin(now_, frame);
  progress.all = static_cast<std::uint32_t>(count_);
  const bool by_events = PassProcessor::goes_by_events(config_, frame);
  const Cycle slack = standard_.sharing > 1 ? kSlackOfShared : by_events ? kSlackOfEvents : kSlack;
  RunResult ran;
  while (true) {
    PassProcessor* behind = nullptr;
    Cycle least = kNoCycle, second = kNoCycle;
    for (const auto& processor : processors_) {
      const Cycle next = processor->next();
      second = std::min(second, std::max(least, next));
      if (next < least) {
        least = next;
        behind = processor.get();
      }
    }
    if (standard_.sharing > 1 && send_first(least)) continue;
    // While the DSP is not behind the processors it has seen all that comes.
    if (least >= engine_.now) {
      if (dsp_acts(work)) continue;
      if (up_.ready() != kNoCycle && up_.ready() <= least) {
        engine_.now = std::max(engine_.now, up_.ready());
        continue;
      }
      if (behind == nullptr) break;
    }
    const bool dsp_has_work = may_make() || store_.has_ready();
    Cycle until = second == kNoCycle ? least + std::min<Cycle>(slack, 64) : second + slack;
    if (dsp_has_work) until = std::min(until, std::max(least, engine_.now) + slack);
    behind->work(std::max(until, least), holding_ == behind);
    run_bus();
    progress.done = static_cast<std::uint32_t>(engine_.taken - taken);
    if (progress.cancel) {
      ran.cancelled = true;
      break;
    }
  }
  maker_.reset();  // waits for what it makes ahead
  if (!ran.cancelled) {
    now_ = engine_.now;
    for (const auto& processor : processors_) now_ = std::max({now_, processor->now(), processor->finish_writes()});
  }
  ran.cycles = now_ - begin;
  ran.dsp_cycles = dsp_.counters().busy() - busy;
  return ran;
}

void PassMachine::state(Archive& archive) {
  archive.expect_idle(bus_.empty() && holding_ == nullptr && up_.ready() == kNoCycle, "a machine of passes");
  archive("tree", up_);
  std::size_t number = 0;
  for (const auto& memory : memories_) {
    archive.within("memory" + std::to_string(number++), [&] {
      archive("channel", *memory->channel);
      archive.field("asked", [&](Archive::Record& record) { record.times(memory->asked); });
      archive.at_most("turn", memory->turn, memory->clients.size() - 1);
    });
  }
  archive.parts("processor", processors_);
  archive("core", dsp_);
  archive("overflows", store_);
  archive.field("engine", [this](Archive::Record& record) {
    record.times(engine_.now, engine_.free);
    record(engine_.sends_again, engine_.sent, engine_.taken, engine_.overflows, runs_);
    record.times(bus_free_, now_);
    record(caches_sums_);
  });
  archive("listeners", listeners_);
}

void PassMachine::count(std::vector<wire::Counter>& list) const {
  list.push_back({"asic.cycles", "cycle", now_});
  {
    PartCounters part(list);
    for (std::size_t i = 0; i < processors_.size(); ++i) {
      const PassProcessor& processor = *processors_[i];
      const std::uint64_t samples = processor.samples(), leaps = processor.counters().leaps;
      part.begin("processor", i);
      const PassCounters& counters = processor.counters();
      part.put("cycles.busy", "cycle", samples + counters.carried);
      part.put("cycles.leap", "cycle", leaps);
      // So that the causes add up to all cycles here too. min: a cancelled run has counted passes, but not their cycles.
      part.put("cycles.unattributed", "cycle", now_ - std::min(now_, samples + counters.carried + leaps));
      part.put("samples", "sample", samples);
      part.put("rays_held", "cycle", counters.held);
      part.put("cache.checks", "sample", samples + counters.carried);
      part.put("cache.packets", "packet", processor.cache().packets);
      part.put("cache.missed_voxels", "voxel", processor.cache().missed_voxels);
      part.put("cache.filled_voxels", "voxel", processor.cache().filled_voxels);
      part.put("splat.deposits", "deposit", counters.deposits);
      part.put("splat.carriers", "ray", counters.carriers);
      part.put("splat.tiles", "tile", processor.writes().tiles);
      part.put("splat.tiles_combined", "tile", processor.writes().combined);
      part.put("splat.tiles_fetched", "tile", processor.writes().fetches);
      part.put("sorter.written", "ray", processor.passes());
      part.put("sorter.overflows", "ray", counters.overflows);
      part.put("sorter.issued", "ray", processor.passes());
      part.put("sorter.activations", "activation", counters.activations);
    }
    for (std::size_t i = 0; i < processors_.size(); ++i) {
      part.begin("link", i);
      part.put("rays_sent", "ray", processors_[i]->counters().rays_sent);
      part.put("hops", "ray", processors_[i]->counters().hops);
    }
    for (std::size_t i = 0; i < memories_.size(); ++i) {
      const dram::ChannelCounters channel = memories_[i]->channel->counters();
      part.begin(standard_.name, i);
      part.put("cycles", standard_.clock, ClockRatio(config_.asic().core_khz(), standard_.clock_khz).passed(now_));
      part.put("reads", "packet", channel.packets_read);
      part.put("writes", "packet", channel.packets_written);
      part.put("row_hits", "packet", channel.row_hits);
      part.put("row_misses", "packet", channel.row_misses);
      part.put("row_conflicts", "packet", channel.conflicts);
      part.put("data_busy", standard_.clock, channel.dq_busy);
    }
  }
  list.push_back({"dsp.rays_sent", "ray", engine_.sent});
  list.push_back({"dsp.rays_taken", "ray", engine_.taken});
  list.push_back({"dsp.overflows", "ray", engine_.overflows});
  count_dsp(dsp_, list);
}

}  // namespace gicube::emu
