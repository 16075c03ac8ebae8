#include "machine.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <sstream>
#include <utility>

#include "asic/memory_standards.h"
#include "config/power_peaks.h"
#include "gicube/wire/mix64.h"
#include "words/block_grid.h"

namespace gicube::emu {

namespace {
constexpr Cycle kReportCycles = PowerPeaks::kReportCycles;
}

Machine::Machine(const v1::BoardConfig& config, const std::array<int, 3>& blocks)
    : config_(config),
      blocks_(blocks),
      partition_(config.asic(), blocks),
      standard_(emu::memory_standard(config)),
      run_pool_(config.asic().processors()) {
  const unsigned count = config.asic().processors();
  for (unsigned i = 0; i < count; ++i) {
    ProcessorConfig each;
    each.number = static_cast<std::uint8_t>(i);
    each.board = config;
    each.blocks = blocks;
    each.partition = &partition_;
    each.rays = &rays_;
    each.watch = &watch_;
    processors_.push_back(std::make_unique<Processor>(each));
  }
  const unsigned sharing = standard_.sharing;
  for (unsigned first = 0; first < count; first += sharing) {
    std::vector<MemoryClient> clients;
    for (unsigned i = first; i < std::min(first + sharing, count); ++i) {
      clients.push_back({&processors_[i]->misses(), &processors_[i]->writes()});
    }
    memories_.push_back(
        std::make_unique<MemoryPort>(config, clients, blocks_in_memory(config, partition_.max_blocks())));
  }
  std::vector<Fifo<RayToken>*> from_bus, leaves;
  std::vector<Ring::Port> ring;
  for (const auto& processor : processors_) {
    from_bus.push_back(&processor->from_bus);
    leaves.push_back(&processor->done);
    leaves.push_back(&processor->overflow);
    ring.push_back({&processor->out_links, &processor->from_left, &processor->from_right});
  }
  ray_bus_ = std::make_unique<RayBus>(down_, runs_, run_pool_, from_bus);
  links_ = std::make_unique<Ring>(config.link().bits(), config.link().rays(), ring);
  links_->set_listener(&watch_);
  tree_ = std::make_unique<MergeTree>(leaves, up_);
  dsp_ = std::make_unique<RayEngine>(config, partition_, rays_, watch_, RayEnginePorts{down_, runs_, run_pool_, up_});
}

void Machine::invalidate_caches() {
  for (const auto& processor : processors_) processor->invalidate_cache();
}

// Numbers of parts: DSP, ray bus, links, merge tree, memories, then sorter and pipeline of each processor.
bool Machine::tick_part(std::size_t part) {
  switch (part) {
    case 0: return dsp_->tick(now_);
    case 1: return ray_bus_->tick(now_);
    case 2: return links_->tick(now_);
    case 3: return tree_->tick(now_);
    default: part -= 4;
  }
  if (part < memories_.size()) return memories_[part]->tick(now_);
  part -= memories_.size();
  Processor& processor = *processors_[part / 2];
  return part % 2 == 0 ? processor.tick_sorter(now_) : processor.tick_pipeline(now_);
}

bool Machine::tick() {
  if (shuffle_ != 0) return tick_shuffled();
  bool moved = dsp_->tick(now_);
  moved |= ray_bus_->tick(now_);
  moved |= links_->tick(now_);
  ticked_.clear();
  for (std::size_t i = 0; i < processors_.size(); ++i) {
    if (looks_ahead_) {
      if ((asleep_since_[i] != kAwake || lookahead_.is_ahead(i, now_)) && !processors_[i]->has_input()) continue;
      wake(i);
      run_.moved_at = std::max(run_.moved_at, lookahead_.stop(i, now_));
      if (lookahead_.goes_on(i, now_)) continue;
    }
    moved |= processors_[i]->tick_sorter(now_);
    moved |= processors_[i]->tick_pipeline(now_);
    ticked_.push_back(i);
  }
  const bool is_seen = is_seen_soon();
  if (looks_ahead_) {
    for (const std::size_t i : ticked_) moved |= memories_[i]->tick_ahead(now_);
  } else {
    for (const auto& memory : memories_) moved |= is_seen ? memory->tick(now_) : memory->tick_ahead(now_);
  }
  moved |= tree_->tick(now_);
  if (asleep_ > 0) upstream_.push_back(upstream());
  for (const std::size_t i : ticked_) {
    Processor& processor = *processors_[i];
    processor.account(now_, processor.holds_rays() ? Cause::kLatency : upstream());
    if (!looks_ahead_) continue;
    lookahead_.start(i, now_ + 1, processor.lookahead_until(now_));
    if (!processor.sleeps()) continue;
    asleep_since_[i] = upstream_.size();
    ++asleep_;
  }
  return moved;
}

bool Machine::tick_shuffled() {
  std::vector<std::size_t> order(4 + memories_.size() + 2 * processors_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = order.size() - 1; i > 0; --i) {
    shuffle_ = wire::mix64(shuffle_ + 1) | 1;
    std::swap(order[i], order[(shuffle_ >> 1) % (i + 1)]);
  }
  bool moved = false;
  for (const std::size_t part : order) moved |= tick_part(part);
  const Cause cause = upstream();
  for (const auto& processor : processors_) processor->account(now_, cause);
  return moved;
}

Cycle Machine::next_cycle() const {
  if (asleep_ == processors_.size()) return now_ + 1;
  Cycle next = run_.report_at;
  for (std::size_t i = 0; i < processors_.size(); ++i) {
    if (processors_[i]->has_input()) return now_ + 1;
    if (asleep_since_[i] == kAwake) next = std::min(next, lookahead_.ahead_until(i));
  }
  if (!dsp_->rests()) next = std::min(next, dsp_->free_at());
  const bool is_quiet = next > now_ + 1 && down_.empty() && runs_.empty() && up_.empty() && ray_bus_->idle() &&
                        links_->idle() && tree_->idle();
  return is_quiet ? next : now_ + 1;
}

// Stall cause of a processor whose queues are empty.
Cause Machine::upstream() {
  if (!down_.empty() || !runs_.empty() || !ray_bus_->idle()) return Cause::kRayBus;
  if (dsp_->has_rays_to_send()) return dsp_->waits(now_) ? Cause::kSdram : Cause::kDsp;
  return some_hold_rays() ? Cause::kQueueEmpty : Cause::kDsp;
}

bool Machine::some_hold_rays() {
  const auto is_ahead = [this](std::size_t i) { return looks_ahead_ && lookahead_.is_ahead(i, now_); };
  for (std::size_t i = 0; i < processors_.size(); ++i) {
    if (is_ahead(i) ? lookahead_.has_many_rays(i) : processors_[i]->holds_rays()) return true;
  }
  for (std::size_t i = 0; i < processors_.size(); ++i) {
    if (!is_ahead(i)) continue;
    run_.moved_at = std::max(run_.moved_at, lookahead_.catch_up(i, now_ + 1));
    if (processors_[i]->holds_rays()) return true;
  }
  return false;
}

void Machine::wake(std::size_t i) {
  if (asleep_since_[i] == kAwake) return;
  const Cycle first = now_ - (upstream_.size() - asleep_since_[i]);
  for (std::size_t at = asleep_since_[i]; at < upstream_.size(); ++at) {
    processors_[i]->account(first + (at - asleep_since_[i]), upstream_[at], 0);
  }
  lookahead_.skip(i, now_);
  asleep_since_[i] = kAwake;
  --asleep_;
}

bool Machine::asic_idle() const {
  return down_.empty() && runs_.empty() && up_.empty() && ray_bus_->idle() && links_->idle() && tree_->idle() &&
         std::all_of(processors_.begin(), processors_.end(), [](const auto& p) { return p->idle(); });
}

void Machine::book_millisecond() {
  constexpr std::size_t kMilliseconds = 1024;  // chosen: frames take tens, illumination passes hundreds
  Millisecond sum;
  for (const auto& processor : processors_) {
    sum.activations += processor->sorter().counters().activations;
    sum.samples += processor->rays().samples;
  }
  if (sum.activations == booked_.activations && sum.samples == booked_.samples) return;
  const auto ms = static_cast<std::size_t>(std::min<Cycle>(now_ / config_.asic().core_khz(), kMilliseconds - 1));
  if (milliseconds_.size() <= ms) milliseconds_.resize(ms + 1);
  milliseconds_[ms].activations += sum.activations - booked_.activations;
  milliseconds_[ms].samples += sum.samples - booked_.samples;
  booked_ = sum;
}

// Moves the counters of values to the DSP's, so that they do not depend on where values were computed.
void Machine::collect_values() {
  for (const auto& processor : processors_) dsp_->add_values(processor->take_values());
}

// Counts the cycles up to run_.skips_to without ticking.
void Machine::skip() {
  while (now_ < run_.skips_to) {
    const Cycle stride = now_ < see_at_ ? std::min(run_.skips_to, see_at_) - now_ : 1;
    for (const auto& processor : processors_) processor->account_idle(now_, stride, run_.skip_cause);
    if (stride == 1) show();
    now_ += stride;
  }
  run_.moved_at = now_;
  lookahead_.skip(now_);
}

void Machine::dump(std::ostream& out) const {
  dsp_->dump(out);
  ray_bus_->dump(out);
  links_->dump(out);
  tree_->dump(out);
  for (const auto& processor : processors_) processor->dump(out);
}

void Machine::stalled() const {
  std::ostringstream text;
  text << "stall: nothing has moved on the board for " << kStallCycles << " cycles before core cycle " << now_ << '\n';
  dump(text);
  throw Stall(text.str());
}

// Saved and restored before the parts, which refer to rays and runs.
void Machine::run_state(Archive& archive, TokenLimits& limits) {
  archive("run", run_);
  archive.expect(run_.report_at <= now_ + kReportCycles, "run",
                 "the next report in at most " + std::to_string(kReportCycles) + " cycles", run_.report_at);
  const bool is_past = run_.begin <= now_ && run_.moved_at <= now_;
  archive.expect(is_past, "run", "a begin and a last movement by cycle " + std::to_string(now_),
                 std::max(run_.begin, run_.moved_at));
  archive("rays", rays_);
  if (archive.loads()) {
    const BlockGrid grid(static_cast<int>(config_.asic().block_voxels()), blocks_);
    for (std::uint32_t handle = 0; handle < rays_.handles(); ++handle) {
      const RayUnderWay& ray = rays_[handle];
      const bool is_carrier = ray.ray_state.is(wire::kIrradianceCarrier);
      bool is_valid = ray.block < partition_.blocks();
      const auto corner = grid.corner(is_valid ? ray.block : 0);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        // A carrier's position may be a voxel outside its block.
        const std::int32_t low = corner[axis] * wire::kVoxel, beyond = is_carrier ? wire::kVoxel : 0;
        const std::int32_t at = ray.ray_state.position[axis];
        is_valid = is_valid && at >= std::max(low - beyond, 0) && at < low + grid.size() + beyond;
      }
      limits.in_block.push_back(is_valid ? 1 : 0);
    }
    for (const auto& processor : processors_) limits.queues.push_back(processor->sorter().queues());
    archive.set_token_limits(&limits);
  }
  archive("pool", run_pool_);
  archive("runs", runs_);
  archive("down", down_);
  archive("up", up_);
}

