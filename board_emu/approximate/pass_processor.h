// One ray integration processor as the approximate level models it: in passes instead of cycles.
//
// A pass takes a ray from its queue through the pipeline and back. The processor works its passes off one after the other,
// in the order in which its queues give them. For each it finds when the ray enters the pipeline, when its packets are there,
// and when it is back. The rules are those of cycle/processor.h and asic/sorter/sorter.h. No values are computed here: each
// ray's step count is an input.
//
// The rays of the active queue go round: out of the queue, through the pipeline, and back to the queue's end. They are kept
// in one line, in the order in which they are back; most passes take the first and put it at the end. Rays that return to
// other queues wait in a line of their own until their arrival matters.
//
// What a ray meets on its way (functional/trail.h) is an input too: splats, turns and traps.
//
// Simplified: the sorter knows a queue's new importance as soon as it takes it in, one a cycle. The merge tree's places are
// counted by processor. Between its events what a ray contributes falls by the same factor at each step.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "asic/cache/volume_cache.h"
#include "asic/cache/write_queue.h"
#include "asic/latencies.h"
#include "asic/partition.h"
#include "asic/sorter/insertion_sorter.h"
#include "asic/sorter/policies.h"
#include "datapath/frame.h"
#include "datapath/ray_step.h"
#include "gicube/v1/board_config.pb.h"
#include "memory/irradiance_memory.h"
#include "pass_counters.h"
#include "pass_memory.h"
#include "pass_rays.h"
#include "pass_tree.h"
#include "words/clock.h"

namespace gicube::emu {

class PassProcessor {
 public:
  // What it shares with others. All must outlive it.
  struct Shared {
    const v1::BoardConfig* config;
    const Partition* partition;
    std::array<int, 3> blocks;  // of the volume
    std::vector<std::unique_ptr<PassProcessor>>* processors;
    PassMemory* memory;
    PassRays* rays;
    PassTree* up;  // to the DSP
  };

  PassProcessor(std::uint8_t number, const Shared& shared);

  // Whether a frame's passes go event by event: its rays do more than gather, or a part is ideal, so that the pipeline is always full.
  static bool goes_by_events(const v1::BoardConfig& config, const Frame& frame);
  // All passes until the next call are of this frame, and none is before cycle `now`.
  void begin(Cycle now, const Frame& frame);
  void invalidate_cache() {
    cache_.invalidate();
    if (cells_) cells_->invalidate();
  }
  // Nothing is under way: what waits to be written goes to the memory. Returns the cycle in which that is done; 0 if nothing waits.
  Cycle finish_writes();

  // The cycle of its next pass; kNoCycle if no ray waits or comes.
  Cycle next() const;
  // Works its passes off up to cycle `until`; with `bus_waits` no further than to the next ray that it takes off the bus.
  void work(Cycle until, bool bus_waits);
  // From the DSP, or over a link from the left or right.
  enum class From : std::uint8_t { kBus, kLeft, kRight };
  void send(From from, const Arrival& ray) {
    from_[static_cast<std::size_t>(from)].push(ray);
    others_ = std::min(others_, ray.ready);
  }

  // Of a memory that it shares: when its next request was made, and that it is sent now.
  Cycle next_request() const {
    const Cycle write = writes_.all_sent() ? kNoCycle : writes_.next().asked;
    return reads_.empty() ? write : std::min(write, reads_.front().asked);
  }
  void send_request(Cycle now);

  // The DSP has taken a ray of this processor out of the merge tree.
  void taken_from_tree(Cycle now);

  // Rays on the bus' way into the sorter, and the cycle in which the sorter took the last.
  std::size_t from_bus() const { return from_[static_cast<std::size_t>(From::kBus)].size(); }
  bool holds_bus() const { return waits_[static_cast<std::size_t>(From::kBus)]; }
  Cycle taken_from_bus() const { return taken_from_[static_cast<std::size_t>(From::kBus)]; }

