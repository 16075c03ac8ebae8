// Rays that are traced side by side, one per lane: their words in lanes, and the pipeline's iterations.
//
// With equal steps, sample positions depend on the number of steps only, so the next samples are fetched while one is
// composited; a ray that has become opaque continues, and its further values are dropped. Jittered steps are drawn at
// the ray's position, so a ray that ends there stays there.

#include "functional/simd/shading_queue-inl.h"

// One word of all rays under way, by lane.
struct alignas(64) Word {
  std::array<std::int32_t, 16> lane{};

  V load() const { return hn::Load(D32(), lane.data()); }
  void store(V v) { hn::Store(v, D32(), lane.data()); }
};

// The rays under way. A ray ends when no steps are left, or by its opacity.
struct Lanes {
  std::array<Word, 3> position, step;
  std::array<Word, 2> sum;  // for integrals: the low kSumBits, and the higher bits
  Word ray;                 // index among the rays of the packet
  Word exponent, opacity;
  Word wide_opacity;                    // floats
  Word left;                            // steps to the end of a segment or of the volume; jittered: none or one
  Word more;                            // additional steps of a skip, which may overshoot the volume but not a segment
  std::array<Word, 3> rest, step_rest;  // wide datapath only
  // For jittered rays:
  std::array<Word, 3> direction;
  Word length, destination, taken;
};

constexpr int kSumBits = 20;

// The words of rays that an iteration changes.
struct LaneState {
  std::array<V, 3> position, step;
  std::array<V, 2> sum;
  V exponent, opacity, left;
  VF wide_opacity;
  std::array<V, 3> rest, step_rest;
};

template <bool kWide>
HWY_INLINE auto pace_of(const LaneState& ray) {
  if constexpr (kWide) {
    return pace_of(ray.step, ray.step_rest);
  } else {
    return pace_of(ray.step);
  }
}

template <bool kWide>
HWY_INLINE LaneState begin(const Lanes& lanes) {
  LaneState out{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.position[axis] = lanes.position[axis].load();
    out.step[axis] = lanes.step[axis].load();
  }
  out.sum = {lanes.sum[0].load(), lanes.sum[1].load()};
  out.exponent = lanes.exponent.load();
  out.opacity = lanes.opacity.load();
  out.left = lanes.left.load();
  if constexpr (kWide) {
    out.wide_opacity = hn::BitCast(DF(), lanes.wide_opacity.load());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.rest[axis] = lanes.rest[axis].load();
      out.step_rest[axis] = lanes.step_rest[axis].load();
    }
  }
  return out;
}

// advance() by at most 2^14 steps.
template <bool kWide>
HWY_INLINE void advance(LaneState& ray, V steps) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.position[axis] = hn::Add(ray.position[axis], hn::Mul(steps, ray.step[axis]));
    if constexpr (kWide) {
      const V sum = hn::Add(ray.rest[axis], hn::Mul(steps, ray.step_rest[axis]));
      ray.position[axis] = hn::Add(ray.position[axis], hn::ShiftRight<kRestBits>(sum));
      ray.rest[axis] = hn::And(sum, set((1 << kRestBits) - 1));
    }
  }
}

// advance() by any number of steps, such as all steps of a lane.
template <bool kWide>
HWY_INLINE void advance_far(LaneState& ray, V steps) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.position[axis] = hn::Add(ray.position[axis], hn::Mul(steps, ray.step[axis]));
    if constexpr (kWide) {
      // Multiplies the steps' high and low bits separately, because the product has more than 32.
      constexpr int kLow = 8;
      const V high = hn::Mul(hn::ShiftRight<kLow>(steps), ray.step_rest[axis]);
      const V low = hn::Mul(hn::And(steps, set((1 << kLow) - 1)), ray.step_rest[axis]);
      const V between = hn::ShiftLeft<kRestBits - kLow>(hn::And(high, set((1 << kLow) - 1)));
      const V sum = hn::Add(ray.rest[axis], hn::Add(low, between));
      ray.position[axis] =
          hn::Add(ray.position[axis], hn::Add(hn::ShiftRight<kRestBits - kLow>(high), hn::ShiftRight<kRestBits>(sum)));
      ray.rest[axis] = hn::And(sum, set((1 << kRestBits) - 1));
    }
  }
}

