// One ray integration processor of the ASIC: sorter, pipeline and volume cache, and their connections [P §3.2-3.4].
//
// Input: rays from the ray bus and from the neighbours' links, and packets from the memory. Output: rays to the links,
// and finished or overflowed rays to the merge tree. The pipeline takes one sample per cycle, in order:
//
//   sorter -> [tag check] -> prefetch line -> (packets written, one a cycle) -> compute line -> sorter | link | tree
//                  \-> miss queue -> memory -/
//
// Each of the cache's eight banks reads or writes one word per cycle [P §3.3], so a packet is written while no sample
// is read, except for the last packet that a sample waits for: the bypass forwards it in the same cycle.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <vector>

#include "asic/cache/miss_queue.h"
#include "asic/cache/volume_cache.h"
#include "asic/cache/write_queue.h"
#include "asic/fifo_places.h"
#include "asic/partition.h"
#include "asic/sim/causes.h"
#include "asic/sim/fifo.h"
#include "asic/sorter/sorter.h"
#include "cycle/stages.h"
#include "datapath/frame.h"
#include "datapath/ray_step.h"
#include "functional/functional_trace.h"
#include "ray_store.h"
#include "ray_watch.h"
#include "splat_unit.h"

namespace gicube::emu {

struct Interaction;
class MemoryPort;

struct ProcessorConfig {
  std::uint8_t number = 0;
  v1::BoardConfig board;
  std::array<int, 3> blocks{};  // blocks of the volume
  const Partition* partition = nullptr;
  RayStore* rays = nullptr;
  RayWatch* watch = nullptr;
};

class Processor {
 public:
  explicit Processor(const ProcessorConfig& config);

  // All rays until the next call belong to this frame. The processor must be idle. `has_trace`: rays have a trace, so
  // that of their state only steps_left(), the steps to their ends, is used.
  void begin(const Frame& frame, bool has_trace);
  // Returns of_values() of its rays, and subtracts them from its counters.
  RayCounters take_values() {
    const RayCounters values = of_values(counts_);
    counts_ = counts_ - values;
    return values;
  }
  // Computes the values of all further samples, although the frame's rays began with a trace.
  void take_samples() {
    if (!has_trace_) return;
    has_trace_ = false;
    does_more_ = does_more_than_gather();
  }
  void invalidate_cache() {
    cache_.invalidate();
    if (cells_) cells_->invalidate();
  }

  bool tick_sorter(Cycle now) {
    const bool moved = sorter_.tick(now);
    if (issue_.pushed(now)) __builtin_prefetch(&rays_[issue_.back().ray]);
    return moved;
  }
  bool tick_pipeline(Cycle now);

  // Lookahead: as long as nothing enters or leaves a processor, it may be ticked later than the parts around it.
  // Returns the first cycle after `now` in which it may send something; the next cycle if it has sent something or is
  // empty.
  Cycle lookahead_until(Cycle now) const;
  // Whether it will hold rays in every cycle in which it runs ahead.
  bool holds_many_rays() const { return sorter_.waiting() + issue_.size() + stages_.size() >= kMany; }
  // Whether its ticks do nothing but account() until a ray arrives.
  bool sleeps() const { return idle() && misses_.empty() && !has_input(); }
  bool has_input() const { return (from_bus.size() | from_left.size() | from_right.size()) != 0; }
  // Ticks it and its memory in the cycles from `from` to before `to`, all of them before lookahead_until(). Returns the
  // last cycle in which something moved, or 0.
  Cycle run_ahead(Cycle from, Cycle to, MemoryPort& memory);
  // To be called after all parts have ticked: counts the cycle by its cause. `upstream`: the cause if there is no ray
  // here.
  void account(Cycle now, Cause upstream) {
    account(now, upstream, from_bus.size() | from_left.size() | from_right.size());
  }
  // account(); `come`: not 0 if rays arrive from outside.
  void account(Cycle now, Cause upstream, std::size_t come);
  // Counts `cycles` in which the idle processor was not ticked.
  void account_idle(Cycle now, Cycle cycles, Cause upstream);

  bool idle() const;
  // Whether a ray is in its queues or its pipeline.
  bool holds_rays() const;
  // To be called when no more rays will arrive: writes changes in its cache back, one tile per call.
  void write_rest();
  void dump(std::ostream& out) const;
  void state(Archive& archive);

