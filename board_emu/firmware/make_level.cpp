#include "firmware/make_level.h"

#include "approximate/approximate_level.h"
#include "cycle/cycle_level.h"
#include "functional/functional_level.h"
#include "gicube/parallel_for.h"
#include "sampled/sampled_level.h"

namespace gicube::emu {

std::unique_ptr<Level> make_level(const v1::BoardConfig& config, Observer* observer) {
  const unsigned threads = thread_count(config.threads());
  switch (config.fidelity()) {
    case v1::cycle:
      if (config.sample_error() != 0) return std::make_unique<SampledLevel>(config, observer, threads);
      return std::make_unique<CycleLevel>(config, observer, threads);
    case v1::approximate: return std::make_unique<ApproximateLevel>(config, observer, threads);
    default: return std::make_unique<FunctionalLevel>(threads);
  }
}

}  // namespace gicube::emu