// jitter_step() for the lanes of `running`.
template <bool kWide>
HWY_INLINE void jitter_step(LaneState& ray, const Lanes& lanes, Mask running, const PacketField& field) {
  const V drawn = jitter_index(ray.position, lanes.destination.load());
  const V distance = gather(field.tables->distance.data(), hn::ShiftLeft<2>(drawn));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const V direction = lanes.direction[axis].load();
    if constexpr (kWide) {
      const FineStep step = fine_step_of(direction, distance);
      ray.step[axis] = hn::IfThenElse(running, step.whole, ray.step[axis]);
      ray.step_rest[axis] = hn::IfThenElse(running, step.rest, ray.step_rest[axis]);
    } else {
      ray.step[axis] = hn::IfThenElse(running, step_of(direction, distance), ray.step[axis]);
    }
  }
  ray.exponent = exponent_of(distance, lanes.length.load());
}

// Rays inside the volume and not beyond a cut plane.
template <bool kWide>
HWY_INLINE Mask kept(const LaneState& ray, const PacketField& field) {
  const D32 d;
  Mask out = hn::FirstN(d, 0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Mask outside =
        hn::Or(hn::Lt(ray.position[axis], hn::Zero(d)), hn::Gt(ray.position[axis], set(field.frame->extent[axis])));
    out = hn::Or(out, outside);
  }
  if (!field.frame->cut_planes.empty()) {
    std::array<Word, 3> position, step, rest, step_rest;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis].store(ray.position[axis]);
      step[axis].store(ray.step[axis]);
      if constexpr (kWide) {
        rest[axis].store(ray.rest[axis]);
        step_rest[axis].store(ray.step_rest[axis]);
      }
    }
    Word cut;
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
      const auto of_lane = [i](const auto& words) {
        return Point{words[0].lane[i], words[1].lane[i], words[2].lane[i]};
      };
      const auto rest_of_lane = [i](const auto& words) {
        Rest found{};
        for (std::size_t axis = 0; axis < 3; ++axis) found[axis] = static_cast<std::uint16_t>(words[axis].lane[i]);
        return found;
      };
      const Point p = of_lane(position), s = of_lane(step);
      for (const Plane& plane : field.frame->cut_planes) {
        const bool is_beyond = kWide ? fine_beyond(plane, fine(p, rest_of_lane(rest)), fine(s, rest_of_lane(step_rest)))
                                     : beyond(plane, p, s);
        cut.lane[i] |= is_beyond ? -1 : 0;
      }
    }
    out = hn::Or(out, hn::MaskFromVec(cut.load()));
  }
  return hn::Not(out);
}

// Other than 0 for the lanes of `which` whose samples lie at a cut face.
HWY_INLINE V at_cut_faces(const LaneState& ray, Mask which, const PacketField& field) {
  const D32 d;
  std::array<Word, 3> position, step;
  for (std::size_t axis = 0; axis < 3; ++axis)
    position[axis].store(ray.position[axis]), step[axis].store(ray.step[axis]);
  Word out;
  for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
    const Point p{position[0].lane[i], position[1].lane[i], position[2].lane[i]};
    const Point s{step[0].lane[i], step[1].lane[i], step[2].lane[i]};
    for (const Plane& plane : field.frame->cut_planes) out.lane[i] |= at_cut_face(plane, p, s) ? -1 : 0;
  }
  return hn::IfThenElseZero(which, out.load());
}

