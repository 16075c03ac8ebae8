// One processor's sorter: rays enter, wait in the queue of their block, and leave from the most important queue [P
// §3.2].
//
//   returned, from_bus, from_left, from_right -> at most two a cycle -> queues -> the active queue's head -> issue
//                                                         no slot: -> overflow
//
// A cycle has these steps, in this order: the insertion sorter compares; a released slot is freed; if no queue is
// active, the top rank's becomes active; one ray is issued; at most two are written; an empty active queue is
// deactivated; one modified queue is inserted. A ray that is written into an empty sorter is therefore issued in the
// next cycle, and one active queue follows another without a lost cycle while the ranks are settled.
//
// Two writes [P]: the bucketing logic runs at twice the clock, and each queue is an eDRAM of its own. Two rays for one
// queue conflict: the second waits and loses its turn. `returned` has priority, because the pipeline stalls behind it;
// the other inputs take turns. An input whose ray finds neither a slot nor room in `overflow` is skipped.
//
// Slots are explained in queues.h. The pipeline sets RayToken::has_reserved_slot on a ray that returns to its last
// queue; otherwise it clears the flag and pushes the old queue's number to `released`. A token kSlot on `overflow`
// reports a reserved slot to the DSP, which sets the flag on the ray that it sends to that slot [H301-H304].
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <iosfwd>
#include <optional>
#include <vector>

#include "asic/sim/fifo.h"
#include "asic/sim/ray_event.h"
#include "asic/sorter/insertion_sorter.h"
#include "asic/sorter/queues.h"
#include "gicube/archive.h"
#include "words/words.h"

namespace gicube::emu {

struct SorterSetup {
  std::uint8_t processor = 0;
  std::uint32_t queues = 128;    // N³ / n³ / p
  std::uint32_t capacity = 256;  // rays a queue
  v1::QueuePolicy policy = v1::most_rays;
  // The baseline of [P §5.1]: one queue of `capacity` rays in the order of their arrival. RayToken::queue has no effect
  // here. A ray that stays in the processor keeps its slot.
  bool single = false;
  bool ideal_queues = false;  // never full
  bool ideal_sorter = false;  // always has the most important queue
  // A ray from the bus waits for a slot instead of overflowing, and blocks the bus behind it. Rays from links still
  // overflow: if they waited too, processors could wait for each other. No slot is reserved for them, because they
  // return behind the ray that blocks the bus.
  bool bus_waits = false;
};

struct SorterInputs {
  Fifo<RayToken>& returned;  // from the processor's own pipeline
  Fifo<RayToken>& from_bus;
  Fifo<RayToken>& from_left;
  Fifo<RayToken>& from_right;
  Fifo<std::uint32_t>& released;  // numbers of queues whose slot a ray gave up
};

struct SorterOutputs {
  Fifo<RayToken>& issue;     // to the pipeline
  Fifo<RayToken>& overflow;  // to the merge tree: rays, state = kOverflowed, and kSlot
};

struct SorterCounters {
  std::uint64_t written = 0;         // rays into queues
  std::uint64_t conflicts = 0;       // second writes that were lost because both rays were for one queue
  std::uint64_t overflows = 0;       // rays that found no slot
  std::uint64_t reserved_slots = 0;  // reserved slots reported to the DSP
  std::uint64_t issued = 0;          // rays to the pipeline
  std::uint64_t activations = 0;     // queues that became active
  std::uint64_t inserts = 0;         // modified importances put into the insertion sorter
  std::uint64_t peak_waiting = 0;    // the most rays that waited in one queue
  // Activations by the rays issued in them: entry k counts 2^k .. 2^(k+1) - 1.
  std::array<std::uint64_t, 32> activation_rays{};
  std::array<std::uint64_t, 32> activation_issued{};  // the rays issued in them

  void state(Archive::Record& record) {
    record(written, conflicts, overflows, reserved_slots, issued, activations, inserts, peak_waiting, activation_rays,
           activation_issued);
  }
};

class Sorter {
 public:
  Sorter(const SorterSetup& setup, const SorterInputs& in, const SorterOutputs& out);

  // Gets the events of traced rays; required if there are any.
  void set_listener(RayListener* listener) { listener_ = listener; }

  // True if a ray, a slot or an importance moved. Here is only what an empty sorter needs, without a call.
  bool tick(Cycle now) {
    // Rays stay in a processor for many samples, so that mostly all three are empty.
    const bool others_come = (in_.from_bus.size() | in_.from_left.size() | in_.from_right.size()) != 0;
    const std::size_t rest = in_.returned.size() | in_.released.size() | queues_.waiting() | reserved_.size();
    return ((rest != 0) | others_come) && work(now, others_come);
  }

