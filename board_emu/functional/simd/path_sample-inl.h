// One iteration of lighting and scattered rays, side by side, through samples after which a ray only continues.

#include "functional/simd/ray_interval-inl.h"

// Words of lighting and scattered rays in lanes, in addition to those of others. `taken` counts the steps since a ray
// was put on its lane, and `ray` is its index among the paths.
struct PathLanes : Lanes {
  std::array<DoubleWord, 3> slope, inverse;  // RayState::slope(), and its inverse; 0: no movement on this axis
  Word interacted, value;                    // RayState::interacted, and interaction_value()
  // Masks, all ones if true:
  Word begun;      // this path segment has taken a step
  Word scattered;  // the ray was scattered before
  Word trapped;    // the ray is still at the surface where it was
  Word masked;     // scalar code must take its sample
  // For lighting rays:
  std::array<std::array<Word, 2>, kColours> energy;  // per irradiance word: 24 bits, and 12
  Word phase;                                        // energy_phase()
  std::array<Word, 2> loss;                          // the path segment's part of the draws for the loss: 32 bits each
  KnownLanes known;  // what is known of the sample that is taken or waits for scalar code
};

// A ray's energy after a loss of `lost`, of 24 bits, as in interact_weighted(). 64-bit lanes.
HWY_INLINE VU64 energy_after(VU64 before, VU64 lost, VU64 chance) {
  constexpr std::uint64_t kLow = (1 << 24) - 1;
  static_assert(wire::kOpacityOne == kLow);
  const VU64 dither = hn::ShiftRight<24>(product(hn::ShiftRight<40>(chance), set64(wire::kOpacityOne)));
  const VU64 low = product(hn::And(before, set64(kLow)), lost);
  const VU64 high = product(hn::ShiftRight<24>(before), lost);
  // Division by 2^24 - 1: for x = h 2^24 + l the quotient is h plus that of h + l, and h + l < 2^48 takes one more
  // round.
  const VU64 x = hn::Add(hn::Add(low, dither), hn::ShiftLeft<24>(high));
  const VU64 rounds = hn::ShiftRight<24>(x), rest = hn::Add(rounds, hn::And(x, set64(kLow)));
  const VU64 more = hn::ShiftRight<24>(hn::Add(hn::Add(rest, hn::ShiftRight<24>(rest)), set64(1)));
  return hn::Sub(before, hn::Add(rounds, more));
}

// draw_at() for the losses of rays at `position`.
HWY_INLINE VU64 draw_here(const std::array<VU64, 3>& position, VU64 of_segment) {
  const VU64 low = hn::Or(position[0], hn::ShiftLeft<32>(position[1]));
  return mix64(hn::Xor(mix64(hn::Xor(mix64(low), position[2])), of_segment));
}

// Per irradiance word, 24 bits and 12; only as many words are used as the rays have.
using EnergyLanes = std::array<std::array<V, 2>, kColours>;

struct Energy {
  EnergyLanes words;
  Mask same_units;  // as many whole units as before in each word, and some are left
};

template <std::size_t kWords>
HWY_INLINE Energy lose(const PathLanes& lanes, const std::array<V, 3>& position, const EnergyLanes& energy, V lost) {
  const V phase = lanes.phase.load(), loss_low = lanes.loss[0].load(), loss_high = lanes.loss[1].load();
  const VU64 zero = hn::Zero(DU64());
  struct Half {
    std::array<VU64, kWords> energy;
    VU64 same;
  };
  const auto half = [&](auto of) {
    const VU64 segment = hn::Or(of(loss_low), hn::ShiftLeft<32>(of(loss_high)));
    const VU64 chance = draw_here({of(position[0]), of(position[1]), of(position[2])}, segment);
    Half out{};
    VU64 any = zero, all = hn::Not(zero);
    for (std::size_t word = 0; word < kWords; ++word) {
      const VU64 before = hn::Or(of(energy[word][0]), hn::ShiftLeft<24>(of(energy[word][1])));
      out.energy[word] = energy_after(before, of(lost), chance);
      const auto units = [&](VU64 of_energy) {
        return hn::ShiftRight<kEnergyFractionBits>(hn::Add(of_energy, of(phase)));
      };
      const VU64 left = units(out.energy[word]);
      any = hn::Or(any, left);
      all = hn::And(all, hn::VecFromMask(DU64(), hn::Eq(left, units(before))));
    }
    out.same = hn::VecFromMask(DU64(), hn::AndNot(hn::Eq(any, zero), hn::MaskFromVec(all)));
    return out;
  };
  const Half even = half([](V v) { return evens(v); }), odd = half([](V v) { return odds(v); });
  const VU64 low = set64((1 << 24) - 1);
  Energy out;
  for (std::size_t word = 0; word < kWords; ++word) {
    out.words[word][0] = together(hn::And(even.energy[word], low), hn::And(odd.energy[word], low));
    out.words[word][1] = together(hn::ShiftRight<24>(even.energy[word]), hn::ShiftRight<24>(odd.energy[word]));
  }
  out.same_units = hn::MaskFromVec(together(even.same, odd.same));
  return out;
}

