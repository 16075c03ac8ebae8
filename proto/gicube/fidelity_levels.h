// The parts that each fidelity level omits. The statistics of a run print this table of docs/reference/hardware.md.
#pragma once

#include <array>
#include <string_view>

namespace gicube {

// Levels of gicube.v1.FidelityLevel as bits.
inline constexpr unsigned kAtFunctional = 1, kAtCycle = 4, kAtEveryLevel = kAtFunctional | kAtCycle;

struct LeftOut {
  unsigned levels;  // the levels that do not model it
  std::string_view what;
};

inline constexpr std::array kLeftOut{
    LeftOut{kAtFunctional, "time of the ASIC: queues, volume cache, memory, links, ray bus"},
    LeftOut{kAtFunctional, "changes between the DSP's loops, and its waits for caches and SDRAM"},
    LeftOut{kAtFunctional, "causes of the pipelines' cycles"},
    LeftOut{kAtFunctional, "energy"},
    LeftOut{kAtEveryLevel, "electrical behaviour but energy, temperature"},
    LeftOut{kAtEveryLevel, "interrupts as wires: completions stand for them"},
    LeftOut{kAtEveryLevel, "DMA descriptor fetches, and DMA that fetches ahead of a loop of the DSP"},
    LeftOut{kAtEveryLevel, "the host's memory"},
    LeftOut{kAtEveryLevel, "PCI arbitration time, which the standard allows to be hidden"},
    LeftOut{kAtEveryLevel, "keeping rays that wait for the host's routine in the SDRAM"},
    LeftOut{kAtEveryLevel, "the host's transfers into the SDRAM: a sixth of its bandwidth on PCI while they last"},
    LeftOut{kAtEveryLevel, "the limit of 64 MB that the pins of a C6205 or C6211 can address"},
    LeftOut{kAtEveryLevel, "a code's place within the DSP's program cache"},
    LeftOut{kAtEveryLevel, "the length of the RDRAM's wires: a later device answers later"},
    LeftOut{kAtEveryLevel, "the timing of the eDRAM's cells"},
};

// Fields of gicube.v1.BoardConfig that a level does not model. A name that ends with a dot or an underscore is a
// prefix. On these levels the fields do not change values, counts or times of rays.
struct UnmodelledField {
  unsigned levels;
  std::string_view field;
};

inline constexpr std::array kUnmodelledFields{
    UnmodelledField{kAtFunctional, "asic.processors"},
    UnmodelledField{kAtFunctional, "asic.partition"},
    UnmodelledField{kAtFunctional, "asic.skew_"},
    UnmodelledField{kAtFunctional, "asic.queue_rays"},
    UnmodelledField{kAtFunctional, "asic.core_khz"},
    UnmodelledField{kAtFunctional, "sorter."},
    UnmodelledField{kAtFunctional, "pipeline."},
    UnmodelledField{kAtFunctional, "cache."},
    UnmodelledField{kAtFunctional, "link."},
    UnmodelledField{kAtFunctional, "memory"},
    UnmodelledField{kAtFunctional, "rdram."},
    UnmodelledField{kAtFunctional, "ddr."},
    UnmodelledField{kAtFunctional, "sdram.t_"},
    UnmodelledField{kAtFunctional, "sdram.clock_khz"},
    UnmodelledField{kAtFunctional, "sdram.refresh_interval"},
    UnmodelledField{kAtFunctional, "sdram.controller_latency"},
    UnmodelledField{kAtFunctional, "ideal.memory"},
    UnmodelledField{kAtFunctional, "ideal.queues"},
    UnmodelledField{kAtFunctional, "ideal.sorter"},
    UnmodelledField{kAtFunctional, "dsp.overflow_rays"},
    UnmodelledField{kAtFunctional, "energy."},
};

constexpr bool is_modelled(unsigned level, std::string_view field) {
  for (const UnmodelledField& each : kUnmodelledFields) {
    const bool is_prefix = each.field.ends_with('.') || each.field.ends_with('_');
    const bool is_it = is_prefix ? field.starts_with(each.field) : field == each.field;
    if (is_it && (each.levels & level) != 0) return false;
  }
  return true;
}

}  // namespace gicube
