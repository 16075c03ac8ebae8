#include "backproject.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "functional/simd/splat_pieces.h"
#include "gicube/parallel_for.h"
#include "memory/sum_memory.h"

namespace gicube::emu {

namespace {

// What one thread cuts.
struct Cut {
  explicit Cut(std::size_t blocks) : counts(blocks), moves(blocks) {}

  std::vector<Piece> pieces;
  std::vector<std::uint32_t> counts;  // of each block's pieces; then where they go among all
  std::vector<std::uint64_t> moves;   // each block's words by at most
  RayCounters counters;
};

// How many samples of the ray lie in the volume, of those that it has left.
std::int32_t samples_inside(const RayState& ray, const Frame& frame) {
  if (!inside(ray.position, frame.extent)) return 0;
  return frame.wide ? steps_inside(ray.fine_position(), ray.fine_step(), fine_extent(frame.extent), ray.steps_left())
                    : steps_inside(ray.position, ray.step, frame.extent, ray.steps_left());
}

void cut(const wire::Ray& packet, const Frame& frame, const BlockGrid& grid, Cut& out) {
  RayState ray = unpack(packet, frame);
  std::int32_t left = samples_inside(ray, frame);
  ++out.counters.rays;
  out.counters.samples += static_cast<std::uint64_t>(left);
  const std::int32_t amount = ray.amount();
  const auto size = static_cast<std::uint32_t>(std::abs(amount));
  const std::uint64_t moves = wire::max_moved(size, static_cast<std::uint32_t>(packet.colour_word()), frame.step);
  out.counters.energy.deposited.kept += static_cast<std::uint64_t>(std::int64_t{amount} * left);
  while (left > 0) {
    const Point low = grid.low(ray.position);
    const std::int32_t count = std::min(left, leap_steps(ray, low, grid.size(), frame));
    Piece piece{.block = static_cast<std::uint32_t>(grid.block(ray.position)),
                .count = static_cast<std::uint32_t>(count),
                .step = ray.step,
                .amount = amount,
                .rest = ray.rest,
                .step_rest = ray.step_rest};
    for (std::size_t axis = 0; axis < 3; ++axis) piece.first[axis] = ray.position[axis] - low[axis];
    ++out.counts[piece.block];
    out.moves[piece.block] += moves;
    out.pieces.push_back(piece);
    advance(ray, count, frame);
    left -= count;
  }
}

// The pieces of one block, among all that are sorted by block.
struct Busy {
  std::uint32_t block = 0;
  std::span<const Piece> pieces;
  std::uint64_t moves = 0;
};

class SortedPieces {
 public:
  explicit SortedPieces(std::vector<Cut>& cuts) {
    std::size_t all = 0;
    for (const Cut& cut : cuts) all += cut.pieces.size();
    pieces_ = std::make_unique_for_overwrite<Piece[]>(all);
    std::uint32_t at = 0;
    for (std::uint32_t block = 0; block < cuts[0].counts.size(); ++block) {
      const std::uint32_t first = at;
      std::uint64_t moves = 0;
      for (Cut& cut : cuts) {
        at += std::exchange(cut.counts[block], at);
        moves += cut.moves[block];
      }
      if (at != first) busy_.push_back({block, {pieces_.get() + first, at - first}, moves});
    }
    parallel_for(cuts.size(), static_cast<unsigned>(cuts.size()), [&](std::size_t t) {
      for (const Piece& piece : cuts[t].pieces) pieces_[cuts[t].counts[piece.block]++] = piece;
    });
  }

  const std::vector<Busy>& busy() const { return busy_; }

 private:
  std::unique_ptr<Piece[]> pieces_;
  std::vector<Busy> busy_;
};

}  // namespace

RayCounters backproject(std::span<const wire::Ray> rays, const Frame& frame, unsigned threads) {
  constexpr std::size_t kMinRays = 16;  // chosen: a thread costs as much as some dozen rays
  threads = static_cast<unsigned>(std::clamp<std::size_t>(rays.size() / kMinRays, 1, std::max(threads, 1u)));
  const BlockGrid grid(*frame.volume);
  std::vector<Cut> cuts(threads, Cut(frame.volume->block_count()));
  parallel_for(threads, threads, [&](std::size_t t) {
    const std::size_t first = rays.size() * t / threads, last = rays.size() * (t + 1) / threads;
    for (std::size_t i = first; i < last; ++i) cut(rays[i], frame, grid, cuts[t]);
  });

  const SortedPieces sorted(cuts);
  const std::size_t row = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  parallel_for(sorted.busy().size(), threads, [&](std::size_t i) {
    const Busy& of = sorted.busy()[i];
    frame.sums->moved(of.block, of.moves);
    if (std::int64_t* const pairs = frame.sums->pairs(of.block, of.moves); pairs != nullptr) {
      splat(of.pieces, pairs, row, row * row);
    } else {
      splat_to_words(of.pieces, frame.sums->storage(of.block), row, row * row);
    }
  });
  RayCounters sum;
  for (const Cut& cut : cuts) sum += cut.counters;
  sum.visible_samples = sum.deposits = sum.samples;
  return sum;
}

}  // namespace gicube::emu
