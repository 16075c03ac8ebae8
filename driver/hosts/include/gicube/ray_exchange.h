// The exchange of rays between the hosts of one job (gicube/mpi.h: by MPI). With Board::share_blocks() each host's
// board traces the rays in its own blocks of a volume, and rays that come to other blocks go to the boards that have
// those.
#pragma once

#include <cstdint>
#include <vector>

#include "gicube/export.h"

namespace gicube {

// All calls are collective: every rank makes the same ones in the same order, and a call returns once all have made it.
// A rank that throws leaves the others waiting, so it must end the job (MPI_Abort).
class GICUBE_API RayExchange {
 public:
  virtual ~RayExchange() = default;

  virtual int rank() const = 0;   // 0..ranks() - 1
  virtual int ranks() const = 0;  // at least 1
  // Sends to[r] to rank r, to the caller too, and returns what each rank sent to this one, by rank. `to` has ranks()
  // parts of any size. Throws Error.
  virtual std::vector<std::vector<std::uint8_t>> exchange(std::vector<std::vector<std::uint8_t>> to) = 0;
  // The sum of all ranks' values. Throws Error.
  virtual std::uint64_t sum(std::uint64_t value) = 0;
};

}  // namespace gicube