  const PassCounters& counters() const { return counters_; }
  std::uint64_t passes() const { return passes_; }
  std::uint64_t samples() const { return passes_ - counters_.leaps - counters_.carried; }
  const WriteCounters& writes() const { return writes_.counters(); }
  const CacheCounters& cache() const { return cache_.counters(); }
  Cycle now() const { return now_; }

  // Between two runs: no ray is here.
  void state(Archive& archive);

 private:
  // Three coordinates from the block's least corner, 14 fraction bits, in fields of 21 bits. Blocks have at most 64 voxels,
  // so that the highest bits of a field say that the ray is outside. Steps are added as they are: what they borrow from a
  // higher field makes it wrong only then.
  static constexpr int kField = 21;
  static constexpr std::int32_t kLongStep = 1 << (kField - 1);  // more than a block
  static std::uint64_t packed(const Point& at) {
    const auto field = [&at](std::size_t axis) {
      return static_cast<std::uint64_t>(std::int64_t{at[axis]}) << kField * axis;
    };
    return field(0) + field(1) + field(2);
  }
  static Point unpacked(std::uint64_t at) {
    const auto field = [at](int axis) { return static_cast<std::int32_t>(at >> kField * axis & ((1u << kField) - 1)); };
    return {field(0), field(1), field(2)};
  }
  // A ray in a queue, or on its way back to one.
  struct QueuedRay {
    std::uint64_t at = 0;
    std::uint64_t step = 0;  // if all are alike
    Cycle ready = 0;         // when it is in the queue
    std::uint32_t ray = 0;   // its handle
    std::int32_t left = 0;   // steps
  };
  // One on its way to a queue that is not the active one, or was not.
  struct Returning {
    QueuedRay ray;
    std::uint32_t queue = 0;
    bool keeps_slot = false;
  };

  // A ray that has left the pipeline for another processor, or waits at a link's entry.
  struct Crossing {
    Cycle at = 0;
    std::uint8_t to = 0;
    Arrival ray;
  };
  // Of a link. What comes over a link to the right comes from the left.
  enum Direction : std::uint8_t { kRight, kLeft };
  struct Link {
    LongQueue<Crossing> entry;
    Cycle left = 0;        // when the last ray left it
    bool blocked = false;  // its first ray has no place to go to

    void state(Archive::Record& record) { record(left, blocked); }
  };

  struct PacketRead {
    Cycle asked = 0;
    std::uint32_t queue = 0, tile = 0;
  };
  // A ray between the sorter and the pipeline.
  struct Issued {
    QueuedRay ray;
    std::uint32_t queue = 0, block = 0;
  };
  // A pass in the pipeline of frames with events.
  struct OnLine {
    QueuedRay ray;           // where it samples, and the steps that it then has left
    std::uint64_t next = 0;  // where it is then, if it is in the block
    Point to{};              // or else, from the block's corner
    // When it has passed the stages that it is in; of those that compute, without the cycles in which the line stands.
    Cycle due = 0;
    std::uint32_t queue = 0, block = 0;
    std::uint32_t packets = 0;  // that it waits for
    bool sampled = false;
    bool goes_out = false;  // of its block
    bool leaves = false;    // for another processor
  };

  // In the order in which they are back: carriers leave after the ray that sends them, when others may have left already.
  void comes_back(const Returning& next) {
    std::size_t place = returned_.end();
    while (place != returned_.begin() && returned_[place - 1].ray.ready > next.ray.ready) --place;
    returned_.insert(place, next);
    ++returning_[next.queue];
  }
  // Of the pipeline, when each kind is next; kNoCycle if that is not known yet.
  struct LineEvents {
    Cycle out, slot, entry, write;