// Composites the samples of `taking` at `at`; `cell`: their positions in the block. Queues their colours in `seen`.
template <Gathers kGathers, bool kWide>
HWY_INLINE void composite(LaneState& ray, V rays, const SamplePosition& at, V density, Mask taking, V block, V cell,
                          ShadingQueue& seen, const PacketField& field, RayCounters& counters) {
  const D32 d;
  const V entry = classify(density, at, field);
  const V word = hn::IfThenElseZero(taking, gather(field.opacities, hn::ShiftLeft<2>(entry)));
  const Mask visible = hn::Ne(word, hn::Zero(d));
  if (hn::AllFalse(d, visible)) return;
  counters.visible_samples += hn::CountTrue(d, visible);
  V weight = hn::Zero(d);
  if constexpr (kWide) {
    const VF alpha = wide_alpha(word, ray.exponent, field), one = hn::Set(DF(), 1);
    const VF wide_weight = hn::Mul(hn::Sub(one, ray.wide_opacity), alpha);
    ray.wide_opacity = hn::IfThenElse(hn::Eq(alpha, one), one, hn::Add(ray.wide_opacity, wide_weight));
    const V words = hn::NearestInt(hn::Mul(ray.wide_opacity, hn::Set(DF(), static_cast<float>(wire::kOpacityOne))));
    ray.opacity = hn::IfThenElse(visible, words, ray.opacity);
    weight = hn::BitCast(d, wide_weight);
  } else {
    weight = weight_of(word, ray.exponent, ray.opacity, field);
    ray.opacity = hn::Add(ray.opacity, weight);
  }
  if constexpr (kGathers == Gathers::kColour) {
    const V lit = field.irradiance != nullptr ? irradiance_index(block, cell, field) : weight;
    const V at_face = field.cut_faces ? at_cut_faces(ray, visible, field) : weight;
    seen.add<kWide>(at, entry, rays, weight, lit, at_face, visible, field);
  }
}

// Index of the cubes of 1 << `shift` units that contain the rays of `which`; `across`, `slice`: cubes per row and
// slice.
HWY_INLINE V cube_index(const LaneState& ray, Mask which, int shift, std::int32_t across, std::int32_t slice) {
  const auto along = [&](std::size_t axis) {
    return hn::ShiftRightSame(hn::IfThenElseZero(which, ray.position[axis]), shift);
  };
  return hn::Add(along(0), hn::Add(hn::Mul(along(1), set(across)), hn::Mul(along(2), set(slice))));
}

// steps_out() on either datapath.
template <bool kWide, class Pace>
HWY_INLINE V steps_out(const LaneState& ray, V mask, const Pace& pace, const PacketField& field) {
  if constexpr (kWide) {
    return steps_out(ray.position, ray.rest, mask, pace, 1 << field.block_shift);
  } else {
    return steps_out(ray.position, mask, pace, 1 << field.block_shift);
  }
}

// Positions of samples, and their cells in their blocks; `first`: index of the blocks' first voxels among the decoded
// ones.
struct PositionInBlock {
  SamplePosition at;
  V cell;
};

HWY_INLINE PositionInBlock position_in_block(const LaneState& ray, V first, Mask samples, const PacketField& field) {
  PositionInBlock out;
  std::array<V, 3> voxel;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const V inside_block = hn::And(ray.position[axis], set((1 << field.block_shift) - 1));
    voxel[axis] = hn::ShiftRight<wire::kPositionFractionBits>(inside_block);
    out.at.fraction[axis] = hn::And(ray.position[axis], set(wire::kVoxel - 1));
    out.at.weight[axis] = hn::ShiftLeft<kWeightBits - wire::kPositionFractionBits>(out.at.fraction[axis]);
  }
  const V rows = hn::Add(voxel[1], hn::Mul(voxel[2], set(field.edge)));
  out.cell = hn::Add(voxel[0], hn::Mul(rows, set(field.edge)));
  out.at.index = hn::IfThenElseZero(samples, hn::Add(first, out.cell));
  return out;
}

// Takes the samples of `samples`, of which those of `taking` count. `first`: index of their blocks among the decoded
// ones.
template <Gathers kGathers, bool kWide>
HWY_INLINE void take_samples(LaneState& ray, V rays, V first, V block, Mask samples, Mask taking, ShadingQueue& seen,
                             const PacketField& field, RayCounters& counters) {
  const D32 d;
  const auto [at, cell] = position_in_block(ray, first, samples, field);
  const V density = resample_words(corners_of(field.densities, at.index, field.edge), at.weight);
  counters.samples += hn::CountTrue(d, taking);
  if constexpr (kGathers == Gathers::kIntegral) {
    const V sum = hn::Add(ray.sum[0], hn::IfThenElseZero(taking, density));
    ray.sum[0] = hn::And(sum, set((1 << kSumBits) - 1));
    ray.sum[1] = hn::Add(ray.sum[1], hn::ShiftRight<kSumBits>(sum));
    counters.visible_samples += hn::CountTrue(d, hn::And(taking, hn::Ne(density, hn::Zero(d))));
  } else {
    composite<kGathers, kWide>(ray, rays, at, density, taking, block, cell, seen, field, counters);
  }
}

