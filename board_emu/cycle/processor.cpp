#include "processor.h"

#include <algorithm>
#include <bit>
#include <ostream>

#include "datapath/bricks.h"
#include "datapath/interaction.h"

namespace gicube::emu {

namespace {

constexpr Cause kLastCause = Cause::kSdram;

SorterSetup sorter_setup(const ProcessorConfig& config) {
  const v1::BoardConfig& board = config.board;
  SorterSetup setup;
  setup.processor = config.number;
  setup.single = board.sorter().queues() == v1::single;
  setup.bus_waits = setup.single;  // otherwise most rays of a frame would return to the DSP as overflows
  setup.queues = static_cast<std::uint32_t>(std::max<std::size_t>(1, config.partition->blocks_of(config.number)));
  setup.capacity = board.asic().queue_rays();
  setup.policy = board.sorter().policy();
  setup.ideal_queues = board.ideal().queues() != 0;
  setup.ideal_sorter = board.ideal().sorter() != 0;
  return setup;
}

// Cold path for watched rays. Returning `cause` allows a tail call.
[[gnu::noinline, gnu::cold]] Cause count_wait(RayWatch& watch, std::uint32_t ray, Cause cause) {
  watch.waits(ray);
  return cause;
}
[[gnu::noinline, gnu::cold]] Cause report_filled(RayWatch& watch, Cycle now, std::uint32_t ray, int processor,
                                                 Cause cause) {
  watch.goes_on({.step = RayStep::kFilled, .cycle = now, .handle = ray, .processor = processor});
  return cause;
}
[[gnu::noinline, gnu::cold]] void report_gone(RayWatch& watch, Cycle now, std::uint32_t ray, int processor) {
  watch.report({.step = RayStep::kGone, .cycle = now, .handle = ray, .processor = processor});
}

}  // namespace

Processor::Processor(const ProcessorConfig& config)
    : number_(config.number),
      partition_(*config.partition),
      rays_(*config.rays),
      watch_(*config.watch),
      single_queue_(config.board.sorter().queues() == v1::single),
      ideal_memory_(config.board.ideal().memory() != 0),
      two_ports_(config.board.cache().ports() == 2),
      splat_rule_(config.board.cache().splat_rule()),
      write_policy_(config.board.cache().write_policy()),
      sorter_(sorter_setup(config), {returned_, from_bus, from_left, from_right, released_}, {issue_, overflow}),
      stages_(config.board.pipeline().prefetch_stages(), config.board.pipeline().compute_stages()),
      cache_({static_cast<int>(config.board.asic().block_voxels()), config.board.cache().ways(), single_queue_,
              config.blocks, write_policy_ == v1::write_back, 1, config.board.cache().tags() == v1::of_voxels}),
      cells_(config.board.cache().irradiance() == v1::in_cells
                 ? std::optional<VolumeCache>(CacheShape{static_cast<int>(config.board.asic().block_voxels()),
                                                         config.board.cache().ways(), false, config.blocks,
                                                         write_policy_ == v1::write_back, 2})
                 : std::nullopt),
      misses_(config.board.cache().miss_packets()),
      writes_(config.board.cache().write_packets()),
      splats_(std::size_t{config.board.pipeline().prefetch_stages()} + config.board.pipeline().compute_stages() + 1,
              config.board.cache().ports()),
      unfed_(std::bit_ceil(std::size_t{config.board.pipeline().prefetch_stages()} + 1), Cause::kDsp),
      unfed_mask_(unfed_.size() - 1) {
  sorter_.set_listener(&watch_);
}

void Processor::begin(const Frame& frame, bool has_trace) {
  frame_ = &frame;
  has_trace_ = has_trace;
  does_more_ = does_more_than_gather();
  grid_ = BlockGrid(*frame.volume);
  edge_ = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
}

// Sends on a ray that has left the compute line. Returns false if its destination is full.
bool Processor::deliver(Cycle now, const InFlight& ray) {
  const RayToken& token = ray.token;
  if (ray.splats && splat_waits(now)) {
    latest_ = Cause::kSplat;
    return false;
  }
  Fifo<RayToken>* to = &returned_;
  if (token.state == TokenStatus::kGone) {
    if (token.watched) [[unlikely]]
      report_gone(watch_, now, token.ray, number_);
    rays_.remove(token.ray);
    to = nullptr;
  } else if (token.state != TokenStatus::kUnderWay) {
    to = &done;
  } else if (token.processor != number_) {
    to = &out_links;
  }
  if (to != nullptr && !to->can_push(now)) {
    latest_ = to == &done ? Cause::kRayBus : to == &out_links ? Cause::kLink : Cause::kSorter;
    return false;
  }
  if (to != nullptr) to->push(now, token);
  if (!token.has_reserved_slot) released_.push(now, ray.from);
  if (ray.splats) {
    if (token.watched) [[unlikely]]
      report_deposit(now, token);
    begin_splat(now);
  }
  return true;
}

// For banks with two ports: writes an arrived packet into the cache while samples are read, unless it replaces words
// that an older sample of another block must still read.
bool Processor::fill(Cycle now) {
  if (misses_.empty() || misses_.oldest().arrival > now || splats_.takes_write_port(now)) return false;
  std::size_t owner = 0;
  while (stages_.prefetching(owner).packets == 0) ++owner;
  InFlight& sample = stages_.prefetching(owner);
  for (std::size_t i = 0; i < owner; ++i) {
    const InFlight& older = stages_.prefetching(i);
    if (older.sampled && older.block != sample.block) return false;
  }
  misses_.take();
  --sample.packets;
  return true;
}

// Moves the oldest sample of the prefetch line on, if it has passed the line and its packets have arrived.
Cause Processor::enter_compute(Cycle now) {
  if ((stages_.prefetching() == 0) | (stages_.oldest_prefetching().ready > now)) {
    bubble_ = true;
    return latest_;
  }
  if (does_more_ && splats_.takes_cache(now)) return Cause::kSplat;
  InFlight& head = stages_.oldest_prefetching();
  if (head.packets > 0) {
    const auto waits = [this, &head](Cause cause) {
      if (head.token.watched) [[unlikely]]
        return count_wait(watch_, head.token.ray, cause);
      return cause;
    };
    const Packet& packet = misses_.oldest();
    if (packet.arrival > now) return waits(packet.sent < now ? waiting_for(packet.delay) : Cause::kMiss);
    if (two_ports_) return waits(Cause::kFill);  // one was written, or the port is occupied
    misses_.take();
    if (--head.packets > 0) return waits(Cause::kFill);
  }
  const Cause cause = head.sampled ? Cause::kBusy : Cause::kLeap;
  stages_.start_computing(compute_clock_);
  if (head.token.watched) [[unlikely]]
    return report_filled(watch_, now, head.token.ray, number_, cause);
  return cause;
}

// Requests the missing tiles of the block with that number from the memory. Returns the number of packets.
inline std::uint8_t Processor::ask(Cycle now, const Misses& misses, std::uint32_t number) {
  if (ideal_memory_) return 0;
  for (std::uint32_t i = 0; i < misses.count; ++i) misses_.ask(now, number, misses.tiles[i]);
  return static_cast<std::uint8_t>(misses.count);
}

void Processor::skip(RayState& ray, const Point& low) {
  const std::int32_t left = ray.steps_left();
  const std::int32_t steps = skip_block(ray, low, grid_.size(), *frame_, counts_);
  if (has_trace_) ray.set_steps_left(left - std::min(steps, left));
}

// One iteration of a ray: checks the tags, requests missing tiles, takes the sample, and determines the ray's next
// queue. The sample can be taken here because values do not depend on the time.
void Processor::check_tags(Cycle now, const RayToken& issued) {
  constexpr std::size_t kMaxCarriers = 8;
  if (does_more_) rays_.make_room(kMaxCarriers);
  RayUnderWay& ray = rays_[issued.ray];
  RayState& ray_state = ray.ray_state;
  if (issued.watched) [[unlikely]]
    watch_.before(ray);
  InFlight& entry = stages_.enter(now);
  // Changed in place: copying a token that was assembled elsewhere would stall the host on its partial stores.
  RayToken& token = entry.token;
  token = issued;
  entry.from = issued.queue;
  entry.packets = 0;
  entry.splats = false;
  entry.block = ray.block;
  const Point low = grid_.low(ray_state.position);
  const bool carries = does_more_ && ray_state.is(wire::kIrradianceCarrier);
  entry.sampled = carries || !is_skipped(ray.block, *frame_);
  Termination how = Termination::kActive;
  if (!entry.sampled) {
    skip(ray_state, low);
  } else {
    const Cell at = carries ? carrier_cell(ray) : cell(ray_state.position, low);
    const Misses& misses = cache_.check(ray.block, at.voxel);
    for (const TileOfBlock& changed : cache_.evictions()) write_back(changed, false);
    if (misses.count > 0) entry.packets = ask(now, misses, partition_.home(ray.block).number);
    if (does_more_ && frame_->lit_by_irradiance && packs_irradiance()) {
      const Misses& words = cells_->check(ray.block, at.voxel);
      for (const TileOfBlock& changed : cells_->evictions()) write_back(changed, true);
      entry.packets += ask(now, words, irradiance_of(partition_.home(ray.block).number));
    }
    if (has_trace_) {
      jitter_step(ray_state, *frame_);
      advance(ray_state, 1, *frame_);
      ray_state.set_steps_left(std::max(ray_state.steps_left() - 1, 0));
      ++counts_.samples;
    } else if (carries) {
      splat(ray.block, brought_by(ray_state, *frame_), ray_state, entry);
      how = Termination::kAbsorbed;
    } else {
      const BlockView view = frame_->volume->view(ray.block);
      const SampleSite site{at, view, ray.block, edge_};
      if (!does_more_) {
        gather(ray_state, site, *frame_, counts_);
      } else {
        const Point position = ray_state.position;
        how = after(sample(ray_state, site, *frame_, counts_), position, ray, entry);
      }
    }
  }

  if (has_trace_) {
    if (ray_state.steps_left() == 0) how = Termination::kLeft;
  } else {
    token.contribution = contribution(ray_state);
  }
  // The end of a trapped ray is determined when it has its new direction.
  if (how == Termination::kActive && token.state != TokenStatus::kTrapped && !has_trace_) {
    how = end(ray_state, *frame_);
  }
  if (how != Termination::kActive) {
    token.state = carries ? TokenStatus::kGone : TokenStatus::kDone;
    if (!carries) count_end(ray_state, how, *frame_, counts_);
  } else if (!grid_.same(ray_state.position, low)) {
    ray.block = static_cast<std::uint32_t>(grid_.block(ray_state.position));
    if (token.state != TokenStatus::kTrapped && is_non_resident(ray.block, *frame_)) {
      token.state = TokenStatus::kNonResident;
    } else {
      const Home& home = partition_.home(ray.block);
      token.processor = home.processor;
      token.queue = single_queue_ ? 0 : home.number;
    }
  } else if (!has_trace_) {
    prefetch(frame_->volume->view(ray.block), ray_state.position, low);
  }
  token.has_reserved_slot =
      token.state == TokenStatus::kUnderWay && token.processor == number_ && token.queue == entry.from;
  if (token.watched) [[unlikely]]
    report_iteration(now, entry, how);
}

void Processor::report_deposit(Cycle now, const RayToken& token) {
  watch_.report({.step = RayStep::kDeposited,
                 .cycle = now,
                 .handle = token.ray,
                 .processor = number_,
                 .count = splats_.oldest().carriers});
}

void Processor::report_iteration(Cycle now, const InFlight& entry, Termination how) {
  watch_.after({.step = entry.sampled ? RayStep::kSampled : RayStep::kLeapt,
                .cycle = now,
                .handle = entry.token.ray,
                .processor = number_,
                .queue = entry.from,
                .count = entry.packets},
               how);
}

// Most conditions avoid branches by & instead of &&, because they are hard to predict.
bool Processor::tick_pipeline(Cycle now) {
  fed_ = backed_up_ = bubble_ = false;
  bool moved = does_more_ && tick_light(now), stalled = false;
  if (issue_.empty() && stages_.empty()) {
    bubble_ = true;
    return moved;
  }
  if (two_ports_) moved |= fill(now);
  if ((stages_.computing() > 0) & (stages_.oldest_computing().ready <= compute_clock_)) {
    if (deliver(now, stages_.oldest_computing())) {
      stages_.leave();
      moved = true;
    } else {
      stalled = true;
    }
  }
  if (!stalled) {
    latest_ = enter_compute(now);
    moved = moved || !bubble_;
    ++compute_clock_;
  }
  if (issue_.can_pop(now)) {
    if (stages_.can_enter() & (misses_.room() >= (cells_ ? kMaxPackets + kMaxCells : kMaxPackets)) &
        has_room_for_evictions()) {
      check_tags(now, issue_.front());
      issue_.pop(now);
      fed_ = moved = true;
    } else {
      backed_up_ = true;
    }
  }
  return moved;
}

void Processor::account_idle(Cycle now, Cycle cycles, Cause upstream) {
  fed_ = backed_up_ = false;
  bubble_ = true;
  const Cycle first = std::min<Cycle>(cycles, stages_.prefetch_stages()), last = cycles - first;
  for (Cycle i = 0; i < first; ++i) account(now + i, upstream);
  causes_[static_cast<std::size_t>(bubble(upstream, 0))] += last;
  for (Cycle i = 0; i < std::min<Cycle>(last, unfed_.size()); ++i) {
    unfed_[(now + cycles - 1 - i) & unfed_mask_] = bubble(upstream, 0);
  }
}

bool Processor::idle() const {
  return sorter_.idle() && issue_.empty() && stages_.empty() && returned_.empty() && released_.empty() &&
         from_bus.empty() && from_left.empty() && from_right.empty() && out_links.empty() && done.empty() &&
         overflow.empty() && !splats_.has_carrier() && writes_.empty() && !cache_.has_changes() &&
         !(cells_ && cells_->has_changes());
}

void Processor::state(Archive& archive) {
  archive.expect_idle(idle() && misses_.empty(), "a processor");
  TokenLimits* const limits = archive.token_limits();
  if (limits != nullptr) limits->here = sorter_.queues();
  archive("sorter", sorter_);
  if (limits != nullptr) limits->here = TokenLimits().here;
  archive("cache", cache_);
  if (cells_) archive("cells", *cells_);
  const std::size_t blocks = partition_.blocks();
  archive.within("writes", [&] { writes_.state(archive, packet_blocks(), cache_.tiles_of_block()); });
  archive.within("splats", [&] { splats_.state(archive, blocks, cache_.tiles_of_block()); });
  archive.at_most("latest", latest_, kLastCause);
  archive.field("unfed", [this](Archive::Record& record) {
    for (Cause& cause : unfed_) record.at_most(cause, kLastCause);
  });
  archive("rays", counts_);
  archive.field("cycles", [this](Archive::Record& record) {
    record.times(compute_clock_);
    record(causes_, holding_cycles_, fed_, backed_up_, bubble_);
  });
  if (archive.in_run()) run_state(archive);
}

// State between the processor's parts.
void Processor::run_state(Archive& archive) {
  archive.field("misses",
                [this](Archive::Record& record) { misses_.state(record, packet_blocks(), cache_.tiles_of_block()); });
  TokenLimits* const limits = archive.token_limits();
  if (limits != nullptr) limits->here = sorter_.queues();
  archive("issue", issue_);
  archive("returned", returned_);
  archive("from_bus", from_bus);
  archive("from_left", from_left);
  archive("from_right", from_right);
  if (limits != nullptr) limits->here = TokenLimits().here;
  archive("released", released_);
  archive("out_links", out_links);
  archive("done", done);
  archive("overflow", overflow);
  archive("stages", stages_);
  std::size_t packets = 0, splats = 0;
  bool fits = true;
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    packets += stages_[i].packets;
    splats += stages_[i].splats ? 1 : 0;
    fits = fits && stages_[i].from < sorter_.queues() && (i >= stages_.computing() || stages_[i].packets == 0);
  }
  for (std::size_t i = 0; i < released_.size(); ++i) fits = fits && released_[i] < sorter_.queues();
  archive.expect(fits && packets == misses_.size() && splats == splats_.waiting(), "stages",
                 "rays of its queues, and their packets and deposits", packets);
}

void Processor::dump(std::ostream& out) const {
  out << "processor " << int{number_} << ": prefetch " << stages_.prefetching() << ", compute " << stages_.computing()
      << ", packets under way " << misses_.size() << ", issue " << issue_.size() << ", returned " << returned_.size()
      << ", from bus " << from_bus.size() << ", from links " << from_left.size() + from_right.size() << ", to links "
      << out_links.size() << ", tiles to write " << writes_.size() << ", done " << done.size() << ", overflow "
      << overflow.size() << '\n';
  if (stages_.prefetching() > 0)
    out << "  oldest sample waits for " << int{stages_.oldest_prefetching().packets} << " packets\n";
  sorter_.dump(out);
}

}  // namespace gicube::emu