void Machine::state(Archive& archive) {
  archive.expect_idle(asic_idle() && rays_.under_way() == 0, "the ASIC");
  Cycle now = now_ + (is_seen_ ? 1 : 0);
  archive.at_most("now", now, kMostCycles);
  if (archive.loads()) now_ = now;
  archive.list("milliseconds", milliseconds_);
  archive("booked", booked_);
  TokenLimits limits;
  if (archive.in_run() && !archive.loads()) take_samples();
  archive.in_clock(now + kMostAhead, [&] {
    if (archive.in_run()) archive.within("run", [&] { run_state(archive, limits); });
    archive.parts("processor", processors_);
    archive.parts("memory", memories_);
    archive("ray_bus", *ray_bus_);
    archive("links", *links_);
    archive("tree", *tree_);
    archive("dsp", *dsp_);
  });
  archive.set_token_limits(nullptr);
  for (const auto& memory : memories_) {
    archive.expect(memory->latest() <= now + kSeenSoon, "memory",
                   "requests sent at most " + std::to_string(kSeenSoon) + " cycles ahead", memory->latest());
  }
  if (!archive.in_run()) return;
  archive.expect(run_.skips_to <= std::max(now, dsp_->free_at()), "run", "a skip that ends by the DSP's next task",
                 run_.skips_to);
  for (const auto& processor : processors_) {
    const Cycle asked = std::max(processor->misses().latest_asked(), processor->writes().latest_asked());
    archive.expect(asked <= now, "run", "requests of the cycles until now", asked);
  }
  const std::uint64_t worked = dsp_->dsp().counters().busy() - run_.dsp_before;
  archive.expect(worked <= dsp_->latest(now - run_.begin + kMostAhead), "run",
                 "at most the DSP's cycles since the run's begin", worked);
}

