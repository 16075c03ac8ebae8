// What every fidelity level knows of a frame: registers, tables and the volume; and what it counts of the frame's rays.
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
class HostDepositList;
class HostTrapQueue;
class Routines;
class SumMemory;
class WaitingRayQueue;

// Three irradiance words: red, green, blue. Parts of an energy, wire::kScatteringOne = all.
inline constexpr std::size_t kColours = 3;
inline constexpr std::array<std::uint16_t, kColours> kWhite{wire::kScatteringOne, wire::kScatteringOne,
                                                            wire::kScatteringOne};
inline constexpr std::array<std::array<std::uint16_t, kColours>, wire::kTags> kAllWhite{kWhite, kWhite, kWhite, kWhite};
static_assert(wire::kTags == kAllWhite.size());

// What holds for every ray of a frame: registers, tables, volume. The tables must outlive it.
struct Frame {
  const VolumeMemory* volume = nullptr;
  std::span<const wire::SegmentationEntry> segmentation;  // wire::kSegmentationEntries
  std::uint64_t segmentation_writes = 0;  // counts changes: what is made of it is current while this is the same
  const std::uint8_t* reflectance_map = nullptr;  // wire::kReflectanceBytes
  const OpacityCorrection* opacity_correction = nullptr;
  const DepthTable* depths = nullptr;  // of `segmentation`, for lighting rays with the conserving rules
  std::vector<std::uint8_t> empty;     // one a block; nonzero = leap
  std::vector<std::uint8_t> absent;    // the same; nonzero = rays wait for it. None: all blocks are there
  WaitingRayQueue* waiting = nullptr;  // if some are absent: where those rays go
  std::vector<std::uint8_t> dark;      // one a block; nonzero = the host has its irradiance. None: the card has all
  HostDepositList* host_deposits = nullptr;  // where deposits go that the host must make; if some blocks are dark
  Point extent{};                            // size - 1 in position units
  std::array<std::uint32_t, 3> spacing{};    // 16.16
  std::uint32_t step = 0;                    // 16.16 voxels
  std::uint32_t opacity_threshold = wire::kOpacityOne;
  bool jitter = false;
  bool shade = false;
  bool leap = false;
  bool ends_at_borders = false;  // a ray ends where it would go on at another processor
  std::vector<Plane> cut_planes;

  // What all rays of the frame do. Viewing rays are kIntegrate and the rays of a light kDeposit, as if the host had made them.
  wire::RayType type = wire::RayType::kIntegrate;
  SumMemory* sums = nullptr;    // of rays that backproject: where samples leave amounts; null: in irradiance words
  std::uint64_t max_moved = 0;  // by which the rays can move one of the sums

  std::array<wire::Material, wire::kTags> materials{};
  IrradianceMemory* irradiance = nullptr;  // lighting rays add to it, rendering rays read it
  // Irradiance words of a voxel: 1, or 3 for red, green and blue. `irradiance` points at as many memories.
  std::size_t light_words = 1;
  std::array<std::uint16_t, kColours> light_colour = kWhite;  // parts of a ray's energy that its colours set out with
  std::array<std::array<std::uint16_t, kColours>, wire::kTags> scattering_colour = kAllWhite;  // of Ks, by material
  const Routines* routines = nullptr;   // for materials that trap
  HostTrapQueue* host_traps = nullptr;  // and where rays go that the host must scatter
  bool lit_by_irradiance = false;       // rendering rays
  bool scatter = false;                 // rendering rays too are scattered
  bool high_albedo = false;             // rendering rays take colour once, where they are absorbed
  bool wide = false;                    // the wide datapath
  std::span<const float> wide_depths;   // on it: what wide_depths() makes of `segmentation`
  wire::EnergyRules rules = wire::EnergyRules::kConserving;
  std::uint32_t exposure = 0;  // 16.16
  std::uint32_t seed = 0;
  std::uint16_t lifetime = 0;  // of the rays that the DSP makes
  bool lamps = false;          // scattered rays that leave may see lamps (firmware/lamps.h)

  bool lights() const { return type == wire::RayType::kDeposit; }
  bool integral() const { return type == wire::RayType::kIntegral; }  // rays sum the densities
  bool backprojects() const { return type == wire::RayType::kBackproject; }
  bool segments() const { return wire::is_segment(type); }       // each ray has a length, and a step of its own
  bool to_the_hit() const { return wire::has_threshold(type); }  // rays end at the sample that brings them there
  bool colourless() const { return wire::is_one_of<wire::RayType::kFirstHit, wire::RayType::kOpacity>(type); }
  // Some blocks may be absent, or rays go on that have waited for one.
  bool in_bricks() const { return waiting != nullptr; }
  // Rays go straight on and change nothing but themselves.
  bool gathers() const { return !(lights() || backprojects() || scatter || high_albedo); }
  // And are not lit by irradiance.
  bool plain() const { return gathers() && !lit_by_irradiance; }
};

// Rendering rays gather in wide words (datapath/wide.h).
inline bool gathers_wide(const Frame& frame) { return frame.wide && !frame.wide_depths.empty() && !frame.lights(); }

// What the rays of `frame` read of its volume; it must outlive this. Rays that backproject read nothing.
inline VolumeReads reads(const Frame& frame) {
  VolumeReads out;
  out.colours = !(frame.lights() || frame.backprojects() || frame.colourless() || frame.integral());
  if (frame.plain() && frame.leap) out.leapt_over = frame.empty;
  return out;
}

// Where lighting rays left their energy, in units of the energy words.
struct EnergyCounters {
  std::uint64_t emitted = 0;
  Deposited deposited;
  std::uint64_t escaped = 0;
  std::array<std::uint64_t, wire::kFaces> escaped_by_face{};  // sum to `escaped`
  std::uint64_t scattered_away = 0;
  std::uint64_t given_up = 0;  // of that, with rays at the end of their lifetime
};

struct RayCounters {
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;          // trilinear samples taken
  std::uint64_t visible_samples = 0;  // of those, with an opacity
  std::uint64_t leaps = 0;
  std::uint64_t terminated = 0;     // rays that ended by the opacity threshold
  std::uint64_t lighting_rays = 0;  // of the rays
  std::uint64_t scatterings = 0;
  std::uint64_t traps = 0;        // of the scatterings, by a routine
  std::uint64_t trap_cycles = 0;  // of the DSP
  std::uint64_t deposits = 0;
  EnergyCounters energy;                      // of the one irradiance word, or of red
  std::array<EnergyCounters, 2> more_energy;  // of green and blue

  EnergyCounters& energy_of(std::size_t word) { return word == 0 ? energy : more_energy[word - 1]; }
  const EnergyCounters& energy_of(std::size_t word) const { return word == 0 ? energy : more_energy[word - 1]; }

  RayCounters& operator+=(const RayCounters& other) {
    return each(other, [](std::uint64_t& mine, std::uint64_t its) { mine += its; });
  }
  // What was counted since `begin`.
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
