// The state of a ray between two samples, and the operations of one iteration through the pipeline. Every fidelity
// level uses these, so that values cannot differ; their cost is computed elsewhere.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "datapath/advance.h"
#include "datapath/composite.h"
#include "datapath/frame.h"
#include "datapath/jitter.h"
#include "datapath/resample.h"
#include "datapath/shade.h"
#include "datapath/tint.h"
#include "datapath/wide.h"
#include "words/block_grid.h"

namespace gicube::emu {

// The ray packet's words in the pipeline's registers, and values derived from its direction.
struct RayState {
  Point position{};
  Point step{};                // to the next sample
  std::uint32_t exponent = 0;  // the distance for opacity correction: 16.16 voxel lengths
  std::uint32_t length = 0;    // one voxel length along the direction: 16.16 reference voxel lengths
  std::uint32_t opacity = 0;   // 2^24 - 1 = one; lighting rays use `interacted` instead
  // Opacity since the last scattering. A rendering ray's packet has its 24 bits in place of `contribution`, which
  // follows from the opacity, and `interaction`, which is drawn again on demand. A segment has its steps_left() here.
  std::uint32_t interacted = 0;
  std::array<std::uint16_t, 3> colour{};  // premultiplied, 4095 = one; or another quantity, see below
  std::array<std::int16_t, 3> direction{};
  std::uint16_t u = 0;
  std::uint16_t v = 0;
  std::uint16_t lifetime = 0;       // scatterings left
  std::uint8_t generation : 4 = 0;  // scatterings so far, saturating at 15
  std::uint8_t under_way : 1 = 0;   // has taken a sample or a skip since its start or scattering
  std::uint8_t flags = 0;           // wire::RayFlag; bits 6 and 7: material's tag of a trapped ray

  // Used only by the wide datapath.
  WideWords wide{};
  Rest rest{}, step_rest{};  // fractions of position and step, which have the whole units

  // Energy of green and blue, with three irradiance words; `colour` has that of red.
  std::array<std::array<std::uint16_t, 3>, 2> more_energy{};

  bool is(wire::RayFlag flag) const { return (flags & flag) != 0; }

  // The 36 bits of `colour` hold the energy of a lighting ray, 24.12 units; the density sum of an integral; or, in
  // their low 24 bits, the contribution per sample of a backprojecting ray.
  std::uint64_t energy() const { return word_of(colour); }
  void set_energy(std::uint64_t word) { put_word(word, colour); }
  // The energy for an irradiance word; 0 is red or the only one.
  std::uint64_t energy(std::size_t word) const { return word == 0 ? energy() : word_of(more_energy[word - 1]); }
  void set_energy(std::size_t word, std::uint64_t energy) {
    put_word(energy, word == 0 ? colour : more_energy[word - 1]);
  }
  std::uint64_t density_sum() const { return energy(); }
  void set_density_sum(std::uint64_t sum) { set_energy(sum); }
  std::int32_t amount() const { return wire::sign_extend(static_cast<std::uint32_t>(energy()), 24); }
  void set_amount(std::uint32_t word) { set_energy(word); }

  FinePoint fine_position() const { return fine(position, rest); }
  FinePoint fine_step() const { return fine(step, step_rest); }
  void set_fine_position(const FinePoint& at) {
    position = units_of(at);
    rest = rest_of(at);
  }
  void set_fine_step(const FinePoint& a_step) {
    step = units_of(a_step);
    step_rest = rest_of(a_step);
  }
  // The step along an axis, in position units.
  double slope(std::size_t axis) const { return step[axis] + step_rest[axis] * (1.0 / (1 << kRestBits)); }

  void state(Archive::Record& record) {
    std::uint8_t interactions = generation, has_begun = under_way;
    record(position, step, exponent, length);
    record.at_most(opacity, wire::kOpacityOne);
    record(interacted, colour, direction, u, v, lifetime, flags);
    record.at_most(interactions, 15);
    record.at_most(has_begun, 1);
    record(wide.opacity, wide.colour, rest, step_rest, more_energy[0], more_energy[1]);
    generation = interactions & 15;
    under_way = has_begun & 1;
  }

