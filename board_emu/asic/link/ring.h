// Narrow links between neighbouring processors, a ring with one link in each direction [P §2.1, §3.6].
//
//   out_links[i] -> entry queue -> link i, right -> from_left[i + 1], or the entry queue of link i + 1: it goes further
//                -> entry queue -> link i, left  -> from_right[i - 1], or ...
//
// A ray of 256 bits takes ceil(256 / bits) cycles per link and is passed on in the last of them; if the next queue is
// full, it stays and blocks the link. It takes the shorter path round the ring, to the right if both are equally long
// (two processors therefore use the right links only).
//
// Bubble flow control [C]: a ray in transit needs one free entry in the next queue. A ray that enters the ring needs
// two and yields to transit. One entry is therefore always free in each direction, and the ring cannot deadlock as long
// as the processors take the rays that arrive [H319].
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <vector>

#include "asic/sim/fifo.h"
#include "asic/sim/ray_event.h"
#include "gicube/archive.h"
#include "words/words.h"

namespace gicube::emu {

struct RingCounters {                   // for one processor's two links
  std::uint64_t sent = 0;               // rays that entered the ring here
  std::array<std::uint64_t, 2> rays{};  // hops over its link to the right, to the left
  std::uint64_t busy = 0;               // link cycles that moved bits
  std::uint64_t blocked = 0;            // link cycles in which a ray at the end was blocked
  std::uint64_t entry_waits = 0;        // cycles in which a ray of this processor could not enter

  std::uint64_t hops() const { return rays[0] + rays[1]; }
  void state(Archive::Record& record) { record(sent, rays, busy, blocked, entry_waits); }
};

class Ring {
 public:
  static constexpr std::uint32_t kPlacesToEnter = 2;  // bubble flow control

  // The FIFOs of one processor.
  struct Port {
    Fifo<RayToken>* out_links;  // rays for other processors; the destination is RayToken::processor
    Fifo<RayToken>* from_left;  // into its sorter
    Fifo<RayToken>* from_right;
  };

  // `bits` 1 .. 256: width of a link. `rays` >= 2: capacity of a link's entry queue.
  Ring(std::uint32_t bits, std::uint32_t rays, const std::vector<Port>& ports);

  Ring(const Ring&) = delete;  // links contain pointers to each other
  Ring& operator=(const Ring&) = delete;

  // Gets the events of traced rays; required if there are any.
  void set_listener(RayListener* listener) { listener_ = listener; }

  bool tick(Cycle now) {
    // Usually no ray is on a link or waits for one.
    std::size_t rays = inside_;
    for (const Port& port : ports_) rays |= port.out_links->size();
    return rays != 0 && work(now);
  }

  bool idle() const { return inside_ == 0; }
  std::uint64_t inside() const { return inside_; }
  std::uint32_t cycles_per_ray() const { return cycles_per_ray_; }
  const RingCounters& counters(std::uint32_t processor) const { return counters_[processor]; }
  // Rays that crossed the two cuts that halve the ring, in both directions.
  std::uint64_t bisection_rays() const;
  void dump(std::ostream& out) const;
  void state(Archive& archive) {
    archive.expect_idle(idle(), "the ring");
    archive("counters", counters_);
    if (!archive.in_run()) return;
    archive.field("links", [this](Archive::Record& record) {
      inside_ = 0;
      for (std::vector<Link>& links : links_) {
        for (Link& link : links) {
          record(link.entry);
          record.at_most(link.sent, cycles_per_ray_);
          inside_ += link.entry.size();
        }
      }
    });
  }

 private:
  enum Direction : std::uint8_t { kRight = 0, kLeft = 1 };
  struct Link {
    explicit Link(std::uint32_t rays) : entry(rays) {}

    Fifo<RayToken> entry;
    Fifo<RayToken>* arrival = nullptr;  // FIFO of the processor at its end
    Link* next = nullptr;               // the link that continues from there
    std::uint8_t end = 0;               // that processor
    std::uint32_t sent = 0;             // cycles that the ray at the entry's head has been on the link
  };

  bool work(Cycle now);
  bool advance(Link& link, Direction direction, RingCounters& counters, Cycle now);
  bool enter(std::uint32_t processor, Cycle now);
  Direction way(std::uint32_t from, std::uint32_t to) const;

  std::uint32_t cycles_per_ray_;
  std::vector<Port> ports_;
  std::array<std::vector<Link>, 2> links_;  // by direction and the processor that sends
  std::vector<RingCounters> counters_;
  std::uint64_t inside_ = 0;
  RayListener* listener_ = nullptr;
};

}  // namespace gicube::emu