  // Ends of the FIFOs to the ray bus, the ring and the merge tree.
  Fifo<RayToken> from_bus{kFifoPlaces};
  Fifo<RayToken> from_left{kFifoPlaces};
  Fifo<RayToken> from_right{kFifoPlaces};
  Fifo<RayToken> out_links{kFifoPlaces};
  Fifo<RayToken> done{kFifoPlaces};
  Fifo<RayToken> overflow{kFifoPlaces};

  MissQueue& misses() { return misses_; }
  WriteQueue& writes() { return writes_; }
  const WriteQueue& writes() const { return writes_; }
  const SplatUnit& splats() const { return splats_; }
  const MissQueue& misses() const { return misses_; }
  const Stages& stages() const { return stages_; }
  const Sorter& sorter() const { return sorter_; }
  const VolumeCache& cache() const { return cache_; }
  const RayCounters& rays() const { return counts_; }
  const CauseCounts& causes() const { return causes_; }
  Cause latest() const { return latest_; }  // cause of the last accounted cycle
  // Cycles in which a ray was in the queues or the pipeline.
  std::uint64_t holding_cycles() const { return holding_cycles_; }

 private:
  // Inner loop for rays with a trace, and whether it applies: it covers only the usual kind of machine.
  bool can_run_active_queue() const;
  Cycle run_active_queue(Cycle from, Cycle to, MemoryPort& memory);
  void iterate(Cycle now, const RayToken& issued, InFlight& entry, MemoryPort& memory);

  bool deliver(Cycle now, const InFlight& ray);
  bool fill(Cycle now);
  Cause enter_compute(Cycle now);
  void check_tags(Cycle now, const RayToken& issued);
  // Advances a ray past its empty block with the least corner `low`.
  void skip(RayState& ray, const Point& low);
  Termination after(const Interaction& interaction, const Point& position, RayUnderWay& ray, InFlight& entry);
  void splat_and_carry(const Interaction& interaction, RayUnderWay& ray, InFlight& entry);
  bool is_irradiance_at_host(std::size_t block) const {
    return !frame_->irradiance_at_host.empty() && frame_->irradiance_at_host[block] != 0;
  }
  void carry_to_host(const Interaction& interaction, const RayUnderWay& ray, InFlight& entry, Splat* work);
  [[gnu::noinline, gnu::cold]] void watch_carrier(std::uint32_t from, RayToken& carrier);
  bool writes_all_voxels() const { return splat_rule_ != v1::whole_units; }
  Splat& add_splat(std::uint32_t block, InFlight& entry);
  Splat& splat(std::uint32_t block, const Interaction& interaction, const RayState& from, InFlight& entry);
  RayToken carrier(const RayState& from, const Interaction& interaction, std::uint32_t block);
  Cell carrier_cell(const RayUnderWay& ray) const;
  bool tick_light(Cycle now);
  bool send_carrier(Cycle now);
  bool splat_waits(Cycle now) const;
  void begin_splat(Cycle now);
  void run_state(Archive& archive);
  void write_back(const TileOfBlock& changed, bool irradiance);
  void write(std::uint32_t block, std::uint32_t tile, bool irradiance);
  std::uint8_t ask(Cycle now, const Misses& misses, std::uint32_t number);
  // Whether irradiance words have their own packets, and rays of this frame may read or change them.
  bool packs_irradiance() const { return cells_.has_value() && frame_->accumulators == nullptr; }
  // Whether rays of this frame may do more than gather. With a trace, only reading irradiance from its own packets
  // counts.
  bool does_more_than_gather() const {
    return has_trace_ ? frame_->lit_by_irradiance && packs_irradiance() : !frame_->plain();
  }
  // Number of blocks that have packets.
  std::uint32_t packet_blocks() const { return static_cast<std::uint32_t>(partition_.max_blocks() * (cells_ ? 2 : 1)); }
  bool has_room_for_evictions() const { return write_policy_ != v1::write_back || writes_.room() >= 16; }
  // In memory, the irradiance of all blocks follows their voxels.
  std::uint32_t irradiance_of(std::uint32_t number) const {
    return number + static_cast<std::uint32_t>(partition_.max_blocks());
  }
  // Always inlined: GCC takes a function that only prefetches for one without effect, and removes its calls.
  [[gnu::always_inline]] void prefetch(const BlockView& view, const Point& position, const Point& low) const;
  Cause bubble(Cause upstream, std::size_t come) const;
  [[gnu::noinline, gnu::cold]] void report_iteration(Cycle now, const InFlight& entry, Termination how);
  [[gnu::noinline, gnu::cold]] void report_deposit(Cycle now, const RayToken& token);

