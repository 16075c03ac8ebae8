// Rays in the DSP's memory that wait for blocks which are not on the card.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "datapath/ray_step.h"
#include "gicube/archive.h"
#include "gicube/wire/forwarded_ray.h"

namespace gicube::emu {

// The commands that made the rays: one kRender, one kIlluminate, or the kTraces since the last command of another kind.
enum class WaitingKind : std::uint8_t { kPicture, kHostRays, kLight };

struct WaitingRay {
  RayState ray_state{};
  std::uint64_t number = 0;  // index among the rays of its commands; they continue in this order
  std::uint32_t block = 0;
  std::uint16_t home = 0;  // 0: this card made it; otherwise the maker's name (wire::ForwardedRay)
  bool trapped = false;    // also waits for a routine's answer, which needs the sample at this position

  void state(Archive::Record& record) { record(ray_state, number, block, home, trapped); }
};

class WaitingRays {
 public:
  static constexpr std::size_t kMax = std::size_t{1} << 24;  // chosen: 512 MB of packets in the DSP's SDRAM

  // Upper limit of host memory per ray. While a list grows, it exists twice, and the larger copy is half empty.
  // Continued rays are in another list as well.
  static constexpr std::uint64_t kBytesOfRay = 4 * sizeof(WaitingRay);

  // Sets how many bytes of host memory are available for rays.
  void set_room(std::uint64_t bytes) { max_ = std::min<std::uint64_t>(bytes / kBytesOfRay, kMax); }
  std::uint64_t memory_bytes() const {
    return (waiting_.capacity() + continued_.capacity()) * sizeof(WaitingRay) +
           ended_.capacity() * sizeof(wire::EndedRay);
  }

  // Discards all rays. `header`: for kHostRays the command's; for kLight its type and rules.
  void begin(WaitingKind kind, const wire::TraceHeader& header = {});
  // The source of the next command has `count` rays; their numbers follow those of earlier commands.
  void number(std::uint64_t count) {
    continued_ = {};
    before_ = waiting_.size();
    first_ = next_;
    next_ += count;
  }
  WaitingKind kind() const { return kind_; }
  const wire::TraceHeader& header() const { return header_; }
  // Whether a trace command with this header adds to the present rays.
  bool go_on_with(wire::TraceHeader header) const {
    header.count = 0;
    return kind_ == WaitingKind::kHostRays && header == header_;
  }

  // Takes ray `index` of the run's source. Thread-safe. Throws RoutineFault if there are too many.
  void add(const WaitingRay& ray, std::uint64_t index);
  // Adds a ray of another card that has ended. Thread-safe.
  void add_ended(const wire::EndedRay& ray) {
    const std::lock_guard lock(mutex_);
    ended_.push_back(ray);
  }
  // Ray `index` of the run's source as it was when it began to wait; null: it starts.
  const WaitingRay* find(std::uint64_t index) const {
    return continued_.empty() ? nullptr : &continued_[static_cast<std::size_t>(index)];
  }

  // Only add(), add_ended() and find() may be called during a command. take_ready() removes the rays whose blocks are
  // resident again. They are sorted by number, so their order does not depend on threads and time.
  std::span<const WaitingRay> take_ready(const Frame& frame);
  // The rays of the latest take_ready().
  std::span<const WaitingRay> continued() const { return continued_; }
  // Removes at most `most` rays that wait for `blocks` (ascending), in the order of home and number.
  std::vector<WaitingRay> take(std::span<const std::uint32_t> blocks, std::size_t most);
  std::vector<wire::EndedRay> take_ended(std::size_t most);
  // Adds rays that waited on another card. Their number has the same limit as in add().
  void give(std::span<const WaitingRay> rays);

  std::size_t count() const { return waiting_.size(); }
  std::size_t count(std::span<const std::uint32_t> blocks) const;
  std::size_t added() const { return waiting_.size() - before_; }  // by the last command
  std::size_t ended() const { return ended_.size(); }
  // Material tags of the trapped rays, one bit each.
  std::uint32_t trapped_tags() const;
  std::vector<wire::WaitingBlock> by_block() const;

  // Record that a ray has waited for a block, or that its words were sent to the card, since begin(). A block with both
  // had to be sent at least once. Both return whether this call completes the pair.
  bool note_wait(std::uint32_t block, std::size_t blocks) { return note(block, blocks, kWaitedFor); }
  bool note_load(std::size_t block, std::size_t blocks) { return note(block, blocks, kLoaded); }

  // `blocks`: number in the volume. `extent`: positions of the rays. `kept`: number of host rays in the DSP's memory.
  void state(Archive& archive, std::size_t blocks, const Point& extent, std::size_t kept);

 private:
  static constexpr std::uint8_t kWaitedFor = 1, kLoaded = 2;
  void expect_room(std::size_t more) const;
  bool note(std::size_t block, std::size_t blocks, std::uint8_t what);

  std::mutex mutex_;  // for waiting_ and ended_
  std::vector<WaitingRay> waiting_;
  std::vector<WaitingRay> continued_;  // rays of the current command
  std::vector<wire::EndedRay> ended_;  // rays of other cards, until their hosts fetch them
  std::size_t before_ = 0;             // number of rays that continue to wait
  std::size_t max_ = kMax;             // maximum number of rays
  WaitingKind kind_ = WaitingKind::kPicture;
  wire::TraceHeader header_;
  std::uint64_t first_ = 0, next_ = 0;  // first number of the current command, and first unused number
  std::vector<std::uint8_t> seen_;      // one per block
};

}  // namespace gicube::emu
