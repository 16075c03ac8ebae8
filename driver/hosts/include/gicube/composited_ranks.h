// Pictures by several hosts: each renders the part of the volume that it was dealt, and the parts' pictures are composited. For rendering
// alone, and with roundings of their own; docs/guide/mpi.md has the bound.
//
//   board.load_volume(volume);                                // the same on each rank
//   gicube::CompositedRanks ranks(board, exchange);
//   const gicube::Image image = ranks.render(view);           // rank 0 has the picture
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "gicube/board.h"
#include "gicube/ray_exchange.h"

namespace gicube {

// What a rank did for a picture.
struct RankReport {
  Picoseconds work = 0;          // simulated, of its board: its part's picture, and the way to its host
  std::uint64_t blocks = 0;      // of its part in which something shows
  std::uint64_t samples = 0;     // that it took
  std::uint64_t bytes_sent = 0;  // to other ranks, without the gathering at rank 0
};

// All calls are collective, with equal arguments: the ranks have loaded the same volume and tables, on boards of the same configuration.
class GICUBE_API CompositedRanks {
 public:
  // This rank's board, and the ranks' exchange. Both must outlive this.
  CompositedRanks(Board& board, RayExchange& exchange);
  CompositedRanks(CompositedRanks&&) noexcept;
  CompositedRanks& operator=(CompositedRanks&&) noexcept;
  ~CompositedRanks();

  // The picture, at rank 0; other ranks get one without pixels. The blocks in which something shows are dealt as boxes that cost the
  // same: by their number, and from the second picture on by the simulated time of the ranks' work for those before, or by samples
  // where boards count no time (functional). Each board makes the rows in which its box may be seen, and has the others' blocks flagged
  // as empty meanwhile, so that its rays leap over them.
  // Throws BadArgument by the view's field, on each rank before anything is sent (jitter, samples_per_axis, irradiance, scatter:
  // none of them can be composited; and as Board::render()), and Unsupported after Board::share_blocks(). What a rank's board throws, as Board::render(), it throws on that rank alone,
  // and the exchange's Error: the other ranks wait then.
  Image render(const View& view, const Progress& progress = {});

  // Of the last picture, by rank; at rank 0 alone.
  const std::vector<RankReport>& reports() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gicube