// Effects of samples on their rays, apart from the step.
struct SampleResult {
  Mask goes_on;  // the ray only continues
  Mask waits;    // until more lanes are in a medium
  Mask visible;
  Mask trapped;  // the ray is still at the surface where it was
  EnergyLanes energy;
  V interacted;
  V weight;  // weight of the sample in the ray's colour
};

// kWeighted and kColouredWeighted: weighted photons, with one or three irradiance words.
enum class PathKind : std::uint8_t { kWeighted, kColouredWeighted, kPhoton, kRendering };
constexpr std::size_t words_of(PathKind kind) {  // words of energy that lanes change
  return kind == PathKind::kColouredWeighted ? kColours : kind == PathKind::kWeighted ? 1 : 0;
}

struct SampleLanes {
  SamplePosition at;
  V cell;          // index in its block
  V entry, depth;  // entry of the segmentation LUT; its opacity, 0: none (PacketField::opacities)
  Corners corners;
};

HWY_INLINE SampleLanes sample_at(const LaneState& ray, V first, Mask samples, const PacketField& field) {
  SampleLanes out;
  const auto place = position_in_block(ray, first, samples, field);
  out.at = place.at;
  out.cell = place.cell;
  out.corners = corners_of(field.densities, out.at.index, field.edge);
  out.entry = classify(resample_words(out.corners, out.at.weight), out.at, field);
  out.depth = hn::IfThenElseZero(samples, gather(field.opacities, hn::ShiftLeft<2>(out.entry)));
  return out;
}

// Sets the opacities of the integration intervals of samples in a medium, with the conserving rules, and what
// determines them. `even`: all eight voxels around the sample have one opacity and one tag. Returns for which samples
// it could.
template <bool kWide>
HWY_INLINE Mask find_intervals(PathLanes& lanes, const LaneState& ray, V begun, const SampleLanes& sample, Mask one_tag,
                               Mask even, Mask in_medium, V& alpha, const PacketField& field) {
  const D32 d;
  const auto doubles = [](const std::array<DoubleWord, 3>& words) {
    return std::array<Doubles, 3>{words[0].load(), words[1].load(), words[2].load()};
  };
  const WayLanes way = way_of<kWide>(ray, doubles(lanes.slope), doubles(lanes.inverse), begun, field);
  const Interval<VD> low = interval_of(path_around(way, LowerLanes())),
                     high = interval_of(path_around(way, UpperLanes()));
  const Exponent interval = exponent_of({low.begin, high.begin}, {low.end, high.end}, ray.exponent);
  const Mask even_intervals = hn::And(hn::And(in_medium, even), interval.valid), mixed = hn::AndNot(even, in_medium);
  alpha = hn::IfThenElseZero(even_intervals, corrected(sample.depth, interval.word, field));
  Mask found = even_intervals;
  KnownLanes& known = lanes.known;
  known.put_ends(0, {low.begin, high.begin}, in_medium);
  known.put_ends(4, {low.end, high.end}, in_medium);
  if (!hn::AllFalse(d, mixed)) {
    const V tag = hn::And(sample.entry, set(~0xFFF));
    const auto depth = [&](const Interval<VD>& of, auto half) {
      return depth_of_interval(of, way, sample.corners, sample.at.fraction, tag, ray.exponent, *field.light, half);
    };
    const DepthLanes below = depth(low, LowerLanes()), above = depth(high, UpperLanes());
    const V least = truncated({below.least, above.least}), most = truncated({below.most, above.most});
    const V opaque = gather(field.light->opaque_up, hn::ShiftLeft<2>(hn::IfThenElseZero(mixed, least)));
    const Mask wall = hn::AndNot(hn::Gt(opaque, most), hn::Gt(opaque, set(-1)));  // all ones: none
    const Mask seen_through = hn::And(hn::AndNot(wall, mixed), one_tag);
    found = hn::Or(found, seen_through);
    alpha = hn::IfThenElse(seen_through, opacity_of({below.depth, above.depth}, seen_through), alpha);
    known.put_pieces(below, above, mixed);
  }
  known.put(sample.entry, alpha, even, found, in_medium);
  return found;
}

