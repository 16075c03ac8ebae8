// Rays in the DSP's memory that wait for blocks which are not on the card.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "datapath/bricks.h"
#include "datapath/scattering.h"
#include "gicube/archive.h"
#include "gicube/wire/forwarded_ray.h"

namespace gicube::emu {

// The commands that made the rays: one kRender, one kIlluminate, or the kTraces since the last command of another kind.
enum class WaitingKind : std::uint8_t { kPicture, kHostRays, kLight };

class WaitingRays : public WaitingRayQueue {
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
  void begin(WaitingKind kind, const wire::TraceHeader& header = {}) {
    waiting_ = {};
    continued_ = {};
    ended_ = {};
    before_ = first_ = next_ = 0;
    kind_ = kind;
    header_ = header;
    header_.count = 0;
    seen_.clear();
  }
  // The source of the next command has `count` rays; their numbers follow those of earlier commands.
  void number(std::uint64_t count) {
    continued_ = {};
    before_ = waiting_.size();
    first_ = next_;
    next_ += count;
  }
  // Number of the first ray of the command for which number() was last called.
  std::uint64_t first() const { return first_; }
  WaitingKind kind() const { return kind_; }
  const wire::TraceHeader& header() const { return header_; }
  // Whether a trace command with this header adds to the present rays.
  bool go_on_with(wire::TraceHeader header) const {
    header.count = 0;
    return kind_ == WaitingKind::kHostRays && header == header_;
  }

  void add(const WaitingRay& ray, std::uint64_t index) override {
    const std::lock_guard lock(mutex_);
    expect_room(1);
    WaitingRay& added = waiting_.emplace_back(ray);
    if (const WaitingRay* const before = find(index)) {
      added.number = before->number;
      added.home = before->home;
    } else if (kind_ == WaitingKind::kPicture) {
      added.number = std::uint32_t{ray.ray_state.v} << 16 | ray.ray_state.u;  // no two rays have the same (v, u)
    } else {
      added.number = first_ + index;
    }
  }
  // Adds a ray of another card that has ended. Thread-safe.
  void add_ended(const wire::EndedRay& ray) {
    const std::lock_guard lock(mutex_);
    ended_.push_back(ray);
  }
  const WaitingRay* find(std::uint64_t index) const override {
    return continued_.empty() ? nullptr : &continued_[static_cast<std::size_t>(index)];
  }