  // Equivalent to tick() in a cycle in which no ray arrives from other parts.
  bool tick_ahead(Cycle now) {
    const std::size_t rest = in_.returned.size() | in_.released.size() | queues_.waiting() | reserved_.size();
    return rest != 0 && work(now, false);
  }

  // Equivalent to tick_ahead() if each ray finds a slot, no slot is reserved and no ray is watched (sorter-inl.h). The
  // caller replaces the FIFOs: `returned` and `released` can be popped in this cycle, or are null; the issued ray is
  // appended to the `issued` ones in `issue`.
  bool tick_active_queue(const RayToken* returned, const std::uint32_t* released, RayToken* issue, std::size_t& issued);
  // Whether the configuration allows this.
  bool may_tick_active_queue() const { return ranks_.has_value() && !single_; }

  bool idle() const { return queues_.waiting() == 0 && reserved_.empty(); }
  bool has_reserved_slots() const { return !reserved_.empty(); }
  // Whether a ray that arrives at the queue after `others` further ones finds a slot.
  bool has_room(std::uint32_t queue, std::uint32_t others) const {
    return queues_.has_slots(single_ ? 0 : queue, others + 1);
  }
  // Whether a released slot would be reserved for an overflowed ray.
  bool would_reserve(std::uint32_t queue) const { return queues_.has_overflowed(single_ ? 0 : queue); }
  std::uint32_t queues() const { return queues_.count(); }
  std::uint64_t waiting() const { return queues_.waiting(); }  // rays in queues
  std::uint32_t waiting(std::uint32_t queue) const { return queues_.waiting(queue); }
  bool has_active() const { return active_ != kNone; }
  std::uint32_t active() const { return active_; }  // only if has_active(); 0 with a single queue
  // The queue that was activated last; 0 before the first.
  std::uint32_t latest_active() const { return latest_active_; }
  const SorterCounters& counters() const { return counters_; }
  // One fact per line.
  void dump(std::ostream& out) const;
  void state(Archive& archive);

 private:
  static constexpr std::uint32_t kNone = InsertionSorter::kNoQueue;
  static constexpr std::uint32_t kUnlisted = kNone - 1;

  // Modified queues in the order of their modification: a doubly linked list through the queues.
  struct Dirty {
    std::uint32_t previous = kNone;
    std::uint32_t next = kUnlisted;
  };

  // A cycle of a sorter that is not empty. `others_come`: one of others_ is not empty.
  bool work(Cycle now, bool others_come);
  std::uint32_t queue_of(const RayToken& token) const { return single_ ? 0 : token.queue; }
  void choose_active();
  void give_up_active();
  // Takes at most `turns` rays from others_, none to the queue `written` in this cycle.
  bool accept_others(Cycle now, std::uint32_t turns, std::uint32_t written);
  // Moves the ray at the input's head to its queue, which becomes `written`, or to overflow.
  bool take(Cycle now, Fifo<RayToken>& input, bool may_overflow, std::uint32_t& written);
  bool report_slot(Cycle now);
  void write(std::uint32_t queue, const RayToken& token);
  void modified(std::uint32_t queue);
  bool update_ranks();
  void report(Cycle now, RayStep step, const RayToken& token) const;
  void list_dirty(std::uint32_t queue);
  void unlist_dirty(std::uint32_t queue);

  std::uint8_t processor_;
  RayListener* listener_ = nullptr;
  bool single_;
  bool bus_waits_;
  SorterInputs in_;
  SorterOutputs out_;
  std::array<Fifo<RayToken>*, 3> others_;  // bus, left, right, in turns
  std::uint32_t turn_ = 0;
  std::uint32_t active_ = kNone;
  std::uint32_t latest_active_ = 0;
  std::uint64_t issued_since_active_ = 0;
  std::uint32_t dirty_head_ = kNone;
  std::uint32_t dirty_tail_ = kNone;
  Queues queues_;
  std::deque<std::uint32_t> reserved_;  // queues with a reserved slot that is not yet reported to the DSP
  std::optional<InsertionSorter> ranks_;
  std::optional<ExactMaximum> maximum_;  // ideal sorter or single queue: instead of ranks_
  std::vector<Dirty> dirty_;
  SorterCounters counters_;
};

}  // namespace gicube::emu
