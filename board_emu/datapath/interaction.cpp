#include "interaction.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "datapath/illuminate.h"
#include "datapath/random_stream.h"
#include "datapath/ray_interval.h"
#include "datapath/scatter.h"
#include "datapath/trilinear_splat.h"

namespace gicube::emu {

namespace {

// A classified sample; gradient and colour are computed only on demand.
struct Classified {
  Classified(const SampleSite& site, const Frame& frame)
      : at(around(site)), view(site.view), tag(tag_at(site, at)), density(resample_density(view.densities, at)) {
    index = segmentation_index(density, tag);
    entry = &frame.segmentation[index];
  }
  // For a known entry of the segmentation LUT.
  Classified(const SampleSite& site, const Frame& frame, std::size_t its_index)
      : at(around(site)), view(site.view), index(its_index), entry(&frame.segmentation[index]) {}

  Point gradient() const { return point_of(gradient_at(view, at)); }

  Neighbourhood at;
  const BlockView& view;
  unsigned tag = 0;
  std::int16_t density = 0;
  std::size_t index;  // index of `entry`
  const wire::SegmentationEntry* entry;
};

std::uint32_t product(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint32_t>(divide_by_full_scale<24>(std::uint64_t{a} * b));
}

std::uint64_t draw_here(RandomStream what, const RayState& ray, const Frame& frame) {
  return draw_at(what, ray.position, ray.u, ray.v, ray.lifetime, frame.seed);
}

// Whether a scattered ray leaves a reflecting surface, so that it does not interact with it again.
bool leaves(const RayState& ray, const wire::Material& material, const Classified& sample, const Frame& frame) {
  if (ray.generation == 0 || !reflects(material.bsdf)) return false;
  const Point gradient = sample.gradient();
  std::int64_t along = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    along += std::int64_t{ray.direction[axis]} * frame.spacing[axis] * gradient[axis];
  }
  return along < 0;
}

// The scattered fraction of the light that is not absorbed: Ks a / (1 - (1 - Ks) a), 24 bits.
std::uint32_t scattering_opacity(std::uint32_t a, const wire::Material& material) {
  if (a == wire::kOpacityOne) return material.scattering == 0 ? 0 : wire::kOpacityOne;
  const double ks = material.scattering / double{wire::kScatteringOne}, alpha = a / double{wire::kOpacityOne};
  return static_cast<std::uint32_t>(std::lround(ks * alpha / (1 - (1 - ks) * alpha) * wire::kOpacityOne));
}

// The absorbed part of an opacity; `scattering`: wire::kScatteringOne = all is scattered.
std::uint32_t absorption_opacity(std::uint32_t a, std::uint16_t scattering) {
  const std::uint64_t kept = wire::kScatteringOne - scattering;
  return static_cast<std::uint32_t>((a * kept + wire::kScatteringOne / 2) / wire::kScatteringOne);
}

// Accumulates `opacity`. Returns true if the ray interacts in this interval, at the fraction `share`, 0..1, of its
// depth. `all`: the opacity of the whole interval. Where absorbed light is no part of `opacity`, it still thins what
// interacts further on.
bool interacts(RayState& ray, std::uint32_t opacity, std::uint32_t all, const Frame& frame, double& share) {
  const std::uint32_t before = ray.interacted;
  ray.interacted = before + product(wire::kOpacityOne - before, opacity);
  const std::uint32_t value = interaction_value(ray, frame);
  if (ray.interacted < value || ray.interacted == before) return false;
  if (value <= before) {
    share = 0;
  } else if (opacity == all) {
    // Optical depth grows linearly along the step, opacity does not.
    const auto depth = [before](std::uint32_t until) {
      return std::log((wire::kOpacityOne - before + 0.5) / (wire::kOpacityOne - until + 0.5));
    };
    share = depth(value) / depth(ray.interacted);
  } else {
    const double part = (value - before) / static_cast<double>(ray.interacted - before);
    const double alpha = std::min<double>(all, wire::kOpacityOne - 0.5) / wire::kOpacityOne;
    share = std::log1p(-part * alpha) / std::log1p(-alpha);
  }
  return true;
}

// The position at which the fraction `share` of the medium's optical depth is behind the ray; the printed rules use the
// sample's own position. It may be in another block.
Point place_in(const RayInterval& interval, double share, const RayState& ray, const Frame& frame) {
  Point out = ray.position;
  if (frame.rules == wire::EnergyRules::kAsPrinted) return out;
  const double steps = interval.place(share, frame);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out[axis] += static_cast<std::int32_t>(std::lround(steps * ray.slope(axis)));
    out[axis] = std::clamp(out[axis], 0, frame.extent[axis]);
  }
  return out;
}

