// Adds deposits from the pipeline's end to the irradiance words: it reads, adds and writes in the volume cache, sends
// changed tiles to the memory, and sends carriers to the neighbour blocks that hold copies of the voxels [P §3.4].
//
// A bank reads or writes one word per cycle, so a deposit occupies the cache for two cycles, in which no sample is
// read. With two ports it occupies the read port for one cycle, and then the write port [H960-H963].
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gicube/archive.h"
#include "words/clock.h"
#include "words/words.h"

namespace gicube::emu {

// The deposit of one sample that leaves the pipeline.
struct Splat {
  std::uint32_t block = 0;  // block whose words change
  std::uint8_t tiles = 0;   // changed tiles
  std::uint8_t carriers = 0;
  std::array<std::uint32_t, 8> tile{};
  std::array<RayToken, 8> carrier{};

  void state(Archive::Record& record) {
    record(block);
    record.at_most(tiles, 8);
    record.at_most(carriers, 8);
    for (std::size_t i = 0; i < tiles; ++i) record(tile[i]);
    for (std::size_t i = 0; i < carriers; ++i) record(carrier[i]);
  }
};

struct SplatCounters {
  std::uint64_t deposits = 0;
  std::uint64_t carriers = 0;  // sent
};

class SplatUnit {
 public:
  // A sample's splat is queued in parallel to its entry in the pipeline; entries leave in the order in which they
  // entered.
  explicit SplatUnit(std::size_t stages, unsigned ports = 1) : splats_(stages), cache_cycles_(ports == 1 ? 2 : 1) {}

  Splat& add() {
    Splat& splat = splats_[(head_ + count_++) % splats_.size()];
    splat.tiles = splat.carriers = 0;
    return splat;
  }
  const Splat& oldest() const { return splats_[head_]; }
  // Starts the oldest splat, when its entry leaves the pipeline.
  void begin(Cycle now) {
    current_ = splats_[head_];
    head_ = (head_ + 1) % splats_.size();
    --count_;
    next_ = 0;
    counters_.deposits += current_.tiles > 0 ? 1 : 0;
    if (current_.tiles > 0) busy_until_ = now + cache_cycles_;
  }

  bool takes_cache(Cycle now) const { return now < busy_until_; }
  // With two ports, occupies the write port.
  bool takes_write_port(Cycle now) const { return now == busy_until_; }
  bool busy(Cycle now) const { return takes_cache(now) || has_carrier(); }
  bool has_carrier() const { return next_ < current_.carriers; }
  const RayToken& carrier() const { return current_.carrier[next_]; }
  void sent_carrier() {
    ++next_;
    ++counters_.carriers;
  }
  const SplatCounters& counters() const { return counters_; }
  std::size_t waiting() const { return count_; }
  const Splat& waiting(std::size_t i) const { return splats_[(head_ + i) % splats_.size()]; }  // oldest first
  // For blocks with `tiles` tiles. Between runs no splat is active, but the last one may still occupy the cache.
  void state(Archive& archive, std::size_t blocks, std::size_t tiles) {
    archive.expect_idle(count_ == 0 && !has_carrier(), "the splat unit");
    archive.field("counters", [this](Archive::Record& record) {
      record(counters_.deposits, counters_.carriers);
      record.times(busy_until_);
    });
    if (!archive.in_run()) return;
    Splat rest;  // rest of the active splat, whose tiles are written
    rest.block = current_.block;
    for (std::size_t i = next_; i < current_.carriers; ++i) rest.carrier[rest.carriers++] = current_.carrier[i];
    archive.field("splats", [&](Archive::Record& record) {
      record.at_most(count_, splats_.size());
      record(rest);
      for (std::size_t i = 0; i < count_; ++i) {
        Splat& splat = splats_[(head_ + i) % splats_.size()];
        record(splat);
        bool fits = splat.block < blocks;
        for (std::size_t t = 0; t < splat.tiles; ++t) fits = fits && splat.tile[t] < tiles;
        record.expect(fits, "tiles of a block", splat.block);
      }
    });
    if (!archive.loads()) return;
    current_ = rest;
    next_ = 0;
  }

 private:
  std::vector<Splat> splats_;
  Cycle cache_cycles_;
  std::size_t head_ = 0;
  std::size_t count_ = 0;
  Splat current_;
  std::uint8_t next_ = 0;
  Cycle busy_until_ = 0;
  SplatCounters counters_;
};

}  // namespace gicube::emu
