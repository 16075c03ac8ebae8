// The input of every fidelity level for one frame: registers, tables and the volume; and the counters of the frame's
// rays.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "datapath/opacity_correction.h"
#include "gicube/archive.h"
#include "gicube/wire/command.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/material.h"
#include "gicube/wire/ray.h"
#include "memory/irradiance_memory.h"
#include "memory/volume_memory.h"
#include "words/words.h"

namespace gicube::emu {

class DepthTable;
class HostDeposits;
class HostTraps;
class Routines;
class AccumulatorMemory;
class WaitingRays;

// Three irradiance words: red, green, blue. Fractions of an energy, wire::kScatteringOne = all.
inline constexpr std::size_t kColours = 3;
inline constexpr std::array<std::uint16_t, kColours> kWhite{wire::kScatteringOne, wire::kScatteringOne,
                                                            wire::kScatteringOne};
inline constexpr std::array<std::array<std::uint16_t, kColours>, wire::kTags> kAllWhite{kWhite, kWhite, kWhite, kWhite};
static_assert(wire::kTags == kAllWhite.size());

// Settings that are the same for all rays of a frame: registers, tables, volume. The tables must outlive it.
struct Frame {
  const VolumeMemory* volume = nullptr;
  std::span<const wire::SegmentationEntry> segmentation;  // wire::kSegmentationEntries
  std::uint64_t segmentation_writes = 0;  // counts changes of `segmentation`, so that derived data can be cached
  const std::uint8_t* reflectance_map = nullptr;  // wire::kReflectanceBytes
  const OpacityCorrection* opacity_correction = nullptr;
  const DepthTable* depths = nullptr;            // table of `segmentation`, for lighting rays with the conserving rules
  std::vector<std::uint8_t> empty;               // one flag per block; nonzero = skip
  std::vector<std::uint8_t> non_resident;        // one flag per block; nonzero = rays wait. Empty: all are resident
  WaitingRays* waiting = nullptr;                // takes rays that wait, if some blocks are non-resident
  std::vector<std::uint8_t> irradiance_at_host;  // one flag per block; nonzero = irradiance is at the host. Empty: none
  HostDeposits* host_deposits = nullptr;   // takes the host's shares of deposits, if `irradiance_at_host` has flags
  Point extent{};                          // size - 1 in position units
  std::array<std::uint32_t, 3> spacing{};  // 16.16
  std::uint32_t step = 0;                  // 16.16 voxels
  std::uint32_t opacity_threshold = wire::kOpacityOne;
  bool jitter = false;
  bool shade = false;
  bool skip_empty = false;
  std::vector<Plane> cut_planes;
  bool cut_faces = false;  // samples at faces that they cut are not shaded

  // Common to all rays of the frame. Viewing rays are kIntegrate and the rays of a light kDeposit, like rays of the
  // host.
  wire::RayType type = wire::RayType::kIntegrate;
  AccumulatorMemory* accumulators = nullptr;  // those of backprojecting rays; null: these use irradiance words
  std::uint64_t max_moved = 0;                // the most by which the rays can change one accumulator

  std::array<wire::Material, wire::kTags> materials{};
  IrradianceMemory* irradiance = nullptr;  // lighting rays add to it, rendering rays read it
  // Irradiance words per voxel: 1, or 3 for red, green and blue. `irradiance` points to as many memories.
  std::size_t light_words = 1;
  std::array<std::uint16_t, kColours> light_colour = kWhite;  // fractions of a ray's energy at its start
  std::array<std::array<std::uint16_t, kColours>, wire::kTags> scattering_colour = kAllWhite;  // for Ks, by material
  const Routines* routines = nullptr;  // for materials that trap
  HostTraps* host_traps = nullptr;     // takes rays that the host must scatter
  bool lit_by_irradiance = false;      // applies to rendering rays
  bool scatter = false;                // rendering rays are scattered, too
  bool high_albedo = false;            // rendering rays take colour once, at their absorption
  bool wide = false;                   // wide datapath
  std::span<const float> wide_depths;  // its depths: wide_depths() of `segmentation`
  wire::EnergyRules rules = wire::EnergyRules::kConserving;
  std::uint32_t exposure = 0;  // 16.16
  std::uint32_t seed = 0;
  std::uint16_t lifetime = 0;  // lifetime of rays made by the DSP
  bool lamps = false;          // scattered rays that leave may hit lamps (firmware/lamps.h)

