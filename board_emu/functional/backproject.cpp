#include "backproject.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <limits>
#include <memory>
#include <vector>

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "functional/simd/splat_pieces.h"
#include "gicube/parallel_for.h"
#include "memory/accumulator_memory.h"

namespace gicube::emu {

namespace {

// A ray that waits to be splatted.
struct alignas(32) PendingRay {
  Point position{}, step{};
  std::int32_t amount = 0;
  std::uint32_t moves = 0;  // upper bound of the change of a word
};
struct PendingRest {
  Rest position{}, step{};
};

// The range of a waiting ray's samples in one tile.
class Part {
 public:
  Part(std::size_t ray, std::int32_t first, std::int32_t count)
      : bits_(std::uint64_t{ray} << 2 * kBits | static_cast<std::uint64_t>(first) << kBits |
              static_cast<std::uint64_t>(count - 1)) {}
  std::size_t ray() const { return bits_ >> 2 * kBits; }
  std::int64_t first() const { return static_cast<std::int64_t>(bits_ >> kBits & kMask); }
  std::uint32_t count() const { return static_cast<std::uint32_t>(bits_ & kMask) + 1; }

 private:
  static constexpr int kBits = 18;  // for a segment's samples
  static constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;
  static_assert(wire::kMaxLength / wire::kStepMin <= kMask + 1);
  std::uint64_t bits_;
};

// Divides the volume into tiles, which are slabs of blocks.
class Tiles {
 public:
  explicit Tiles(const AccumulatorMemory& accumulators)
      : blocks_(accumulators.blocks()),
        tile_{.across = static_cast<std::size_t>(accumulators.block_voxels()),
              .depth = depth(accumulators.block_voxels())} {
    const int bits = std::countr_zero(tile_.across) + wire::kPositionFractionBits;
    slab_bits_ = std::countr_zero(slabs());
    shift_ = {bits, bits, std::countr_zero(tile_.depth) + wire::kPositionFractionBits};
  }

  const Tile& tile() const { return tile_; }
  // Tiles of one height have consecutive indices.
  std::size_t layer() const { return count_of(0) * count_of(1); }
  std::size_t layers() const { return count_of(2) * slabs(); }
  std::size_t tile_at(const Point& at) const { return index(at, at[2]); }
  std::size_t block_at(const Point& at) const { return index(at, at[2] >> slab_bits_); }  // without a division
  std::size_t block_of(std::size_t tile) const { return tile % layer() + layer() * (tile / layer() / slabs()); }
  // Index of a tile within its block.
  std::size_t slab_of(std::size_t tile) const { return tile / layer() % slabs(); }
  // Shift from positions to tile coordinates along an axis.
  int shift(std::size_t axis) const { return shift_[axis]; }
  // A tile's corner with the least coordinates.
  Point corner(std::size_t tile) const {
    return {static_cast<std::int32_t>(tile % count_of(0)) << shift_[0],
            static_cast<std::int32_t>(tile % layer() / count_of(0)) << shift_[1],
            static_cast<std::int32_t>(tile / layer()) << shift_[2]};
  }

 private:
  // chosen: the cells, 32 bytes each, fit into a core's second-level cache, and rays of a view turning about z are
  // seldom cut.
  static std::size_t depth(int voxels) {
    const auto n = static_cast<std::size_t>(voxels);
    return std::clamp<std::size_t>((std::size_t{1} << 13) / (n * n), 1, n);
  }
  std::size_t count_of(std::size_t axis) const { return static_cast<std::size_t>(blocks_[axis]); }
  std::size_t index(const Point& at, std::int32_t z) const {
    return static_cast<std::size_t>(at[0]) +
           count_of(0) * (static_cast<std::size_t>(at[1]) + count_of(1) * static_cast<std::size_t>(z));
  }
  std::size_t slabs() const { return tile_.across / tile_.depth; }  // per block