void Machine::set_out(const Frame& frame, bool has_trace) {
  for (const auto& processor : processors_) processor->begin(frame, has_trace);
  is_observed_ = !has_trace && has_interested_observer();
  watch_.set_observer(is_observed_ ? observer_ : nullptr);
  watch_.begin(frame);
  looks_ahead_ = !is_observed_ && shuffle_ == 0 && standard_.sharing == 1;
  asleep_since_.assign(processors_.size(), kAwake);
  asleep_ = 0;
  upstream_.clear();
  if (looks_ahead_) lookahead_.begin(now_, processors_, memories_);
  if (observer_ != nullptr) observer_->begins(now_, *this);
  ask_observer(now_);
}

void Machine::take_samples() {
  dsp_->stop_ahead();
  for (const auto& processor : processors_) processor->take_samples();
  collect_values();
}

void Machine::be_observed() {
  is_observed_ = true;
  looks_ahead_ = false;
  take_samples();
  watch_.set_observer(observer_);
}

RunResult Machine::run(RaySource& work, const Frame& frame, Progress& progress, RayRange which,
                       FunctionalTrace* ahead) {
  set_out(frame, ahead != nullptr);
  dsp_->begin(now_, work, frame, which, ahead);
  run_ = {
      .begin = now_, .dsp_before = dsp_->dsp().counters().busy(), .moved_at = now_, .report_at = now_ + kReportCycles};
  return to_the_end(progress, which);
}