    Cycle first() const { return std::min({out, slot, entry, write}); }
  };
  LineEvents line_events() const;
  Cycle next_in_line() const;
  Cycle next_slot() const;
  Cycle run_line(Cycle until);
  void come_out(Cycle out);
  void enter(const Issued& issued, Cycle now);
  void take_slot_of_line(Cycle slot);
  std::size_t owner_of_next_packet() const;
  Cycle next_fill() const;
  void fill(Cycle now);
  Cycle next_entry() const;
  bool leaps_over(const QueuedRay& ray, std::uint32_t block) const;
  std::uint32_t check(VolumeCache& cache, const Issued& issued, Cycle now, bool irradiance);
  std::uint32_t ask(const Misses& misses, std::uint32_t queue, Cycle now);
  void rotate_line(Cycle& ends, Cycle until);
  bool line_is_full() const {
    return line_.end() - computing_from_ >= prefetch_ || arrivals_.size() + reads_.size() > room_;
  }
  bool line_stands() const { return stalled_ || link_stalled_; }
  void send_write(Cycle now);
  void send_writes(Cycle now);
  Cycle room_from(Cycle now);
  Point corner_of(std::uint32_t block) const;
  Deposit amount_at(Point place, std::uint32_t block, std::int32_t amount) const;
  SharingBlocks blocks_of(const Deposit& deposit, std::uint32_t block) const;
  Cycle splat(const Deposit& deposit, const OnLine& from, bool carries, Cycle out);
  void change(const OnLine& from, std::uint32_t tile);
  bool packs_irradiance() const { return cells_.has_value() && !leaves_sums_; }
  std::uint32_t irradiance_of(std::uint32_t queue) const {  // behind the voxels of all blocks
    return queue + static_cast<std::uint32_t>(shared_.partition->max_blocks());
  }
  void write_back(const TileOfBlock& changed, bool irradiance);
  void carry(const Deposit& deposit, std::uint32_t block, Cycle when);
  bool meets_event(OnLine& pass, Cycle& out);
  // A step of a block or more leaves it, however long it is.
  static Point field_step(const Point& step) {
    Point out{};
    for (std::size_t axis = 0; axis < 3; ++axis) out[axis] = std::clamp(step[axis], -kLongStep, kLongStep);
    return out;
  }

  // The blocks of processors that share a memory alternate there.
  std::uint32_t in_memory(std::uint32_t block) const { return block * sharing_ + number_ % sharing_; }
  Cycle take_returned(Cycle now, Cycle since, std::uint32_t& written);
  void take_others(Cycle now, Cycle cycles, Cycle returned, std::uint32_t written);
  bool has_slot(std::uint32_t queue, Cycle now);
  bool take_slot(std::uint32_t handle, std::uint32_t queue, Cycle ready);
  void overflow(std::uint32_t handle, std::uint32_t queue, Cycle ready);
  void keep_slot(std::uint32_t queue, Cycle when);
  void write(const QueuedRay& ray, std::uint32_t queue);
  void take_in(Cycle now);
  bool choose(Cycle now);
  void find_block();
  void activate(std::uint32_t queue, Cycle now);
  void put_back(Cycle now);
  Cycle arrive(Cycle now, Cycle before);
  QueuedRay queued_ray(std::uint32_t handle, Cycle ready) const;
  std::uint64_t contribution_of(const QueuedRay& ray) const;
  void put(const QueuedRay& ray, std::size_t block);
  template <bool kAlike, bool kPlain>
  void rotate(Cycle& now, Cycle until);
  bool goes_to_dsp(std::uint32_t handle) const;
  [[gnu::noinline]] bool pass_out(Cycle& now);
  // When the packet is taken that must be before a sample enters, which may ask for as many as one can.
  Cycle oldest_taken() const { return taken_[(packets_ - room_ - 1) % kRemembered]; }
  [[gnu::noinline]] Cycle fetch(const Misses& misses, Cycle first);
  Cycle own_return() const;
  std::uint32_t distance_of(const QueuedRay& ray, const Point& corner) const;
  Point step_of(const QueuedRay& ray, const Point& corner) const;
  FinePoint fine_step_of(const QueuedRay& ray, const Point& corner) const;
  std::uint64_t next_place(const QueuedRay& ray, Rest& rest) const;
  Cycle arrival(Cycle data_end) const;
  std::uint32_t block_at(std::uint32_t block, const Point& at) const;
  void finish(std::uint32_t handle, std::uint32_t queue, Cycle out);
  void change_block(QueuedRay ray, std::uint32_t queue, std::uint32_t block, Point at, Cycle out);
  Cycle retry(Cycle now) const;
  Cycle next_gap(Cycle now);
  void release(std::uint32_t queue, Cycle out);
  void enter_links();
  void feed_on(Direction way);
  void run_link(Direction way);
  bool pass_on(Direction way);
  PassProcessor& neighbour(Direction way) const;
  Direction way_to(std::uint8_t processor) const;
  void line_goes_on(Cycle moved);
  // No ray can enter, and it is not known yet when one can.
  bool stalled() const {
    if (!by_events_) return line_stands();
    const bool waits_for_shared_memory = !reads_.empty() && next_in_line() == kNoCycle;
    return issued_.size() >= kFifoPlaces && ((line_stands() && line_is_full()) || waits_for_shared_memory);
  }
  // More rays than there are places have come out of the pipeline.
  bool stalls_for_link(Cycle now) {
    link_stalled_ = out_.size() > kLeaving && out_[out_.begin() + kLeaving].at <= now;
    return link_stalled_;
  }
  void hold(int rays, Cycle when);
  bool finds_place();

  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::size_t kLeaving = kFifoPlaces;  // rays between the pipeline and the links