  static std::uint64_t word_of(const std::array<std::uint16_t, 3>& parts) {
    return parts[0] | std::uint64_t{parts[1]} << 12 | std::uint64_t{parts[2]} << 24;
  }
  static void put_word(std::uint64_t word, std::array<std::uint16_t, 3>& parts) {
    for (std::size_t i = 0; i < 3; ++i) parts[i] = static_cast<std::uint16_t>(word >> (12 * i) & 0xFFF);
  }

  std::int32_t steps_left() const { return static_cast<std::int32_t>(interacted); }
  void set_steps_left(std::int32_t steps) { interacted = static_cast<std::uint32_t>(steps); }
};
static_assert(offsetof(RayState, wide) == 60,
              "the paper's words and a block fill one of the host's lines (ray_store.h)");

inline constexpr int kTrapTagShift = 6;

inline constexpr int kEnergyFractionBits = 12;

// Reference voxel lengths per voxel length along `direction`, 16.16. Exactly one if the spacing is one.
std::uint32_t physical_length(const std::array<std::int16_t, 3>& direction,
                              const std::array<std::uint32_t, 3>& spacing);

// Sets the distance to the next sample, 16.16 voxels.
inline void space(RayState& ray, std::uint32_t distance, const Frame& frame) {
  if (frame.wide) {
    ray.set_fine_step(fine_step_vector(ray.direction, distance));
  } else {
    ray.step = step_vector(ray.direction, distance);
  }
  ray.exponent =
      static_cast<std::uint32_t>(round_shift<16>(static_cast<std::int64_t>(std::uint64_t{distance} * ray.length)));
}

// divide() for the wide datapath: divides the segment's own vector, so that a step is exact to 2^-17 of a unit.
inline void divide_finely(RayState& ray, std::uint32_t length, std::uint32_t steps, const Frame& frame) {
  const FinePoint whole = fine_step_vector(ray.direction, length), most = fine_extent(frame.extent);
  FinePoint at = ray.fine_position(), step{};
  const std::int64_t count = steps, others = count - 1;
  // The direction's rounding, half a unit per voxel, could take the last sample of a segment along a face out of the
  // volume.
  const std::int64_t rounding = std::int64_t{(length >> 17) + 3} << kRestBits;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    step[axis] = (2 * whole[axis] + (whole[axis] < 0 ? -count : count)) / (2 * count);
    at[axis] = std::clamp<std::int64_t>(at[axis] + (whole[axis] - others * step[axis]) / 2, 0, most[axis]);
    const std::int64_t last = at[axis] + others * step[axis], face = last < 0 ? 0 : most[axis];
    const std::int64_t beyond = last < 0 ? -last : last - most[axis];
    if (others > 0 && beyond > 0 && beyond <= rounding) step[axis] = (face - at[axis]) / others;
  }
  ray.set_fine_position(at);
  ray.set_fine_step(step);
}

// Divides a segment's `length`, 16.16 voxels, into equal steps of at most the frame's, and moves to the middle of the
// first.
[[gnu::always_inline]] inline void divide(RayState& ray, std::uint32_t length, const Frame& frame) {
  const std::uint32_t steps = wire::steps_of(length, frame.step);
  ray.set_steps_left(static_cast<std::int32_t>(steps));
  ray.colour = {};
  if (steps == 0) return space(ray, frame.step, frame);
  const std::uint32_t below = length / steps, rest = length % steps;
  space(ray, below + (rest >= steps - steps / 2 ? 1 : 0), frame);  // length / steps, rounded to nearest
  if (frame.wide) return divide_finely(ray, length, steps, frame);
  const Point half = step_vector(ray.direction, (below + 1) / 2);  // length / 2 / steps, rounded to nearest
  // Direction and step are rounded (half a unit per voxel and per step, an eighth for the step's length), so a segment
  // along a face could leave the volume before its last sample. If it does so by no more than that, the step is
  // shortened slightly.
  const auto others = static_cast<std::int32_t>(steps) - 1;
  const std::int32_t rounding = static_cast<std::int32_t>((length >> 17) + steps * 5 / 8) + 3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t first = std::clamp(ray.position[axis] + half[axis], 0, frame.extent[axis]);
    ray.position[axis] = first;
    const std::int64_t last = first + std::int64_t{others} * ray.step[axis];
    const std::int64_t beyond = last < 0 ? -last : last - frame.extent[axis];
    if (others == 0 || beyond <= 0 || beyond > rounding) continue;
    ray.step[axis] += static_cast<std::int32_t>((beyond + others - 1) / others) * (last < 0 ? 1 : -1);
  }
}

