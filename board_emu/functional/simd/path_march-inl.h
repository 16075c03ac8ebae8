// Lighting and scattered rays side by side, one per lane. A lane does the iterations in which its ray only continues:
// over invisible parts and, for lighting rays, through samples that take energy and do nothing else. At any other
// sample the lane is masked until scalar code has taken the sample (take_iteration()).

#include "functional/simd/path_sample-inl.h"

// Advances all lanes until at least `enough` of them are masked or have no steps left.
template <PathKind kKind, bool kWide>
HWY_INLINE void march(PathLanes& lanes, ShadingQueue& seen, const PacketField& field, std::size_t enough,
                      RayCounters& counters) {
  const D32 d;
  const V zero = hn::Zero(d), one = set(1), block_mask = set((1 << field.block_shift) - 1);
  LaneState ray = begin<kWide>(lanes);
  constexpr std::size_t kWords = words_of(kKind);
  EnergyLanes energy{};
  for (std::size_t word = 0; word < kWords; ++word) {
    for (std::size_t i = 0; i < 2; ++i) energy[word][i] = lanes.energy[word][i].load();
  }
  V interacted = lanes.interacted.load(), begun = lanes.begun.load(), taken = lanes.taken.load();
  V trapped = lanes.trapped.load();
  const V more = lanes.more.load();
  const auto pace = pace_of<kWide>(ray);
  V passed = zero;
  Mask masked = hn::MaskFromVec(lanes.masked.load());
  while (true) {
    const Mask going = hn::AndNot(masked, hn::Gt(ray.left, zero));
    if (hn::Lanes(d) - hn::CountTrue(d, going) >= enough) break;
    constexpr int kCellShift = CellRanges::kEdgeShift + wire::kPositionFractionBits;
    const V cell = cube_index(ray, going, kCellShift, field.cells_across, field.cells_slice);
    const V first = gather(field.tables->first.data(), hn::ShiftLeft<2>(cell));
    const Mask skips = hn::And(going, hn::Lt(first, zero)), samples = hn::AndNot(skips, going);
    V steps = zero;
    Mask still_trapped = hn::FirstN(d, 0);
    if (!hn::AllFalse(d, skips)) {
      const Mask block_skips = hn::And(skips, hn::Eq(first, set(kSkipped)));
      const V mask = hn::IfThenElse(block_skips, block_mask, set((1 << kCellShift) - 1));
      const V most = hn::Add(ray.left, hn::IfThenElseZero(block_skips, more));
      const V out = hn::Min(steps_out<kWide>(ray, mask, pace, field), most);
      steps = hn::IfThenElseZero(skips, out);
      counters.leaps += hn::CountTrue(d, block_skips);
      passed = hn::Add(passed, hn::IfThenElseZero(hn::AndNot(block_skips, skips), out));
    }
    if (!hn::AllFalse(d, samples)) {
      const SampleLanes at = sample_at(ray, first, samples, field);
      const SampleResult sample =
          try_samples<kKind, kWide>(lanes, ray, begun, trapped, energy, interacted, at, samples, field);
      const Mask goes_on = sample.goes_on;
      masked = hn::Or(masked, hn::AndNot(hn::Or(goes_on, sample.waits), samples));
      counters.samples += hn::CountTrue(d, goes_on);
      counters.visible_samples += hn::CountTrue(d, hn::And(goes_on, sample.visible));
      for (std::size_t word = 0; word < kWords; ++word) {
        for (std::size_t i = 0; i < 2; ++i) {
          energy[word][i] = hn::IfThenElse(goes_on, sample.energy[word][i], energy[word][i]);
        }
      }
      interacted = hn::IfThenElse(goes_on, sample.interacted, interacted);
      steps = hn::Add(steps, hn::IfThenElseZero(goes_on, one));
      still_trapped = sample.trapped;
      if constexpr (kKind == PathKind::kRendering && !kWide) {
        gather_colour(seen, at, sample, ray, lanes, field);
        ray.opacity = hn::Add(ray.opacity, sample.weight);
        masked = hn::Or(masked, hn::And(goes_on, hn::Not(hn::Lt(ray.opacity, set(field.threshold)))));
      }
    }
    const Mask stepped = hn::Gt(steps, zero);
    begun = hn::Or(begun, hn::VecFromMask(d, stepped));
    trapped = hn::IfThenZeroElse(hn::AndNot(still_trapped, stepped), trapped);
    taken = hn::Add(taken, steps);
    ray.left = hn::Sub(ray.left, steps);
    advance<kWide>(ray, steps);
  }
  counters.samples += static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(d, passed)));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lanes.position[axis].store(ray.position[axis]);
    if constexpr (kWide) lanes.rest[axis].store(ray.rest[axis]);
  }
  for (std::size_t word = 0; word < kWords; ++word) {
    for (std::size_t i = 0; i < 2; ++i) lanes.energy[word][i].store(energy[word][i]);
  }
  lanes.interacted.store(interacted);
  lanes.opacity.store(ray.opacity);
  lanes.begun.store(begun);
  lanes.trapped.store(trapped);
  lanes.taken.store(taken);
  lanes.left.store(ray.left);
  lanes.masked.store(hn::VecFromMask(d, masked));
}
