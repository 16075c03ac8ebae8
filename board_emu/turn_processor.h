// One ray integration processor as the approximate level knows it: in turns instead of cycles.
//
// A turn is a ray's way from its queue through the pipeline and back. The processor works its turns off one after the
// other, in the order in which its queues give them, and finds for each when it enters the pipeline, when its packets are
// there, and when its ray is back: the rules of processor.h and sorter.h, without anything that ticks. Values are no matter
// here: how far a ray goes is known already.
//
// What is simplified: a queue's new importance is known as soon as the sorter takes it in, one a cycle; nothing holds up a ray
// that leaves but a link's rate. Processors that share a channel are not
// modelled: their packets alternate on it, and how often they close each other's rows hangs on the cycle.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "cache/volume_cache.h"
#include "frame.h"
#include "gicube/v1/board_config.pb.h"
#include "march.h"
#include "partition.h"
#include "rdram/channel.h"
#include "rdram/layout.h"
#include "sim/clock.h"
#include "sorter/exact_maximum.h"

namespace gicube::emu {

// First in first out, as long as it has to be.
template <typename Item>
class LongQueue {
 public:
  bool empty() const { return head_ == tail_; }
  std::size_t size() const { return tail_ - head_; }
  const Item& front() const { return ring_[head_ & mask_]; }
  void drop() { ++head_; }
  Item pop() { return ring_[head_++ & mask_]; }
  void push(const Item& item) {
    if (size() > mask_) [[unlikely]]
      grow();
    ring_[tail_++ & mask_] = item;
  }

 private:
  void grow() {
    std::vector<Item> larger(2 * ring_.size());
    for (std::size_t i = 0; i < ring_.size(); ++i) larger[i] = ring_[(head_ + i) & mask_];
    head_ = 0;
    tail_ = ring_.size();
    mask_ = larger.size() - 1;
    ring_.swap(larger);
  }

  std::vector<Item> ring_ = std::vector<Item>(16);
  std::size_t mask_ = 15;
  std::size_t head_ = 0, tail_ = 0;
};

// A ray under way. Of jittered rays `step` has the words from which each step is drawn.
struct TurnRay {
  Point position{};  // from its block's least corner
  Point step{};
  std::int32_t left = 0;  // steps to its end
  std::uint32_t block = 0;
};

// All rays under way, each in one place; what goes from part to part is its handle.
class TurnRays {
 public:
  std::uint32_t add(const TurnRay& ray) {
    if (free_.empty()) {
      free_.push_back(static_cast<std::uint32_t>(rays_.size()));
      rays_.emplace_back();
    }
    const std::uint32_t handle = free_.back();
    free_.pop_back();
    rays_[handle] = ray;
    return handle;
  }
  void remove(std::uint32_t handle) { free_.push_back(handle); }
  TurnRay& operator[](std::uint32_t handle) { return rays_[handle]; }

 private:
  std::vector<TurnRay> rays_;
  std::vector<std::uint32_t> free_;
};

// Direction, and place in the image: what a jittered step is drawn from.
inline Point drawn_from(const std::array<std::int16_t, 3>& direction, std::uint16_t u, std::uint16_t v) {
  return std::bit_cast<Point>(std::array<std::uint16_t, 6>{static_cast<std::uint16_t>(direction[0]),
                                                           static_cast<std::uint16_t>(direction[1]),
                                                           static_cast<std::uint16_t>(direction[2]), u, v, 0});
}

// A processor's RDRAM channel.
struct TurnMemory {
  TurnMemory(const v1::BoardConfig& config, const rdram::Layout& blocks)
      : layout(&blocks), channel(config.rdram(), blocks.devices()) {}

  const rdram::Layout* layout;  // must outlive it
  rdram::Channel channel;
  Cycle asked = 0;  // in which it took the last packet on
};

// A ray on its way to a queue, or to the DSP.
struct Coming {
  Cycle ready = 0;
  std::uint32_t ray = 0;    // handle
  std::uint32_t queue = 0;  // to the DSP: the processor that it comes from
  bool keeps_slot = false;
  bool overflowed = false;
};

struct TurnCounters {
  std::uint64_t leaps = 0;
  std::uint64_t overflows = 0, conflicts = 0;
  std::uint64_t activations = 0;
  std::uint64_t rays_sent = 0;  // over links
  std::uint64_t hops = 0;
  std::uint64_t held = 0;  // cycles in which a ray was in the queues or the pipeline
};

class TurnProcessor {
 public:
  // What it shares with others. All must outlive it.
  struct Surroundings {
    const v1::BoardConfig* config;
    const Partition* partition;
    std::array<int, 3> blocks;  // of the volume
    std::vector<std::unique_ptr<TurnProcessor>>* processors;
    TurnMemory* memory;
    TurnRays* rays;
    LongQueue<Coming>* up;  // to the DSP
  };

  TurnProcessor(std::uint8_t number, const Surroundings& surroundings);

  // All turns until the next call are of this frame, and none is before cycle `now`.
  void begin(Cycle now, const Frame& frame);
  void invalidate_cache() { cache_.invalidate(); }