  std::array<int, 3> blocks_;
  Tile tile_;
  std::array<int, 3> shift_{};
  int slab_bits_ = 0;
};

// Calls part(tile, first, count), tile by tile, for the first `left` samples of a ray, which are in the volume.
// `below`: fraction bits below a position's unit.
template <typename Word>
void cut(const std::array<Word, 3>& begin, const std::array<Word, 3>& step, std::int32_t left, const Tiles& tiles,
         int below, const auto& part) {
  Point tile{};
  std::array<std::int32_t, 3> until{};  // the first sample in another tile along this axis
  const auto enter = [&](std::size_t axis, std::int32_t sample) {
    const int shift = tiles.shift(axis) + below;
    const Word at = begin[axis] + sample * step[axis], one = step[axis], size = Word{1} << shift, in = at & (size - 1);
    tile[axis] = static_cast<std::int32_t>(at >> shift);
    const Word steps = one > 0 ? (size - in + one - 1) / one : one < 0 ? in / -one + 1 : left;
    until[axis] = static_cast<std::int32_t>(std::min<Word>(sample + steps, left));
  };
  for (std::size_t axis = 0; axis < 3; ++axis) enter(axis, 0);
  for (std::int32_t first = 0; first < left;) {
    const std::int32_t end = std::min({until[0], until[1], until[2]});
    part(tile, first, end - first);
    for (std::size_t axis = 0; axis < 3 && end < left; ++axis) {
      if (until[axis] == end) enter(axis, end);
    }
    first = end;
  }
}

// Number of the ray's remaining samples that are in the volume.
std::int32_t samples_inside(const RayState& ray, const Frame& frame) {
  if (!inside(ray.position, frame.extent)) return 0;
  return frame.wide ? steps_inside(ray.fine_position(), ray.fine_step(), fine_extent(frame.extent), ray.steps_left())
                    : steps_inside(ray.position, ray.step, frame.extent, ray.steps_left());
}

// The rays that one thread has cut, and their effect on the blocks' words in one command.
struct Cut {
  std::vector<PendingRay> rays;
  std::vector<PendingRest> rests;        // wide datapath only
  std::vector<std::vector<Part>> parts;  // by tile
  std::vector<std::uint64_t> moves;      // by block: upper bound of the change of a word
  std::size_t parts_count = 0;
  RayCounters counters;

  std::size_t bytes() const {
    return rays.size() * sizeof(PendingRay) + rests.size() * sizeof(PendingRest) + parts_count * sizeof(Part);
  }
};

// Cuts a ray into parts. Returns its number of samples.
std::int32_t take(const wire::Ray& packet, const Frame& frame, const Tiles& tiles, Cut& out) {
  const RayState ray = unpack(packet, frame);
  const std::int32_t left = samples_inside(ray, frame), amount = ray.amount();
  ++out.counters.rays;
  out.counters.samples += static_cast<std::uint64_t>(left);
  out.counters.energy.deposited.kept += static_cast<std::uint64_t>(std::int64_t{amount} * left);
  if (left == 0 || amount == 0) return left;
  const std::uint64_t moves = wire::max_moved(static_cast<std::uint32_t>(std::abs(amount)),
                                              static_cast<std::uint32_t>(packet.colour_word()), frame.step);
  const std::size_t index = out.rays.size();
  out.rays.push_back({ray.position, ray.step, amount, static_cast<std::uint32_t>(moves)});
  const auto part = [&](const Point& tile, std::int32_t first, std::int32_t count) {
    out.moves[tiles.block_at(tile)] += moves;
    std::vector<Part>& parts = out.parts[tiles.tile_at(tile)];
    if (parts.size() == parts.capacity()) parts.reserve(parts.size() + parts.size() / 4 + 16);  // saves memory
    parts.emplace_back(index, first, count);
    ++out.parts_count;
  };
  if (frame.wide) {
    out.rests.push_back({ray.rest, ray.step_rest});
    cut(ray.fine_position(), ray.fine_step(), left, tiles, kRestBits, part);
  } else {
    cut(ray.position, ray.step, left, tiles, 0, part);
  }
  return left;
}

// Writes in place: a copy of words that were just written in smaller parts would stall.
void make_piece(const Cut& cut, const Part& part, const Point& corner, Piece& out) {
  const PendingRay& ray = cut.rays[part.ray()];
  const auto first = part.first();
  out.count = part.count();
  out.amount = ray.amount;
  if (cut.rests.empty()) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.first[axis] = ray.position[axis] + static_cast<std::int32_t>(first) * ray.step[axis] - corner[axis];
      out.step[axis] = ray.step[axis];
    }
    return;
  }
  out.wide = true;
  const PendingRest& rest = cut.rests[part.ray()];
  const FinePoint at = moved(fine(ray.position, rest.position), fine(ray.step, rest.step), first);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.first[axis] = static_cast<std::int32_t>(at[axis] >> kRestBits) - corner[axis];
    out.rest[axis] = static_cast<std::uint16_t>(at[axis]);
    out.step[axis] = ray.step[axis];
    out.step_rest[axis] = rest.step[axis];
  }
}

// The cells of one tile. Each thread has its own.
class Cells {
 public:
  explicit Cells(const Tiles& tiles) : tiles_(tiles), lines_(tiles.tile().words() / kLine) {}