  const std::uint8_t number_;
  Shared shared_;
  std::uint32_t prefetch_, compute_, capacity_, sharing_;
  ClockRatio to_memory_, to_core_;
  std::uint32_t room_;         // packets that may be on their way when a sample enters
  Cycle link_cycles_;          // of a ray
  std::uint32_t link_rays_;    // places at a link's entry
  Cycle memory_latency_;       // clocks from the last data to the fill queue
  Cycle to_dsp_;               // from the end of the pipeline or an overflow through the merge tree
  std::uint32_t tree_places_;  // on that way
  bool ideal_memory_;
  const Frame* frame_ = nullptr;
  bool jitter_ = false, wide_ = false;
  bool by_events_ = false;                                  // goes_by_events()
  bool leaves_sums_ = false;                                // they leave amounts in sums
  bool writes_all_voxels_;                                  // of a deposit
  bool writes_back_;                                        // tiles when they leave the cache
  bool combines_;                                           // writes of one tile
  bool short_steps_ = false;                                // each fits in its fields
  bool packs_steps_ = false;                                // and all of a ray are alike
  std::uint64_t outside_ = 0;                               // bits of a packed place that is not in the block
  void (PassProcessor::*rotate_)(Cycle&, Cycle) = nullptr;  // for the frame and the cache
  const std::uint8_t* empty_ = nullptr;                     // by block, if empty ones are leapt over
  BlockGrid grid_;
  int block_shift_ = 0;  // from positions to blocks
  std::uint32_t across_ = 0, slice_ = 0;