RunResult Machine::go_on(RaySource& work, const Frame& frame, Progress& progress, RayRange which) {
  set_out(frame, false);
  dsp_->go_on(work, frame, which);
  if (now_ < run_.skips_to) skip();
  return to_the_end(progress, which);
}

RunResult Machine::to_the_end(Progress& progress, RayRange which) {
  const auto result = [&](bool cancelled) {
    RunResult ran;
    ran.cycles = now_ - run_.begin;
    ran.dsp_cycles = dsp_->dsp().counters().busy() - run_.dsp_before;
    ran.made = dsp_->rays_made();
    ran.rays = dsp_->made();
    ran.cancelled = cancelled;
    return ran;
  };
  progress.all = static_cast<std::uint32_t>(which.end - which.begin);
  while (!dsp_->done(now_) || !asic_idle()) {
    if (now_ >= run_.report_at) {
      wake_all();
      if (looks_ahead_) lookahead_.catch_up_all(now_);
      run_.report_at = now_ + kReportCycles;
      progress.done = static_cast<std::uint32_t>(dsp_->finished());
      book_millisecond();
      if (progress.may_count) progress.may_count();
      if (!is_observed_ && has_interested_observer()) be_observed();
      ask_observer(now_);
      if (progress.cancel) return result(true);
    }
    if (dsp_->keeps_all_rays() && dsp_->free_at() > now_ + 1 && asic_idle()) {
      run_.skips_to = dsp_->free_at();
      run_.skip_cause = upstream();
      wake_all();
      skip();
      continue;
    }
    if (dsp_->done(now_)) {
      for (const auto& processor : processors_) processor->write_rest();
    }
    if (tick()) run_.moved_at = now_;
    show();
    if (now_ - run_.moved_at > kStallCycles) {
      if (looks_ahead_) run_.moved_at = std::max(run_.moved_at, lookahead_.catch_up_all(now_ + 1));
      if (now_ - run_.moved_at > kStallCycles) stalled();
    }
    if (!looks_ahead_) {
      ++now_;
      continue;
    }
    const Cycle next = next_cycle();
    if (dsp_->busy(next - 1)) run_.moved_at = next - 1;
    while (++now_ < next) {
      if (asleep_ > 0) upstream_.push_back(upstream());
    }
  }
  wake_all();
  book_millisecond();
  collect_values();
  return result(false);
}

}  // namespace gicube::emu