// Ks for one colour of light.
std::uint32_t scattering_of(std::size_t word, const wire::Material& material, unsigned tag, const Frame& frame) {
  if (frame.light_words == 1) return material.scattering;
  const std::uint32_t product = std::uint32_t{material.scattering} * frame.scattering_colour[tag][word];
  return (product + wire::kScatteringOne / 2) / wire::kScatteringOne;
}

// Scatters all colours like the one with the largest Ks; a fraction of the others is absorbed. Returns its units.
EnergyUnits keep_colour(RayState& ray, unsigned tag, const Frame& frame) {
  EnergyUnits lost{};
  if (frame.light_words == 1) return lost;
  const std::uint64_t chance = draw_here(RandomStream::kColour, ray, frame) >> 48;
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    const std::uint32_t before = energy_units(ray, frame, word);
    const std::uint64_t energy = ray.energy(word), part = wire::kScatteringOne - frame.scattering_colour[tag][word];
    const std::uint64_t dither = chance * wire::kScatteringOne >> 16;  // stochastic rounding, as for losses
    ray.set_energy(word, energy - (energy * part + dither) / wire::kScatteringOne);
    lost[word] = before - energy_units(ray, frame, word);
  }
  return lost;
}

// Adds the units of a further medium in the interval: one deposit, at the position of the larger part.
void deposit_more(Interaction& interaction, const RayState& ray, EnergyUnits units, const Point& place,
                  const Frame& frame) {
  const auto sum = [](const EnergyUnits& of) { return std::accumulate(of.begin(), of.end(), std::uint64_t{0}); };
  const bool most = sum(units) > sum(interaction.units);
  for (std::size_t word = 0; word < frame.light_words; ++word) units[word] += interaction.units[word];
  deposit(interaction, ray, units, most ? place : interaction.place, frame);
}

void give_up(Interaction& interaction, const RayState& ray, const Frame& frame, RayCounters& counters) {
  interaction.outcome = Outcome::kEnded;
  if (!ray.is(wire::kLightingRay)) return;
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    const std::uint32_t units = energy_units(ray, frame, word);
    counters.energy_of(word).scattered_away += units;
    counters.energy_of(word).given_up += units;
  }
}

// The ray interacts after the fraction `share` of its medium's optical depth and is scattered.
void scatter(Interaction& interaction, RayState& ray, const RayInterval& interval, double share,
             const wire::Material& material, const Classified& sample, const Frame& frame, RayCounters& counters) {
  ray.position = place_in(interval, share, ray, frame);
  if (ray.lifetime == 0) return give_up(interaction, ray, frame, counters);
  ++counters.scatterings;
  if (material.bsdf == wire::Bsdf::kTrap) {
    ++counters.traps;
    ray.flags = static_cast<std::uint8_t>(ray.flags | wire::kTrapped | interval.tag() << kTrapTagShift);
    interaction.outcome = Outcome::kTrapped;
    return;
  }
  redirect(ray,
           scattered(material, ray.direction, sample.gradient(), frame.spacing,
                     draw_here(RandomStream::kDirection, ray, frame)),
           frame);
  if (frame.rules == wire::EnergyRules::kAsPrinted) advance(ray, 1, frame);
}

bool draws_scattering(const RayState& ray, const wire::Material& material, const Frame& frame) {
  return (draw(RandomStream::kAbsorption, ray.u, ray.v, ray.lifetime, frame.seed) >> 48) *
             std::uint64_t{wire::kScatteringOne} <
         std::uint64_t{material.scattering} << 16;
}

// Each of the three interact_ functions handles one medium of the interval. Returns true if the ray continues straight
// on.
bool interact_photon(Interaction& interaction, RayState& ray, const RayInterval& interval,
                     const wire::Material& material, const Classified& sample, const Frame& frame,
                     RayCounters& counters) {
  const std::uint32_t a = interval.opacity();
  const bool straight = material.bsdf == wire::Bsdf::kNone;
  double share = 0;
  if (!interacts(ray, straight ? absorption_opacity(a, material.scattering) : a, a, frame, share)) return true;
  const bool scatters = !straight && draws_scattering(ray, material, frame);
  const EnergyUnits given = scatters ? keep_colour(ray, interval.tag(), frame) : all_units(ray, frame);
  deposit(interaction, ray, given, place_in(interval, share, ray, frame), frame);
  if (scatters && (frame.light_words == 1 || all_units(ray, frame) != EnergyUnits{})) {
    scatter(interaction, ray, interval, share, material, sample, frame, counters);
  } else {
    interaction.outcome = Outcome::kEnded;
  }
  return false;
}