// Divides the packet's energy among the colours.
inline void colour_energy(RayState& ray, const Frame& frame) {
  const std::uint64_t all = ray.energy();
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    const std::uint64_t part = all * frame.light_colour[word];
    ray.set_energy(word, (part + wire::kScatteringOne / 2) / wire::kScatteringOne);
  }
}

// Inline: otherwise the compilers write the ray in small parts and read it in large ones, which stalls the host.
[[gnu::always_inline]] inline RayState unpack(const wire::Ray& ray, const Frame& frame) {
  RayState out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.position[axis] = static_cast<std::int32_t>(ray.position[axis]);
    out.colour[axis] = ray.colour[axis];
  }
  out.opacity = ray.opacity;
  out.lifetime = ray.lifetime;
  out.generation = ray.generation & 15u;
  out.flags = ray.flags;
  out.length = physical_length(ray.direction, frame.spacing);
  out.u = ray.u;
  out.v = ray.v;
  out.direction = ray.direction;
  if (frame.wide) out.rest = kHalfUnits;
  if (frame.segments()) {
    divide(out, static_cast<std::uint32_t>(ray.colour_word()), frame);
  } else {
    space(out, frame.step, frame);
  }
  if (frame.backprojects()) {
    out.set_amount(ray.opacity);
    out.opacity = 0;
  }
  if (frame.wide) out.wide = wide_words(out);
  if (frame.light_words > 1 && out.is(wire::kLightingRay)) colour_energy(out, frame);
  return out;
}

// Writes the ray's accumulated values, and its end position, clamped to the volume, into its packet.
inline void pack(const RayState& ray, const Frame& frame, wire::Ray& out) {
  const bool hit = frame.to_the_hit() && ray.opacity >= frame.opacity_threshold;
  Point place = ray.position;
  if (hit || frame.segments()) {  // back from the next sample to the hit, or to the segment's end
    const int parts = hit ? 1 : 2;
    const FinePoint at = ray.fine_position(), step = ray.fine_step();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = frame.wide ? static_cast<std::int32_t>((at[axis] - step[axis] / parts) >> kRestBits)
                               : ray.position[axis] - ray.step[axis] / parts;
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.position[axis] = static_cast<std::uint32_t>(std::clamp(place[axis], 0, frame.extent[axis]));
    out.colour[axis] = ray.colour[axis];
  }
  out.direction = ray.direction;
  out.opacity = ray.opacity;
  out.contribution = contribution(ray.opacity);
  out.lifetime = ray.lifetime;
  out.generation = ray.generation;
}

// The ray as a packet.
inline wire::Ray pack(const RayState& ray, const Frame& frame) {
  wire::Ray out;
  out.u = ray.u;
  out.v = ray.v;
  out.flags = ray.flags;
  pack(ray, frame, out);
  return out;
}

// Whether and how a ray has ended. kLeft: out of the volume, behind a cut plane or at a segment's end. kAbsorbed: or
// given up. A waiting ray has not ended: kWaits for the host, which has the ray; kNonResident for a block.
enum class Termination : std::uint8_t { kActive, kLeft, kOpaque, kAbsorbed, kWaits, kNonResident };

inline Termination end(const RayState& ray, const Frame& frame) {
  if (!inside(ray.position, frame.extent)) return Termination::kLeft;
  if (frame.segments() && ray.steps_left() == 0) return Termination::kLeft;
  for (const Plane& plane : frame.cut_planes) {
    if (frame.wide ? fine_beyond(plane, ray.fine_position(), ray.fine_step()) : beyond(plane, ray.position, ray.step)) {
      return Termination::kLeft;
    }
  }
  return ray.opacity >= frame.opacity_threshold ? Termination::kOpaque : Termination::kActive;
}

