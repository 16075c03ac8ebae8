// Light between pairs of elements of a board's volume (Board::pairs()). gicube/pair.h has their records.
#pragma once

#include <span>
#include <vector>

#include "gicube/export.h"
#include "gicube/pair.h"
#include "gicube/pending.h"

namespace gicube {

struct BoardState;

class GICUBE_API PairIntegrator {
 public:
  explicit PairIntegrator(BoardState& of) : state_(&of) {}

  // The light exchanged between pairs of elements: one factor per pair. Near pairs are divided (PairFactor). The
  // simulated host waits. With PairRays::kByHost it makes rays in no time, unless the application adds host_compute().
  // Pairs with nothing but empty blocks between them (empty_flags(), if PairRequest::leap is on) are summed up by the
  // driver, without rays: PairFactor::clear. Throws BadArgument (an element's, a pair's index, the request's fields),
  // Rejected (no volume): nothing was sent.
  std::vector<PairFactor> factors(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                  const PairRequest& request = {}, const Progress& progress = {});
  Pending<std::vector<PairFactor>> start(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                         const PairRequest& request = {});

 private:
  BoardState* state_;
};

}  // namespace gicube