  // Adds the tile's parts of all cuts to the block's words.
  void add(std::size_t tile, const std::vector<Cut>& cuts, AccumulatorMemory& accumulators) {
    constexpr std::uint64_t kMax = std::numeric_limits<std::int32_t>::max();
    const Point corner = tiles_.corner(tile);
    const std::size_t block = tiles_.block_of(tile), slab = tiles_.slab_of(tile);
    const std::size_t row = tiles_.tile().across + 1;
    std::uint64_t moved = 0;  // upper bound of the change of a cell's word or a voxel's sum
    for (const Cut& cut : cuts) {
      const std::vector<Part>& parts = cut.parts[tile];
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const Part& part = parts[i];
        __builtin_prefetch(&cut.rays[parts[std::min(i + kAhead, parts.size() - 1)].ray()]);
        const std::uint64_t moves = cut.rays[part.ray()].moves;
        const bool is_full = moved + moves > kMax;
        if (is_full || count_ == pieces_.size()) splat_pieces();
        if (is_full) {
          join(tiles_.tile(), words(), accumulators.storage(block) + slab * tiles_.tile().depth * row * row);
          moved = 0;
        }
        moved += moves;
        make_piece(cut, part, corner, pieces_[count_++]);
      }
    }
    if (count_ == 0) return;
    splat_pieces();
    join(tiles_.tile(), words(), accumulators.storage(block) + slab * tiles_.tile().depth * row * row);
  }

 private:
  static constexpr std::size_t kAhead = 16;  // chosen: prefetch distance in rays
  static constexpr std::size_t kLine = 16;   // words per line of the host's cache
  struct alignas(kLine * sizeof(std::int32_t)) Line {
    std::array<std::int32_t, kLine> words{};
  };
  std::int32_t* words() { return lines_.front().words.data(); }
  void splat_pieces() {
    splat(std::span(pieces_).first(count_), tiles_.tile(), words());
    count_ = 0;
  }

  const Tiles& tiles_;
  std::vector<Line> lines_;
  std::array<Piece, 64> pieces_;  // chosen: fits into a core's first-level cache
  std::size_t count_ = 0;
};

class PendingRays : public WaitingAdds {
 public:
  void take(std::span<const wire::Ray> rays, const Frame& frame, unsigned threads, RayCounters& counters) {
    AccumulatorMemory& accumulators = *frame.accumulators;
    const Tiles tiles(accumulators);
    threads_ = std::max(threads, 1u);
    constexpr std::size_t kMinRays = 4096;  // chosen: a command of the driver; in halves it costs a tenth more
    const std::size_t parts = std::clamp<std::size_t>(rays.size() / kMinRays, 1, threads_);
    if (cuts_.size() < parts) cuts_.resize(parts);
    for (Cut& cut : cuts_) {
      cut.parts.resize(tiles.layer() * tiles.layers());
      cut.moves.assign(accumulators.block_count(), 0);
    }
    parallel_for(parts, threads_, [&](std::size_t t) {
      const std::size_t first = rays.size() * t / parts, last = rays.size() * (t + 1) / parts;
      cuts_[t].counters = {};
      for (std::size_t i = first; i < last; ++i) {
        emu::take(rays[i], frame, tiles, cuts_[t]);
      }
    });
    std::size_t bytes = 0;
    for (std::size_t t = 0; t < cuts_.size(); ++t) {
      bytes += cuts_[t].bytes();
      if (t >= parts) continue;
      counters += cuts_[t].counters;
      for (std::size_t block = 0; block < accumulators.block_count(); ++block)
        accumulators.moved(block, cuts_[t].moves[block]);
    }
    if (bytes > accumulators.max_waiting_bytes()) add_to(accumulators);
  }

  void add_to(AccumulatorMemory& accumulators) override {
    if (std::ranges::all_of(cuts_, [](const Cut& cut) { return cut.rays.empty(); })) return;
    const Tiles tiles(accumulators);
    // Layer by layer: rays that turn about z stay in a core's cache, and no two threads add to tiles of one block.
    for (std::size_t layer = 0; layer < tiles.layers(); ++layer) {
      std::atomic<std::size_t> next = layer * tiles.layer();
      parallel_for(threads_, threads_, [&](std::size_t) {
        Cells cells(tiles);
        for (std::size_t tile = next++; tile < (layer + 1) * tiles.layer(); tile = next++)
          cells.add(tile, cuts_, accumulators);
      });
    }
    forget();
  }

  void forget() override {
    for (Cut& cut : cuts_) {
      for (std::vector<Part>& parts : cut.parts) parts.clear();
      cut.rays.clear();
      cut.rests.clear();
      cut.parts_count = 0;
    }
  }

 private:
  std::vector<Cut> cuts_;  // one per thread
  unsigned threads_ = 1;
};

}  // namespace

RayCounters backproject(std::span<const wire::Ray> rays, const Frame& frame, unsigned threads) {
  std::unique_ptr<WaitingAdds>& waiting = frame.accumulators->waiting();
  if (waiting == nullptr) waiting = std::make_unique<PendingRays>();
  RayCounters sum;
  static_cast<PendingRays&>(*waiting).take(rays, frame, threads, sum);
  sum.visible_samples = sum.deposits = sum.samples;
  return sum;
}

}  // namespace gicube::emu