  std::vector<LongQueue<QueuedRay>> queues_;
  std::vector<std::uint32_t> slots_;
  std::vector<std::uint32_t> overflowed_;  // rays of each queue that no slot is kept for yet
  ExactMaximum importance_;                // by the importance that the sorter knows of
  ImportanceOf importance_of_;
  bool by_contribution_;                      // of a queue's rays
  std::vector<std::uint64_t> contributions_;  // their sums
  bool ideal_sorter_;
  std::vector<std::uint32_t> opened_;  // when each got the first of its rays, by number
  std::uint32_t openings_ = 0;
  LongQueue<std::uint32_t> modified_;  // queues whose new importance waits to be taken in, one a cycle
  std::vector<std::uint8_t> listed_;   // there
  std::uint32_t active_ = kNone;
  bool resting_ = false;                  // it was empty since it became active: any other may take its place
  std::uint32_t block_ = 0;               // its
  Point corner_{};                        // of that
  LongQueue<QueuedRay> active_rays_;      // its rays, those that are in the pipeline behind those that wait
  std::size_t arrived_ = 0;               // the number of the first in the pipeline, as far as it was asked for
  Cycle sorted_ = 0;                      // up to which the sorter has taken in
  std::uint64_t waiting_ = 0;             // in all other queues
  LongQueue<Returning> returned_;         // from the pipeline to other queues
  std::vector<std::uint32_t> returning_;  // how many of them, by queue
  std::array<LongQueue<Arrival>, 3> from_;
  std::uint32_t next_input_ = 0;                         // which of them is asked first
  Cycle others_ = kNoCycle;                              // when the first of them comes
  std::array<Cycle, 3> taken_from_{};                    // when the last of each was
  std::array<bool, 3> waits_{};                          // its first has to wait
  LongQueue<std::pair<Cycle, std::uint32_t>> released_;  // when, and of which queue, a slot is given up
  VolumeCache cache_;
  std::optional<VolumeCache> cells_;  // of irradiance, if it is in packets of its own
  // Of frames with events: the pipeline, the oldest first.
  LongQueue<Issued> issued_;
  LongQueue<OnLine> line_;
  std::size_t computing_from_ = 0;      // the number of the first that has not begun to be resampled
  LongQueue<Cycle> arrivals_;           // of packets that are not in the cache yet
  LongQueue<PacketRead> reads_;         // and of those that a shared memory is asked for
  Cycle entered_ = 0, room_since_ = 0;  // when the last entered, and when a full line had room again
  Cycle stood_ = 0;                     // cycles in which the line stood
  Cycle free_to_compute_ = 0;           // before that nothing begins to be resampled
  Cycle last_out_ = 0;                  // when the last came out
  Cycle link_free_ = 0;                 // when the last that waited for a link went on
  Cycle splat_free_ = 0;                // when the splat unit has done with the last
  const bool two_ports_;                // of the cache's banks
  const Cycle splat_cycles_;            // in which no sample is read
  Cycle fill_free_ = 0;                 // two ports: before that no packet is written
  WriteQueue writes_;
  Cycle changed_ = 0;  // when the last tile did

  Cycle before_ = 0;                                // up to which the sorter has written
  Cycle now_ = 0;                                   // in which the last pass entered the pipeline
  Cycle computing_ = 0;                             // in which its sample went on to be resampled
  static constexpr std::size_t kRemembered = 1024;  // more than stages or packets there can be
  std::array<Cycle, kRemembered> started_{}, taken_{};
  std::uint64_t passes_ = 0, packets_ = 0;
  std::uint32_t in_tree_ = 0;  // rays between this processor and the DSP
  bool stalled_ = false;       // the pipeline, until it is known when one finds a place there
  Cycle tree_free_ = 0;        // when the last such did
  LongQueue<Crossing> out_;    // from the pipeline to the links
  bool link_stalled_ = false;  // the pipeline, until it is known when the first of them goes on
  bool out_blocked_ = false;   // no place for it at a link's entry
  std::array<Link, 2> links_;
  std::uint64_t holds_ = 0;  // rays
  Cycle held_since_ = 0, held_until_ = 0;
  PassCounters counters_;
};

inline Cycle PassProcessor::next() const {
  if (stalled()) return others_ == kNoCycle ? kNoCycle : std::max(others_, now_ + 1);
  Cycle first = waiting_ > 0 ? now_ + 1 : others_;
  if (by_events_) first = std::min(first, next_in_line());
  if (!active_rays_.empty()) first = std::min(first, active_rays_.front().ready);
  if (!returned_.empty()) first = std::min(first, returned_.front().ray.ready);
  return first == kNoCycle ? first : std::max(first, now_ + 1);
}

}  // namespace gicube::emu