// The packet of a ray that has ended. With lamps, a ray that left has the last position inside the volume, which is on
// its line, unlike a position clamped to a face. Other rays have no contribution, because nothing outside can add to
// them.
inline void pack_ended(const RayState& ray, const Frame& frame, wire::Ray& out) {
  pack(ray, frame, out);
  if (!frame.lamps) return;
  if (end(ray, frame) != Termination::kLeft) {
    out.contribution = 0;
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.position[axis] =
        static_cast<std::uint32_t>(std::clamp(ray.position[axis] - ray.step[axis], 0, frame.extent[axis]));
  }
}
inline wire::Ray pack_ended(const RayState& ray, const Frame& frame) {
  wire::Ray out = pack(ray, frame);
  if (frame.lamps) pack_ended(ray, frame, out);
  return out;
}

// Whether the ray's sample takes light.
inline bool is_shaded(const RayState& ray, const Frame& frame) {
  if (!frame.shade || !frame.cut_faces) return frame.shade;
  return std::none_of(frame.cut_planes.begin(), frame.cut_planes.end(),
                      [&ray](const Plane& plane) { return at_cut_face(plane, ray.position, ray.step); });
}

// Composites a sample of the classified opacity behind the ray's accumulated values.
inline void composite(RayState& ray, const Colour12& colour, std::size_t index, const Frame& frame) {
  if (gathers_wide(frame)) return over(ray, ray.wide, colour, wide_alpha(frame.wide_depths[index], ray.exponent));
  over(ray, colour, (*frame.opacity_correction)(frame.segmentation[index].opacity, ray.exponent));
}

// Whether samples of this entry of the segmentation LUT have an opacity.
inline bool visible(std::size_t index, const Frame& frame) {
  return gathers_wide(frame) ? frame.wide_depths[index] != 0 : frame.segmentation[index].opacity != 0;
}

// Position of a sample: its cell in a block of (edge)^3 voxels, +1 faces included, and the block's index.
struct SampleSite {
  const Cell& cell;
  const BlockView& view;
  std::size_t block = 0;
  std::size_t edge = 0;
};

inline Neighbourhood around(const SampleSite& site) {
  const Cell& at = site.cell;
  const std::size_t row = site.edge, slice = site.edge * site.edge;
  return {at.voxel[0] + row * at.voxel[1] + slice * at.voxel[2],
          row,
          slice,
          {weight(at.fraction[0]), weight(at.fraction[1]), weight(at.fraction[2])}};
}

// The tag of the nearest voxel.
inline unsigned tag_at(const SampleSite& site, const Neighbourhood& at) {
  if (site.view.codes == nullptr) return 0;
  constexpr std::uint32_t kHalf = wire::kVoxel / 2;
  const auto& fraction = site.cell.fraction;
  return tag_of(site.view.codes[at.first + (fraction[0] >= kHalf) + at.row * (fraction[1] >= kHalf) +
                                at.slice * (fraction[2] >= kHalf)]);
}

// Whether all voxels around the sample have its tag.
inline bool has_one_tag(const SampleSite& site) {
  if (site.view.codes == nullptr) return true;
  const Neighbourhood at = around(site);
  const std::uint16_t* const first = site.view.codes + at.first;
  unsigned differ = 0;
  for (const std::size_t row : {std::size_t{0}, at.row, at.slice, at.row + at.slice}) {
    differ |= (first[0] ^ first[row]) | (first[0] ^ first[row + 1]);
  }
  return tag_of(static_cast<std::uint16_t>(differ)) == 0;
}

// The interpolated gradient, x, y, z in the last three channels.
inline Channels gradient_at(const BlockView& view, const Neighbourhood& at) {
  if (view.codes == nullptr) return view.gradients[0].channel;
  return resample_all(
      at, [&view](std::size_t i) -> const ChannelWords& { return view.gradients[gradient_code(view.codes[i])]; });
}
inline Point point_of(const Channels& gradient) { return {gradient[1], gradient[2], gradient[3]}; }