bool interact_weighted(Interaction& interaction, RayState& ray, const RayInterval& interval,
                       const wire::Material& material, const Classified& sample, const Frame& frame,
                       RayCounters& counters) {
  const std::uint32_t a = interval.opacity();
  const bool printed = frame.rules == wire::EnergyRules::kAsPrinted;
  const std::uint64_t lost = printed ? a : absorption_opacity(a, material.scattering);
  // Stochastic rounding: otherwise small energies would never decrease in thin fog.
  const std::uint64_t dither = (draw_here(RandomStream::kLoss, ray, frame) >> 40) * wire::kOpacityOne >> 24;
  EnergyUnits given{};
  bool any_left = false;
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    const std::uint64_t before = ray.energy(word);
    const std::uint32_t units = energy_units(ray, frame, word);
    ray.set_energy(word, before - (before * lost + dither) / wire::kOpacityOne);
    const std::uint32_t left = energy_units(ray, frame, word);
    any_left = any_left || left != 0;
    given[word] = units - left;
    if (!printed || given[word] == 0) continue;  // with the printed rules, scattered energy is lost [P §2.2]
    const std::uint64_t kept = wire::kScatteringOne - scattering_of(word, material, interval.tag(), frame);
    const std::uint64_t chance = (draw_here(RandomStream::kShare, ray, frame) >> 48) * wire::kScatteringOne >> 16;
    const auto absorbed = static_cast<std::uint32_t>((given[word] * kept + chance) / wire::kScatteringOne);
    counters.energy_of(word).scattered_away += given[word] - absorbed;
    given[word] = absorbed;
  }
  double share = 0;
  const bool scatters = any_left && material.bsdf != wire::Bsdf::kNone &&
                        interacts(ray, printed ? a : scattering_opacity(a, material), a, frame, share);
  if (scatters && !printed && frame.light_words > 1) {
    const EnergyUnits absorbed = keep_colour(ray, interval.tag(), frame);
    for (std::size_t word = 0; word < frame.light_words; ++word) given[word] += absorbed[word];
    any_left = all_units(ray, frame) != EnergyUnits{};
  }
  if (given != EnergyUnits{}) {
    deposit_more(interaction, ray, given, place_in(interval, 0.5, ray, frame), frame);
  }
  if (!any_left) {
    interaction.outcome = Outcome::kEnded;
  } else if (scatters) {
    scatter(interaction, ray, interval, share, material, sample, frame, counters);
  }
  return any_left && !scatters;
}

Colour12 colour_of(const RayState& ray, const Classified& sample, std::size_t block, const Frame& frame) {
  const wire::SegmentationEntry entry = coloured(*sample.entry, sample.view, sample.at, frame);
  if (!frame.lit_by_irradiance) {
    return is_shaded(ray, frame) ? shade(entry, sample.gradient(), frame.reflectance_map)
                                 : Colour12{entry.colour[0], entry.colour[1], entry.colour[2]};
  }
  std::array<std::uint32_t, kColours> light{};
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    const std::uint32_t* const words = frame.irradiance[word].view(block);
    if (words == nullptr) continue;
    light[word] = irradiance(words + sample.at.first, sample.at.row, sample.at.slice, sample.at.weight, frame.wide);
  }
  if (frame.light_words == 1) light.fill(light[0]);
  const Point gradient = entry.specular != 0 ? sample.gradient() : Point{};
  return illuminated(entry, light, frame.exposure, gradient, frame.reflectance_map);
}

// Composites the absorbed part of a sample's opacity.
void absorb(RayState& ray, const Colour12& colour, std::uint32_t a, std::uint16_t scattering, const Classified& sample,
            const Frame& frame) {
  constexpr float kOne = wire::kScatteringOne;
  if (!gathers_wide(frame)) return over(ray, colour, absorption_opacity(a, scattering));
  const float alpha = wide_alpha(frame.wide_depths[sample.index], ray.exponent);
  over(ray, ray.wide, colour, scattering == 0 ? alpha : alpha * ((kOne - scattering) / kOne));
}

bool interact_rendering(Interaction& interaction, RayState& ray, const SampleSite& site, const RayInterval& interval,
                        const wire::Material& material, const Classified& sample, const Frame& frame,
                        RayCounters& counters) {
  const std::uint32_t a = interval.opacity();
  const bool scatters =
      frame.scatter && (material.flags & wire::kScattersRenderingRays) != 0 && material.bsdf != wire::Bsdf::kNone;
  double share = 0;
  if (frame.high_albedo) {
    if (!interacts(ray, a, a, frame, share)) return true;
    if (scatters && draws_scattering(ray, material, frame)) {
      scatter(interaction, ray, interval, share, material, sample, frame, counters);
      return false;
    }
    const Colour12 colour = colour_of(ray, sample, site.block, frame);
    if (gathers_wide(frame)) {
      over(ray, ray.wide, colour, 1.0F);
    } else {
      over(ray, colour, wire::kOpacityOne);
    }
    interaction.outcome = Outcome::kEnded;
    return false;
  }
  absorb(ray, colour_of(ray, sample, site.block, frame), a, scatters ? material.scattering : std::uint16_t{0}, sample,
         frame);
  if (!scatters) return true;
  const std::uint32_t scattered_part = scattering_opacity(a, material);
  // The position depends on the depth of the scattering part only.
  if (!interacts(ray, scattered_part, scattered_part, frame, share)) return true;
  scatter(interaction, ray, interval, share, material, sample, frame, counters);
  return false;
}

}  // namespace