  bool lights() const { return type == wire::RayType::kDeposit; }
  bool integral() const { return type == wire::RayType::kIntegral; }  // rays sum the densities
  bool backprojects() const { return type == wire::RayType::kBackproject; }
  bool segments() const { return wire::is_segment(type); }       // each ray has a length and its own step
  bool to_the_hit() const { return wire::has_threshold(type); }  // rays end at the sample that reaches the threshold
  bool colourless() const { return wire::is_one_of<wire::RayType::kFirstHit, wire::RayType::kOpacity>(type); }
  // Whether blocks may be non-resident, or rays continue that waited for one.
  bool in_bricks() const { return waiting != nullptr; }
  // Whether rays go straight and change nothing but themselves.
  bool gathers() const { return !(lights() || backprojects() || scatter || high_albedo); }
  // gathers() without light from the irradiance words.
  bool plain() const { return gathers() && !lit_by_irradiance; }
};

// Whether rays composite in wide words (datapath/wide.h); lighting rays do not.
inline bool gathers_wide(const Frame& frame) { return frame.wide && !frame.wide_depths.empty() && !frame.lights(); }

// The part of its volume that the rays of `frame` read; `frame` must outlive it. Backprojecting rays read nothing.
inline VolumeReads reads(const Frame& frame) {
  VolumeReads out;
  out.colours = !(frame.lights() || frame.backprojects() || frame.colourless() || frame.integral());
  if (frame.plain() && frame.skip_empty) out.skipped = frame.empty;
  return out;
}

// Destinations of the lighting rays' energy, in units of the energy words.
struct EnergyCounters {
  std::uint64_t emitted = 0;
  Deposited deposited;
  std::uint64_t escaped = 0;
  std::array<std::uint64_t, wire::kFaces> escaped_by_face{};  // sum to `escaped`
  std::uint64_t scattered_away = 0;
  std::uint64_t given_up = 0;  // part of scattered_away: rays at the end of their lifetime
};

struct RayCounters {
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;          // trilinear samples taken
  std::uint64_t visible_samples = 0;  // samples with an opacity
  std::uint64_t leaps = 0;
  std::uint64_t terminated = 0;     // rays that ended by the opacity threshold
  std::uint64_t lighting_rays = 0;  // lighting rays among `rays`
  std::uint64_t scatterings = 0;
  std::uint64_t traps = 0;        // scatterings by a routine
  std::uint64_t trap_cycles = 0;  // DSP cycles of these
  std::uint64_t deposits = 0;
  EnergyCounters energy;                      // the only irradiance word, or red
  std::array<EnergyCounters, 2> more_energy;  // green and blue

  EnergyCounters& energy_of(std::size_t word) { return word == 0 ? energy : more_energy[word - 1]; }
  const EnergyCounters& energy_of(std::size_t word) const { return word == 0 ? energy : more_energy[word - 1]; }

  RayCounters& operator+=(const RayCounters& other) {
    return each(other, [](std::uint64_t& mine, std::uint64_t its) { mine += its; });
  }
  // Counts since `begin`.
  RayCounters operator-(const RayCounters& begin) const {
    RayCounters window = *this;
    return window.each(begin, [](std::uint64_t& mine, std::uint64_t its) { mine -= its; });
  }
  void state(Archive::Record& record) {
    each(*this, [&record](std::uint64_t& mine, std::uint64_t) { record(mine); });
  }

 private:
  template <typename Change>
  RayCounters& each(const RayCounters& other, const Change& change) {
    change(rays, other.rays);
    change(samples, other.samples);
    change(visible_samples, other.visible_samples);
    change(leaps, other.leaps);
    change(terminated, other.terminated);
    change(lighting_rays, other.lighting_rays);
    change(scatterings, other.scatterings);
    change(traps, other.traps);
    change(trap_cycles, other.trap_cycles);
    change(deposits, other.deposits);
    for (std::size_t word = 0; word < kColours; ++word) {
      EnergyCounters& mine = energy_of(word);
      const auto& its = other.energy_of(word);
      change(mine.emitted, its.emitted);
      change(mine.deposited.kept, its.deposited.kept);
      change(mine.deposited.clipped, its.deposited.clipped);
      change(mine.escaped, its.escaped);
      for (std::size_t face = 0; face < wire::kFaces; ++face) {
        change(mine.escaped_by_face[face], its.escaped_by_face[face]);
      }
      change(mine.scattered_away, its.scattered_away);
      change(mine.given_up, its.given_up);
    }
    return *this;
  }
};

}  // namespace gicube::emu
