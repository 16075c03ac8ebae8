#include "firmware/make_level.h"

#include "cycle/cycle_level.h"
#include "functional/functional_level.h"
#include "gicube/parallel_for.h"

namespace gicube::emu {

std::unique_ptr<Level> make_level(const v1::BoardConfig& config, Observer* observer) {
  const unsigned threads = thread_count(config.threads());
  if (config.fidelity() == v1::functional) return std::make_unique<FunctionalLevel>(threads);
  return std::make_unique<CycleLevel>(config, observer, threads);
}

}  // namespace gicube::emu