  // Only add(), add_ended() and find() may be called during a command. take_ready() removes the rays whose blocks are
  // resident again. They are sorted by number, so their order does not depend on threads and time.
  std::span<const WaitingRay> take_ready(const Frame& frame) {
    const auto waits = [&frame](const WaitingRay& ray) {
      return ray.trapped ? is_non_resident_for_routine(ray.block, frame) : is_non_resident(ray.block, frame);
    };
    const auto ready = std::partition(waiting_.begin(), waiting_.end(), waits);
    continued_.assign(ready, waiting_.end());
    waiting_.erase(ready, waiting_.end());
    before_ = waiting_.size();
    std::ranges::sort(continued_, {}, order_of<WaitingRay>);
    return continued_;
  }
  // The rays of the latest take_ready().
  std::span<const WaitingRay> continued() const { return continued_; }
  // Removes at most `most` rays that wait for `blocks` (ascending), in the order of home and number.
  std::vector<WaitingRay> take(std::span<const std::uint32_t> blocks, std::size_t most) {
    continued_ = {};
    std::ranges::sort(waiting_, {}, order_of<WaitingRay>);  // threads add them in any order
    std::vector<WaitingRay> out;
    std::erase_if(waiting_, [&](const WaitingRay& ray) {
      const bool taken = out.size() < most && std::ranges::binary_search(blocks, ray.block);
      if (taken) out.push_back(ray);
      return taken;
    });
    return out;
  }
  std::vector<wire::EndedRay> take_ended(std::size_t most) {
    std::ranges::sort(ended_, {}, order_of<wire::EndedRay>);
    const auto last = ended_.begin() + static_cast<std::ptrdiff_t>(std::min(most, ended_.size()));
    std::vector<wire::EndedRay> out(ended_.begin(), last);
    ended_.erase(ended_.begin(), last);
    return out;
  }
  std::size_t ended() const { return ended_.size(); }
  std::size_t count(std::span<const std::uint32_t> blocks) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        waiting_, [&](const WaitingRay& ray) { return std::ranges::binary_search(blocks, ray.block); }));
  }
  // Adds rays that waited on another card. Their number has the same limit as in add().
  void give(std::span<const WaitingRay> rays) {
    continued_ = {};
    expect_room(rays.size());
    waiting_.insert(waiting_.end(), rays.begin(), rays.end());
    before_ = waiting_.size();
  }
  // Material tags of the trapped rays, one bit each.
  std::uint32_t trapped_tags() const {
    std::uint32_t tags = 0;
    for (const WaitingRay& ray : waiting_) tags |= ray.trapped ? 1u << (ray.ray_state.flags >> kTrapTagShift) : 0;
    return tags;
  }
  std::size_t count() const { return waiting_.size(); }
  std::size_t added() const { return waiting_.size() - before_; }  // by the last command
  std::vector<wire::WaitingBlock> by_block() const {
    std::vector<std::pair<std::uint32_t, std::uint16_t>> rays;
    for (const WaitingRay& ray : waiting_) rays.push_back({ray.block, contribution(ray.ray_state)});
    std::ranges::sort(rays);
    std::vector<wire::WaitingBlock> out;
    for (const auto& [block, contribution] : rays) {
      if (out.empty() || out.back().block != block) out.push_back({block, 0, 0});
      ++out.back().rays;
      out.back().importance += contribution;
    }
    return out;
  }
  // Record that a ray has waited for a block, or that its words were sent to the card, since begin(). A block with both
  // had to be sent at least once. Both return whether this call completes the pair.
  bool note_wait(std::uint32_t block, std::size_t blocks) { return note(block, blocks, kWaitedFor); }
  bool note_load(std::size_t block, std::size_t blocks) { return note(block, blocks, kLoaded); }
  // `blocks`: number in the volume. `extent`: positions of the rays. `kept`: number of host rays in the DSP's memory.
  void state(Archive& archive, std::size_t blocks, const Point& extent, std::size_t kept) {
    archive.at_most("kind", kind_, WaitingKind::kLight);
    archive.field("commands", [this](Archive::Record& record) {
      record.at_most(header_.type, wire::RayType::kBackproject);
      record.at_most(header_.albedo, wire::Albedo::kHigh);
      record.at_most(header_.rules, wire::EnergyRules::kConserving);
      record.at_most(header_.words, wire::SumWords::kWhole);
      record.at_most(header_.opacity, wire::kOpacityOne);
      record(first_, next_);
    });
    archive.bytes("seen", seen_, 0, blocks);
    const auto check = [&](const std::vector<WaitingRay>& rays) {
      for (std::size_t i = 0; archive.loads() && i < rays.size(); ++i) {
        const bool has_place = rays[i].home != 0 || kind_ != WaitingKind::kHostRays ||
                               header_.type == wire::RayType::kDeposit || rays[i].number < kept;
        const bool fits = inside(rays[i].ray_state.position, extent) && rays[i].block < blocks && has_place;
        archive.expect(fits, "rays", "rays in the volume", i);
      }
    };
    archive.list("rays", waiting_);
    check(waiting_);
    archive.at_most("before", before_, waiting_.size());
    archive.list("continued", continued_);
    check(continued_);
    std::vector<std::uint8_t> ended;
    for (const wire::EndedRay& ray : ended_) wire::append(ended, ray);
    archive.bytes("ended", ended, 0, kMax * wire::kEndedRayBytes);
    if (!archive.loads()) return;
    ended_.clear();
    for (std::size_t at = 0; at + wire::kEndedRayBytes <= ended.size(); at += wire::kEndedRayBytes) {
      ended_.push_back(wire::decode<wire::EndedRay>(std::span(ended).subspan(at)));
    }
  }

 private:
  static constexpr std::uint8_t kWaitedFor = 1, kLoaded = 2;
  template <typename Ray>
  static std::pair<std::uint16_t, std::uint64_t> order_of(const Ray& ray) {
    return {ray.home, ray.number};
  }
  void expect_room(std::size_t more) const {
    if (waiting_.size() + more <= max_) return;
    throw RoutineFault("more than " + std::to_string(max_) + " rays wait for blocks" +
                       (max_ < kMax ? ", for which memory is left (gicube-board --max-memory)" : "") +
                       ": a smaller image or fewer rays would help");
  }
  bool note(std::size_t block, std::size_t blocks, std::uint8_t what) {
    seen_.resize(blocks);
    const std::uint8_t before = seen_[block];
    seen_[block] |= what;
    return before != seen_[block] && seen_[block] == (kWaitedFor | kLoaded);
  }

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