  // The cycle of its next turn; kNoCycle if no ray waits or comes.
  Cycle next() const;
  // Works its turns off up to cycle `until`; with `bus_waits` no further than to the next ray that it takes off the bus.
  void work(Cycle until, bool bus_waits);
  // A ray from the DSP, or over a link from the left or right.
  enum class From : std::uint8_t { kBus, kLeft, kRight };
  void send(From from, const Coming& ray) {
    from_[static_cast<std::size_t>(from)].push(ray);
    others_ = std::min(others_, ray.ready);
  }

  // The DSP has taken a ray of this processor out of the merge tree.
  void taken_from_tree(Cycle now);

  // Rays on the bus' way into the sorter, and the cycle in which the sorter took the last.
  std::size_t from_bus() const { return from_[static_cast<std::size_t>(From::kBus)].size(); }
  bool holds_bus() const { return holds_bus_; }
  Cycle taken_from_bus() const { return taken_from_bus_; }

  const TurnCounters& counters() const { return counters_; }
  std::uint64_t turns() const { return turns_; }
  std::uint64_t samples() const { return turns_ - counters_.leaps; }
  const CacheCounters& cache() const { return cache_.counters(); }
  Cycle now() const { return now_; }

 private:
  void take_others(Cycle now, Cycle cycles, Cycle returned, std::uint32_t written);
  bool has_slot(std::uint32_t queue, Cycle now);
  void write(const Coming& ray);
  void take_in(Cycle now);
  bool choose(Cycle now);
  void turn(std::uint32_t queue);
  void glide(Cycle& now, Cycle& before, Cycle until);
  // When the packet is taken that must be before a sample enters, which may ask for as many as one can.
  Cycle oldest_taken() const { return taken_[(packets_ - room_ - 1) % kRemembered]; }
  Point drawn_step(const TurnRay& ray) const;
  [[gnu::noinline]] Cycle fetch(const TurnRay& ray, Cycle first);
  [[gnu::noinline]] std::int32_t leap(const TurnRay& ray, const Point& step);
  [[gnu::noinline]] void leave(std::uint32_t handle, std::uint32_t queue, Cycle out);
  [[gnu::noinline]] void change_block(std::uint32_t handle, std::uint32_t queue, Cycle out);
  void cross(const Home& home, Coming& ray, Cycle out);
  void hold(int rays, Cycle when);
  bool finds_place();

  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  const std::uint8_t number_;
  Surroundings with_;
  std::uint32_t prefetch_, compute_, capacity_, ratio_;
  int ratio_bits_;      // if it is a power of two
  std::uint32_t room_;  // packets that may be on their way when a sample enters
  Cycle link_cycles_;   // of a ray
  Cycle rac_latency_;
  Cycle to_dsp_;               // from the end of the pipeline or an overflow through the merge tree
  std::uint32_t tree_places_;  // on that way
  bool ideal_memory_;
  const Frame* frame_ = nullptr;
  bool jitter_ = false;
  const std::uint8_t* empty_ = nullptr;  // by block, if empty ones are leapt over
  BlockGrid grid_;
  int block_shift_ = 0;  // from positions to blocks
  std::uint32_t across_ = 0, slice_ = 0;

  std::vector<LongQueue<std::uint32_t>> queues_;  // handles
  std::vector<std::uint32_t> slots_;
  ExactMaximum most_;                  // by the importance that the sorter knows of
  LongQueue<std::uint32_t> modified_;  // queues whose new importance waits to be taken in, one a cycle
  std::vector<std::uint8_t> listed_;   // there
  std::uint32_t active_ = kNone;
  Cycle sorted_ = 0;  // up to which the sorter has taken in
  std::uint64_t waiting_ = 0;
  LongQueue<Coming> returned_;
  std::array<LongQueue<Coming>, 3> from_;
  std::uint32_t turn_ = 0;   // whose turn it is of them
  Cycle others_ = kNoCycle;  // when the first of them comes
  Cycle taken_from_bus_ = 0;
  bool holds_bus_ = false;
  LongQueue<std::pair<Cycle, std::uint32_t>> released_;  // when, and of which queue, a slot is given up
  VolumeCache cache_;

  Cycle now_ = 0;                                   // in which the last turn entered the pipeline
  Cycle computing_ = 0;                             // in which its sample went on to be resampled
  static constexpr std::size_t kRemembered = 1024;  // more than stages or packets there can be
  std::array<Cycle, kRemembered> started_{}, taken_{};
  std::uint64_t turns_ = 0, packets_ = 0;
  std::uint32_t in_tree_ = 0;         // rays between this processor and the DSP
  bool stands_ = false;               // until it is known when one finds a place there
  Cycle tree_free_ = 0;               // when the last such did
  std::array<Cycle, 2> link_free_{};  // to the right, to the left
  std::uint64_t holds_ = 0;           // rays
  Cycle held_since_ = 0;
  TurnCounters counters_;
};

}  // namespace gicube::emu
