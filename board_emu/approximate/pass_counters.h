// What the approximate level counts of a processor beside its cache and its writes.
#pragma once

#include <cstdint>

#include "gicube/archive.h"

namespace gicube::emu {

struct PassCounters {
  std::uint64_t leaps = 0;
  std::uint64_t overflows = 0, conflicts = 0;
  std::uint64_t activations = 0;
  std::uint64_t rays_sent = 0;  // over links
  std::uint64_t hops = 0;
  std::uint64_t held = 0;                    // cycles in which a ray was in the queues or the pipeline
  std::uint64_t deposits = 0, carriers = 0;  // carriers: sent
  std::uint64_t carried = 0;                 // carriers that came to their blocks

  void state(Archive::Record& record) {
    record(leaps, overflows, conflicts, activations, rays_sent, hops, held, deposits, carriers, carried);
  }
};

}  // namespace gicube::emu