void redirect(RayState& ray, const Direction& direction, const Frame& frame) {
  --ray.lifetime;
  if (ray.generation < 15) ++ray.generation;
  ray.interacted = 0;
  ray.under_way = false;
  ray.direction = direction;
  ray.length = physical_length(direction, frame.spacing);
  if (frame.wide) ray.rest = kHalfUnits;
  space(ray, frame.step, frame);
}

Sample sample_at(const Point& position, const Frame& frame) {
  const BlockGrid grid(*frame.volume);
  const std::size_t block = grid.block(position);
  const Cell cell_of = cell(position, grid.low(position));
  const BlockView view = frame.volume->view(block);
  const Classified at({cell_of, view, block, static_cast<std::size_t>(frame.volume->block_voxels()) + 1}, frame);
  Sample out{gradient_at(view, at.at), at.tag, coloured(*at.entry, view, at.at, frame), at.index};
  out.channels[0] = at.density;
  return out;
}

std::uint32_t interaction_value(const RayState& ray, const Frame& frame) {
  const std::uint16_t segment = frame.rules == wire::EnergyRules::kAsPrinted ? std::uint16_t{0} : ray.lifetime;
  const auto value =
      static_cast<std::uint32_t>(draw(RandomStream::kInteraction, ray.u, ray.v, segment, frame.seed) >> 40);
  return frame.wide ? value | 1u : (value & 0xFFF000u) | 0x800u;
}

Interaction interact(RayState& ray, const SampleSite& site, const Frame& frame, RayCounters& counters,
                     const KnownInterval* known) {
  if (frame.backprojects()) return backproject(ray, frame, counters);
  Interaction interaction;
  const bool first = !ray.under_way;
  ray.under_way = true;
  const Classified sample = known != nullptr ? Classified(site, frame, known->entry) : Classified(site, frame);
  interaction.visible = visible(sample.index, frame);
  const std::uint16_t opacity = sample.entry->opacity;
  const bool integrates = ray.is(wire::kLightingRay) && frame.rules == wire::EnergyRules::kConserving;
  const bool in_medium =
      known != nullptr || (integrates ? !RayInterval::is_clear(site, sample.tag, opacity, frame) : interaction.visible);
  if (!in_medium) {
    leave_surface(ray);
    advance(ray, 1, frame);
    return interaction;
  }
  RayInterval interval = known != nullptr ? RayInterval::of(*known)
                         : integrates
                             ? RayInterval::of(ray, site, sample.tag, opacity, first, frame)
                             : RayInterval::even(0, 1, (*frame.opacity_correction)(opacity, ray.exponent), sample.tag);
  bool goes_on = true;
  do {  // one medium of the interval after the other
    const wire::Material& material = frame.materials[interval.tag()];
    const bool meets = interval.opacity() != 0 || !integrates;
    if (ray.is(wire::kTrapped)) {  // back from the DSP: still at the surface?
      const bool at_surface = meets && material.bsdf == wire::Bsdf::kTrap;
      if (!at_surface) leave_surface(ray);
    }
    if (!meets || ray.is(wire::kTrapped) || leaves(ray, material, sample, frame)) continue;
    if (!ray.is(wire::kLightingRay)) {
      goes_on = interact_rendering(interaction, ray, site, interval, material, sample, frame, counters);
    } else if (ray.is(wire::kHighAlbedo)) {
      goes_on = interact_photon(interaction, ray, interval, material, sample, frame, counters);
    } else {
      goes_on = interact_weighted(interaction, ray, interval, material, sample, frame, counters);
    }
  } while (goes_on && interval.next());
  if (goes_on) advance(ray, 1, frame);
  if (interaction.deposits) ++counters.deposits;
  return interaction;
}

void count_end(const RayState& ray, Termination how, const Frame& frame, RayCounters& counters) {
  ++counters.rays;
  if (how == Termination::kOpaque) ++counters.terminated;
  if (!ray.is(wire::kLightingRay)) return;
  ++counters.lighting_rays;
  if (how != Termination::kLeft) return;
  const FinePoint step = fine(ray.step, frame.wide ? ray.step_rest : Rest{});
  const std::size_t face = face_left_by(ray.position, step, frame.extent);
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    const std::uint32_t units = energy_units(ray, frame, word);
    counters.energy_of(word).escaped += units;
    counters.energy_of(word).escaped_by_face[face] += units;
  }
}

}  // namespace gicube::emu
