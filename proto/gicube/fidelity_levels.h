// The parts that each fidelity level omits. The statistics of a run print this table of docs/reference/hardware.md.
#pragma once

#include <algorithm>
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

// Fields of gicube.v1.BoardConfig that the functional level does not model: there they do not change values, counts or
// times of rays. A name that ends with a dot or an underscore is a prefix.
inline constexpr std::string_view kUnmodelledFields[] = {"asic.processors",
                                                         "asic.partition",
                                                         "asic.skew_",
                                                         "asic.queue_rays",
                                                         "asic.core_khz",
                                                         "sorter.",
                                                         "pipeline.",
                                                         "cache.",
                                                         "link.",
                                                         "memory",
                                                         "rdram.",
                                                         "ddr.",
                                                         "sdram.t_",
                                                         "sdram.clock_khz",
                                                         "sdram.refresh_interval",
                                                         "sdram.controller_latency",
                                                         "ideal.memory",
                                                         "ideal.queues",
                                                         "ideal.sorter",
                                                         "dsp.overflow_rays",
                                                         "energy."};

constexpr bool is_modelled(unsigned level, std::string_view field) {
  const bool is_left_out = std::ranges::any_of(kUnmodelledFields, [field](std::string_view each) {
    return each.ends_with('.') || each.ends_with('_') ? field.starts_with(each) : field == each;
  });
  return (level & kAtFunctional) == 0 || !is_left_out;
}

}  // namespace gicube
