#include "levels/counters.h"

#include <string>
#include <unordered_map>

namespace gicube::emu {

void add_counters(const std::vector<wire::Counter>& from, std::vector<wire::Counter>& to) {
  std::unordered_map<std::string, std::size_t> place;
  for (std::size_t i = 0; i < to.size(); ++i) place.emplace(to[i].name, i);
  for (const wire::Counter& counter : from) {
    if (const auto [at, is_new] = place.emplace(counter.name, to.size()); is_new) {
      to.push_back(counter);
    } else {
      to[at->second].value += counter.value;
    }
  }
}

void add_run(RunResult& to, const RunResult& run, std::uint64_t core_khz) {
  to.cycles += run.cycles;
  to.asic_ps += cycles_to_ps(run.cycles, core_khz);
  to.dsp_cycles += run.dsp_cycles;
  to.made += run.made;
  to.rays += run.rays;
  to.cancelled = run.cancelled;
}

}  // namespace gicube::emu