// Advances all lanes until at least `enough` of them have ended.
template <Gathers kGathers, bool kJitter, bool kWide>
HWY_INLINE void march(Lanes& lanes, ShadingQueue& seen, const PacketField& field, std::size_t enough,
                      RayCounters& counters) {
  const D32 d;
  LaneState ray = begin<kWide>(lanes);
  const V more = lanes.more.load(), zero = hn::Zero(d), one = set(1), block_mask = set((1 << field.block_shift) - 1);
  const V rays = lanes.ray.load();
  auto pace = pace_of<kWide>(ray);
  V taken = zero, passed = zero;  // steps, and those over invisible samples
  Mask stepping{};
  while (true) {
    if constexpr (kJitter) {
      stepping = kept<kWide>(ray, field);
    } else {
      stepping = hn::Gt(ray.left, zero);
    }
    const Mask running = hn::And(stepping, hn::Lt(ray.opacity, set(field.threshold)));
    if (hn::Lanes(d) - hn::CountTrue(d, running) >= enough) break;
    if constexpr (kJitter) jitter_step<kWide>(ray, lanes, running, field);
    const Mask going = kJitter ? running : stepping;

    constexpr int kCellShift = CellRanges::kEdgeShift + wire::kPositionFractionBits;
    const V cell = cube_index(ray, going, kCellShift, field.cells_across, field.cells_slice);
    const V block =
        field.irradiance != nullptr ? cube_index(ray, going, field.block_shift, field.across, field.slice) : zero;
    const V first = gather(field.tables->first.data(), hn::ShiftLeft<2>(cell));
    const Mask skips = hn::And(going, hn::Lt(first, zero)), samples = hn::AndNot(skips, going);
    V steps = hn::IfThenElseZero(going, one);
    if (!hn::AllFalse(d, skips)) {
      const Mask block_skips = hn::And(skips, hn::Eq(first, set(kSkipped))), unseen = hn::AndNot(block_skips, skips);
      if constexpr (kJitter) pace = pace_of<kWide>(ray);
      const V mask = hn::IfThenElse(block_skips, block_mask, set((1 << kCellShift) - 1));
      V out = steps_out<kWide>(ray, mask, pace, field);
      if (!kJitter) out = hn::Min(out, hn::Add(ray.left, hn::IfThenElseZero(block_skips, more)));
      steps = hn::IfThenElse(skips, out, steps);
      counters.leaps += hn::CountTrue(d, hn::And(block_skips, running));
      passed = hn::Add(passed, hn::IfThenElseZero(hn::And(unseen, running), out));
    }
    if (!hn::AllFalse(d, samples)) {
      take_samples<kGathers, kWide>(ray, rays, first, block, samples, hn::And(samples, running), seen, field, counters);
    }
    taken = hn::Add(taken, hn::IfThenElseZero(running, steps));
    ray.left = hn::Sub(ray.left, steps);
    advance<kWide>(ray, steps);
  }
  counters.samples += static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(d, passed)));
  if constexpr (!kJitter) {  // opaque rays have continued
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ray.position[axis] = lanes.position[axis].load();
      if constexpr (kWide) ray.rest[axis] = lanes.rest[axis].load();
    }
    advance_far<kWide>(ray, taken);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lanes.position[axis].store(ray.position[axis]);
    if constexpr (kJitter) lanes.step[axis].store(ray.step[axis]);
    if constexpr (kWide) {
      lanes.rest[axis].store(ray.rest[axis]);
      if constexpr (kJitter) lanes.step_rest[axis].store(ray.step_rest[axis]);
    }
  }
  if constexpr (kGathers == Gathers::kIntegral) {
    for (std::size_t i = 0; i < 2; ++i) lanes.sum[i].store(ray.sum[i]);
  }
  lanes.opacity.store(ray.opacity);
  if (kWide) lanes.wide_opacity.store(hn::BitCast(d, ray.wide_opacity));
  if constexpr (kJitter) {
    lanes.left.store(hn::IfThenElseZero(stepping, one));
    lanes.taken.store(hn::Add(lanes.taken.load(), taken));
  } else {
    lanes.left.store(hn::Sub(lanes.left.load(), taken));
  }
}