// Rays at a reflecting surface that leave it, as in leaves().
HWY_INLINE Mask leave(const PathLanes& lanes, const SampleLanes& sample, Mask reflecting, const PacketField& field) {
  const Mask scattered = hn::And(reflecting, hn::MaskFromVec(lanes.scattered.load()));
  if (hn::AllFalse(D32(), scattered)) return scattered;
  PackedPosition at = small(sample.at);
  at.index = hn::IfThenElseZero(scattered, at.index);  // reads no memory for the others
  const std::array<V, 3> gradient = resample_gradient(at, field);
  V along = hn::Zero(D32());  // a unit vector of 14 bits times words of 16
  for (std::size_t axis = 0; axis < 3; ++axis) {
    along = hn::Add(along, hn::Mul(lanes.direction[axis].load(), gradient[axis]));
  }
  return hn::And(hn::Lt(along, hn::Zero(D32())), scattered);
}

// Removes from `in_medium` rays at a surface without interaction. `masked`: rays at a surface that scalar code must
// handle.
HWY_INLINE void pass_surfaces(SampleResult& out, Mask& in_medium, Mask& masked, const PathLanes& lanes, V trapped,
                              const MaterialLanes& material, const SampleLanes& sample, const PacketField& field) {
  const Mask traps = hn::And(in_medium, material.traps), reflecting = hn::And(in_medium, material.reflects);
  out.trapped = hn::And(traps, hn::MaskFromVec(trapped));
  masked = hn::AndNot(out.trapped, traps);
  in_medium = hn::AndNot(traps, in_medium);
  if (hn::AllFalse(D32(), reflecting)) return;
  if (field.light->cubes) {
    in_medium = hn::AndNot(leave(lanes, sample, reflecting, field), in_medium);
  } else {
    masked = hn::Or(masked, reflecting);
  }
}

// Accumulates the opacity of the samples of `in_medium`. Returns which rays interact, as in interacts().
HWY_INLINE Mask accumulate(SampleResult& out, V opacity, Mask in_medium, const PathLanes& lanes) {
  const V before = out.interacted, so_far = hn::Add(before, behind(before, opacity));
  out.interacted = hn::IfThenElse(in_medium, so_far, before);
  return hn::And(in_medium, hn::AndNot(hn::Gt(lanes.value.load(), so_far), hn::Ne(so_far, before)));
}

// Effects of a medium on lighting rays.
template <PathKind kKind>
HWY_INLINE void meet(SampleResult& out, const PathLanes& lanes, const LaneState& ray, V trapped, V alpha,
                     Mask in_medium, const SampleLanes& sample, const PacketField& field) {
  const LightField& light = *field.light;
  const MaterialLanes material = material_of(hn::ShiftRight<12>(sample.entry), light);
  Mask masked;
  pass_surfaces(out, in_medium, masked, lanes, trapped, material, sample, field);
  V opacity = alpha;
  constexpr std::size_t kWords = words_of(kKind);
  if constexpr (kWords > 0) {
    const EnergyLanes energy = out.energy;
    const bool printed = light.runs == nullptr;
    const Energy after =
        lose<kWords>(lanes, ray.position, energy, printed ? alpha : absorption_opacity(alpha, material));
    opacity = hn::IfThenZeroElse(material.straight, printed ? alpha : scattering_opacity(alpha, material));
    for (std::size_t word = 0; word < kWords; ++word) {
      for (std::size_t i = 0; i < 2; ++i) {
        out.energy[word][i] = hn::IfThenElse(in_medium, after.words[word][i], energy[word][i]);
      }
    }
    masked = hn::Or(masked, hn::AndNot(after.same_units, in_medium));
  } else {
    opacity = hn::IfThenElse(material.straight, absorption_opacity(alpha, material), alpha);
  }
  masked = hn::Or(masked, accumulate(out, opacity, in_medium, lanes));
  out.goes_on = hn::AndNot(masked, out.goes_on);
}

