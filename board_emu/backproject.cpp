#include "backproject.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <thread>
#include <vector>

#include "march.h"
#include "meet.h"
#include "memory/sum_memory.h"
#include "pipeline/spread.h"

namespace gicube::emu {

namespace {

// A ray's samples in one block.
struct Piece {
  std::uint32_t block = 0;
  std::uint32_t count = 0;
  Point first{};  // from the block's corner
  Point step{};
  std::int32_t amount = 0;
  std::uint32_t moves = 0;  // a word by at most
};

// How many samples of the ray lie in the volume, of those that it has left.
std::int32_t samples_inside(const Traveller& ray, const Frame& frame) {
  if (!inside(ray.position, frame.extent)) return 0;
  auto count = static_cast<std::int32_t>(ray.interacted);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t step = ray.step[axis];
    if (step > 0) count = std::min(count, (frame.extent[axis] - ray.position[axis]) / step + 1);
    if (step < 0) count = std::min(count, ray.position[axis] / -step + 1);
  }
  return count;
}

void cut(const wire::Ray& packet, const Frame& frame, std::vector<Piece>& pieces, RayCounters& counters) {
  const BlockGrid grid(*frame.volume);
  Traveller ray = set_out(packet, frame);
  std::int32_t left = samples_inside(ray, frame);
  ++counters.rays;
  counters.samples += static_cast<std::uint64_t>(left);
  const std::int32_t amount = amount_of(ray);
  const auto size = static_cast<std::uint32_t>(std::abs(amount));
  const auto moves =
      static_cast<std::uint32_t>(wire::most_moved(size, static_cast<std::uint32_t>(packet.colour_word()), frame.step));
  counters.energy.deposited.kept += static_cast<std::uint64_t>(std::int64_t{amount} * left);
  while (left > 0) {
    const Point low = grid.low(ray.position);
    const std::int32_t count = std::min(left, leap_steps(ray.position, ray.step, low, grid.size()));
    Piece piece{static_cast<std::uint32_t>(grid.block(ray.position)),
                static_cast<std::uint32_t>(count),
                {},
                ray.step,
                amount,
                moves};
    for (std::size_t axis = 0; axis < 3; ++axis) piece.first[axis] = ray.position[axis] - low[axis];
    pieces.push_back(piece);
    advance(ray, count);
    left -= count;
  }
}

// spread() and eight additions, for each sample of the piece. `row`, `slice`: words from a voxel to the next in y and z.
void splat(const Piece& piece, std::int64_t* words, std::size_t row, std::size_t slice) {
  constexpr int kBits = wire::kPositionFractionBits;
  constexpr std::uint32_t kMask = static_cast<std::uint32_t>(wire::kVoxel) - 1;
  std::uint32_t x = static_cast<std::uint32_t>(piece.first[0]), y = static_cast<std::uint32_t>(piece.first[1]),
                z = static_cast<std::uint32_t>(piece.first[2]);
  const auto along_x = [](std::int64_t* at, std::int32_t amount, std::uint32_t fraction) {
    const std::int32_t upper = upper_part(amount, fraction);
    at[0] += amount - upper;
    at[1] += upper;
  };
  for (std::uint32_t i = 0; i < piece.count; ++i) {
    std::int64_t* const at = words + (x >> kBits) + row * (y >> kBits) + slice * (z >> kBits);
    const std::uint32_t fx = x & kMask, fy = y & kMask;
    const std::int32_t far = upper_part(piece.amount, z & kMask), near = piece.amount - far;
    const std::int32_t near_up = upper_part(near, fy), far_up = upper_part(far, fy);
    along_x(at, near - near_up, fx);
    along_x(at + row, near_up, fx);
    along_x(at + slice, far - far_up, fx);
    along_x(at + slice + row, far_up, fx);
    x += static_cast<std::uint32_t>(piece.step[0]);
    y += static_cast<std::uint32_t>(piece.step[1]);
    z += static_cast<std::uint32_t>(piece.step[2]);
  }
}

// Runs job(t) for t in [0, threads), the first on this thread.
template <typename Job>
void on_threads(unsigned threads, const Job& job) {
  std::vector<std::jthread> others;
  for (unsigned t = 1; t < threads; ++t) others.emplace_back([&job, t] { job(t); });
  job(0u);
}

}  // namespace

RayCounters backproject(std::span<const wire::Ray> rays, const Frame& frame, unsigned threads) {
  constexpr std::size_t kLeastRays = 16;  // chosen: a thread costs as much as some dozen rays
  threads = static_cast<unsigned>(std::clamp<std::size_t>(rays.size() / kLeastRays, 1, std::max(threads, 1u)));
  std::vector<std::vector<Piece>> pieces(threads);
  std::vector<RayCounters> counters(threads);
  on_threads(threads, [&](unsigned t) {
    RayCounters mine;
    const std::size_t first = rays.size() * t / threads, last = rays.size() * (t + 1) / threads;
    for (std::size_t i = first; i < last; ++i) cut(rays[i], frame, pieces[t], mine);
    counters[t] = mine;
  });

  // Sorted by block: block b's pieces begin at starts[b].
  std::vector<std::uint32_t> starts(frame.volume->block_count() + 1);
  for (const auto& list : pieces) {
    for (const Piece& piece : list) {
      ++starts[piece.block + 1];
      frame.sums->moved(piece.block, piece.moves);
    }
  }
  std::vector<std::uint32_t> busy;
  for (std::uint32_t block = 0; block + 1 < starts.size(); ++block) {
    if (starts[block + 1] != 0) busy.push_back(block);
    starts[block + 1] += starts[block];
  }
  std::vector<const Piece*> sorted(starts.back());
  std::vector<std::uint32_t> next(starts.begin(), starts.end() - 1);
  for (const auto& list : pieces) {
    for (const Piece& piece : list) sorted[next[piece.block]++] = &piece;
  }

  const std::size_t row = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  std::atomic<std::size_t> taken{0};
  on_threads(threads, [&](unsigned) {
    for (std::size_t i = taken++; i < busy.size(); i = taken++) {
      const std::uint32_t block = busy[i];
      std::int64_t* const words = frame.sums->storage(block);
      for (std::uint32_t p = starts[block]; p < starts[block + 1]; ++p) splat(*sorted[p], words, row, row * row);
    }
  });
  RayCounters sum;
  for (const RayCounters& each : counters) sum += each;
  sum.visible_samples = sum.deposits = sum.samples;
  return sum;
}

}  // namespace gicube::emu