// A sample's entry of the segmentation LUT, tinted by the colour of its voxels if they have one.
inline wire::SegmentationEntry coloured(const wire::SegmentationEntry& entry, const BlockView& view,
                                        const Neighbourhood& at, const Frame& frame) {
  if (view.colours == nullptr) [[likely]]
    return entry;
  const Channels words = resample_all(at, [&view](std::size_t i) -> const ChannelWords& { return view.colours[i]; });
  return tinted(entry, colour_of_words(words, frame.volume->format() == wire::VoxelFormat::kRgba));
}

// Resamples, classifies, shades and composites. Returns false if the sample has no opacity. Inline, because each
// iteration takes one sample, and a call would put `site` into memory.
[[gnu::always_inline]] inline bool take_sample(RayState& ray, const SampleSite& site, const Frame& frame) {
  const Neighbourhood at = around(site);
  const std::int16_t density = resample_density(site.view.densities, at);
  if (frame.integral()) {
    ray.set_density_sum(ray.density_sum() + static_cast<std::uint64_t>(density));
    return density != 0;
  }
  const std::size_t index = segmentation_index(density, tag_at(site, at));
  if (!visible(index, frame)) return false;
  Colour12 colour{};
  if (!frame.colourless()) {
    const wire::SegmentationEntry entry = coloured(frame.segmentation[index], site.view, at, frame);
    colour = is_shaded(ray, frame) ? shade(entry, point_of(gradient_at(site.view, at)), frame.reflectance_map)
                                   : Colour12{entry.colour[0], entry.colour[1], entry.colour[2]};
  }
  composite(ray, colour, index, frame);
  return true;
}

// The frame's step times the factor of jitter(), 16.16 voxels.
inline std::uint32_t jittered(const Frame& frame, std::uint32_t factor) {
  return static_cast<std::uint32_t>(round_shift<16>(std::int64_t{frame.step} * factor));
}

// Draws the distance to the next sample, if the frame jitters.
inline void jitter_step(RayState& ray, const Frame& frame) {
  if (!frame.jitter) return;
  space(ray, jittered(frame, jitter(ray.position, ray.u, ray.v)), frame);
}

// The sorter's weight of a ray, 12 bits: the fraction that a rendering ray can still add to the image; a lighting ray's
// energy, the greatest of three.
inline constexpr std::uint16_t kFullContribution = 4095;
inline std::uint16_t contribution(const RayState& ray) {
  if (!ray.is(wire::kLightingRay)) return contribution(ray.opacity);
  constexpr int kShift = kEnergyFractionBits - 4;  // 255 units fill 12 bits
  const std::uint64_t energy = std::max({ray.energy(0), ray.energy(1), ray.energy(2)});
  return static_cast<std::uint16_t>(std::min<std::uint64_t>(energy >> kShift, kFullContribution));
}

inline void advance(RayState& ray, std::int32_t steps, const Frame& frame) {
  if (frame.wide) return ray.set_fine_position(moved(ray.fine_position(), ray.fine_step(), steps));
  for (std::size_t axis = 0; axis < 3; ++axis) ray.position[axis] += steps * ray.step[axis];
}

// The number of steps that take the ray out of its empty block [low, low + size), or a segment to its end.
inline std::int32_t skip_steps(const RayState& ray, const Point& low, std::int32_t size, const Frame& frame) {
  const std::int32_t steps =
      frame.wide ? skip_steps(ray.fine_position(), ray.fine_step(), fine(low, {}), std::int64_t{size} << kRestBits)
                 : skip_steps(ray.position, ray.step, low, size);
  return frame.segments() ? std::min(steps, ray.steps_left()) : steps;
}

// Subtracts `steps` from a segment's remaining steps.
inline void count_steps(RayState& ray, std::int32_t steps, const Frame& frame) {
  if (frame.segments()) ray.set_steps_left(ray.steps_left() - steps);
}

}  // namespace gicube::emu