// Effects of a medium on rendering rays.
HWY_INLINE void gather_light(SampleResult& out, const PathLanes& lanes, const LaneState& ray, V trapped, Mask in_medium,
                             const SampleLanes& sample, const PacketField& field) {
  const LightField& light = *field.light;
  const MaterialLanes material = material_of(hn::ShiftRight<12>(sample.entry), light);
  Mask masked;
  pass_surfaces(out, in_medium, masked, lanes, trapped, material, sample, field);
  if (field.frame->wide) {  // floats are summed in the order of samples
    out.goes_on = hn::AndNot(hn::Or(masked, in_medium), out.goes_on);
    return;
  }
  const V alpha = corrected(sample.depth, ray.exponent, field);
  if (light.high_albedo || light.scatters) {
    const V opacity = light.high_albedo ? alpha : scattering_opacity(alpha, material);
    masked = hn::Or(masked, accumulate(out, opacity, in_medium, lanes));
  }
  out.goes_on = hn::AndNot(masked, out.goes_on);
  if (light.high_albedo) return;  // colour is taken at the absorption
  const V weight = behind(ray.opacity, absorption_opacity(alpha, material));
  out.weight = hn::IfThenElseZero(hn::And(in_medium, out.goes_on), weight);
}

// Tries the samples of `samples`. Those in a medium cost most, so they wait until enough lanes have one.
template <PathKind kKind, bool kWide>
HWY_INLINE SampleResult try_samples(PathLanes& lanes, const LaneState& ray, V begun, V trapped,
                                    const EnergyLanes& energy, V interacted, const SampleLanes& sample, Mask samples,
                                    const PacketField& field) {
  const D32 d;
  const V zero = hn::Zero(d);
  const Mask visible = hn::Ne(sample.depth, zero), none = hn::FirstN(d, 0);
  SampleResult out{samples, none, visible, none, energy, interacted, zero};
  if constexpr (kKind == PathKind::kRendering) {
    if (!hn::AllFalse(d, visible)) gather_light(out, lanes, ray, trapped, visible, sample, field);
  } else {
    const LightField& light = *field.light;
    Mask in_medium = visible, even = none, one_tag = none;
    if (light.runs != nullptr) {
      one_tag = has_one_tag(sample.at.index, field);
      even = hn::And(is_even(sample.corners, sample.entry, light), one_tag);
      in_medium = hn::And(samples, hn::Or(visible, hn::Not(even)));
    }
    const std::size_t dense = hn::CountTrue(d, in_medium);
    if (dense == 0) return out;
    if (dense < hn::Lanes(d) / 2 && dense < hn::CountTrue(d, samples)) {
      out.goes_on = hn::AndNot(in_medium, samples);
      out.waits = in_medium;
      return out;
    }
    V alpha;
    if (light.runs != nullptr) {
      const Mask known = find_intervals<kWide>(lanes, ray, begun, sample, one_tag, even, in_medium, alpha, field);
      out.goes_on = hn::AndNot(hn::AndNot(known, in_medium), samples);
      in_medium = hn::And(hn::And(in_medium, known), hn::Ne(alpha, zero));
    } else {
      alpha = corrected(sample.depth, ray.exponent, field);
    }
    meet<kKind>(out, lanes, ray, trapped, alpha, in_medium, sample, field);
  }
  return out;
}

// Queues the samples' colours in `seen`.
HWY_INLINE void gather_colour(ShadingQueue& seen, const SampleLanes& sample, const SampleResult& taken,
                              const LaneState& ray, const PathLanes& lanes, const PacketField& field) {
  const Mask coloured = hn::Ne(taken.weight, hn::Zero(D32()));
  if (hn::AllFalse(D32(), coloured)) return;
  V lit = taken.weight;
  if (field.irradiance != nullptr) {
    const V block = cube_index(ray, coloured, field.block_shift, field.across, field.slice);
    lit = irradiance_index(block, hn::IfThenElseZero(coloured, sample.cell), field);
  }
  const V at_face = field.cut_faces ? at_cut_faces(ray, coloured, field) : lit;
  seen.add<false>(sample.at, sample.entry, lanes.ray.load(), taken.weight, lit, at_face, coloured, field);
}