  static Cause waiting_for(Delay delay) {
    switch (delay) {
      case Delay::kBank: return Cause::kBank;
      case Delay::kRefresh: return Cause::kRefresh;
      default: return Cause::kMiss;
    }
  }

  static constexpr std::size_t kMaxPackets = 8, kMaxCells = 8;  // packets of one neighbourhood, and of its irradiance
  static constexpr std::size_t kMany = kFifoPlaces + 1;         // more than can be returning to the sorter

  const std::uint8_t number_;
  const Partition& partition_;
  RayStore& rays_;
  RayWatch& watch_;
  const bool single_queue_;
  const bool ideal_memory_;
  const bool two_ports_;
  const v1::SplatRule splat_rule_;
  const v1::WritePolicy write_policy_;
  const Frame* frame_ = nullptr;
  BlockGrid grid_;
  std::size_t edge_ = 0;

  Fifo<RayToken> returned_{kFifoPlaces};
  Fifo<std::uint32_t> released_{kFifoPlaces};
  Fifo<RayToken> issue_{kFifoPlaces};
  Sorter sorter_;
  Stages stages_;
  Cycle compute_clock_ = 0;
  VolumeCache cache_;
  std::optional<VolumeCache> cells_;  // for irradiance, if it has its own packets
  MissQueue misses_;
  WriteQueue writes_;
  SplatUnit splats_;

  bool has_trace_ = false;
  bool does_more_ = false;  // does_more_than_gather()
  bool fed_ = false;        // a ray entered the prefetch line in this cycle
  bool backed_up_ = false;
  bool bubble_ = false;  // the compute line got nothing, although it was neither stalled nor waiting
  Cause latest_ = Cause::kQueueEmpty;
  // Causes if no ray entered the prefetch line, by the cycle's low bits, for at least as many cycles as the line has
  // stages.
  std::vector<Cause> unfed_;
  Cycle unfed_mask_;
  RayCounters counts_;
  CauseCounts causes_{};
  std::uint64_t holding_cycles_ = 0;
};

// Conditions below are combined without branches: they are hard to predict, and are evaluated every cycle.
inline bool Processor::holds_rays() const { return (sorter_.waiting() | issue_.size() | stages_.size()) != 0; }

inline Cause Processor::bubble(Cause upstream, std::size_t come) const {
  const std::uint64_t under_way = stages_.size() | returned_.size();
  const std::uint64_t to_be_sorted = sorter_.waiting() | issue_.size() | come;
  Cause cause = upstream;
  cause = under_way != 0 ? Cause::kLatency : cause;
  cause = to_be_sorted != 0 ? Cause::kSorter : cause;
  return backed_up_ ? Cause::kMiss : cause;
}

inline void Processor::account(Cycle now, Cause upstream, std::size_t come) {
  // An empty compute entry is due to the cycle in which nothing entered the prefetch line.
  const Cause unfed = unfed_[(now - stages_.prefetch_stages()) & unfed_mask_];
  latest_ = bubble_ ? unfed : latest_;
  ++causes_[static_cast<std::size_t>(latest_)];
  if (!fed_) unfed_[now & unfed_mask_] = bubble(upstream, come);
  holding_cycles_ += fed_ | holds_rays();
}

// Prefetches the voxels of the ray's next iteration into the host's cache.
inline void Processor::prefetch(const BlockView& view, const Point& position, const Point& low) const {
  if (view.densities == nullptr) return;  // backprojecting rays read no voxel
  const Cell at = cell(position, low);
  const std::int16_t* voxel = view.densities + at.voxel[0] + edge_ * (at.voxel[1] + edge_ * at.voxel[2]);
  __builtin_prefetch(voxel);
  __builtin_prefetch(voxel + edge_);
  __builtin_prefetch(voxel + edge_ * edge_);
  __builtin_prefetch(voxel + edge_ * edge_ + edge_);
}

}  // namespace gicube::emu
