// Where the integration interval of a lighting ray's sample begins and ends, and the depth of its medium
// (datapath/ray_interval.h). One source: it is included into the namespace of a ray alone, where a number is a `double`
// and a mask a `bool` (datapath/one_lane.h), and into that of each instruction set (functional/simd), where they are
// vectors. Doubles take the same operations in the same order everywhere, so that their bits are the same.

template <class Number>
[[gnu::always_inline]] inline Number lerp(Number a, Number b, Number weight) {
  return a + (b - a) * weight;
}

// The interval in which a ray is in a cell, in steps from its sample.
template <class Number>
struct Reach {
  Number entry, exit;
};

// `at`: a position in the cell that the ray reaches `steps` steps after the sample. `per_unit`: steps per position
// unit; 0: the ray does not move along this axis.
template <class Number>
[[gnu::always_inline]] inline Reach<Number> reach(const std::array<Number, 3>& at,
                                                  const std::array<Number, 3>& per_unit, double steps) {
  const Number zero = like(per_unit[0], 0), size = like(per_unit[0], wire::kVoxel), shift = like(per_unit[0], steps);
  constexpr double kNever = std::numeric_limits<double>::infinity();
  Reach<Number> out{like(per_unit[0], -kNever), like(per_unit[0], kNever)};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Number low = shift - at[axis] * per_unit[axis], high = (size - at[axis]) * per_unit[axis] + shift;
    const auto moves = per_unit[axis] != zero;
    out.entry = IfThenElse(moves, Max(out.entry, Min(low, high)), out.entry);
    out.exit = IfThenElse(moves, Min(out.exit, Max(low, high)), out.exit);
  }
  return out;
}

// The inputs of a sample's interval.
template <class Number, class Mask>
struct PathAround {
  std::array<Number, 3> here, before, after;  // positions in the cells of the sample, and of those before and after it
  std::array<Number, 3> ahead;                // to the volume's face, signed like the step
  std::array<Number, 3> per_unit;             // as for reach()
  Mask begins_here, ends_here;                // the sample before or after is in the same cell
  Mask first, last;                           // the sample is the first of its path segment, or the last in the volume
};

template <class Number>
struct Interval {
  Number begin, end;  // in steps from the sample
  Reach<Number> own;  // of the sample's cell
};

// An interval begins and ends half way between the cells of neighbouring samples, so that the intervals cover the ray
// once.
template <class Number, class Mask>
[[gnu::always_inline]] inline Interval<Number> interval_of(const PathAround<Number, Mask>& path) {
  const Number zero = like(path.here[0], 0), half = like(path.here[0], 0.5);
  Interval<Number> out{like(zero, -0.5), half, reach(path.here, path.per_unit, 0)};
  if (!all(path.begins_here)) {
    const Number exit = reach(path.before, path.per_unit, -1).exit;
    out.begin = IfThenElse(path.begins_here, out.begin, (Min(exit, out.own.entry) + out.own.entry) * half);
  }
  out.begin = IfThenElse(path.first, zero, out.begin);
  if (!all(path.ends_here)) {
    const Number entry = reach(path.after, path.per_unit, 1).entry;
    out.end = IfThenElse(path.ends_here, out.end, (out.own.exit + Max(out.own.exit, entry)) * half);
  }
  Number to_the_face = like(zero, 1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Number steps = path.ahead[axis] * path.per_unit[axis];
    to_the_face = IfThenElse(path.per_unit[axis] != zero, Min(to_the_face, steps), to_the_face);
  }
  out.end = IfThenElse(path.last, to_the_face, out.end);
  return out;
}

// The ray's position in the sample's cell, 0..1, `steps` from the sample at `fraction`; `slope`: position units per
// step.
template <class Number>
[[gnu::always_inline]] inline std::array<Number, 3> in_cell(const std::array<Number, 3>& fraction,
                                                            const std::array<Number, 3>& slope, Number steps) {
  const Number zero = like(steps, 0), one = like(steps, 1), size = like(steps, 1.0 / wire::kVoxel);
  std::array<Number, 3> out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out[axis] = Min(Max((fraction[axis] + steps * slope[axis]) * size, zero), one);
  }
  return out;
}

// The density at a position in a cell, 12 bits and a fraction. `corner`: densities of its voxels, x first.
template <class Number>
[[gnu::always_inline]] inline Number density_at(const std::array<Number, 8>& corner, const std::array<Number, 3>& at) {
  const Number near = lerp(lerp(corner[0], corner[1], at[0]), lerp(corner[2], corner[3], at[0]), at[1]);
  const Number far = lerp(lerp(corner[4], corner[5], at[0]), lerp(corner[6], corner[7], at[0]), at[1]);
  return lerp(near, far, at[2]) * like(near, 1.0 / (1 << kDensityFractionBits));
}

// A density among the entries of the segmentation LUT, which it rounds to. `sums`: DepthTable::sums().
template <class Number>
struct BinPosition {
  Number at, bin;       // entries, whole ones
  Number until, depth;  // sum of the depths before it; depth of its entry
};

template <class Number>
[[gnu::always_inline]] inline BinPosition<Number> bin_at(Number at, Number bin, const double* sums) {
  const Number below = look_up(sums, bin), above = look_up(sums + 1, bin);
  return {at, bin, lerp(below, above, at - bin), above - below};
}
// `first`: the first entry of its tag.
template <class Number>
[[gnu::always_inline]] inline BinPosition<Number> bin_position(Number first, Number density, const double* sums) {
  const Number at = Min(Max(density + like(density, 0.5), like(density, 0)), like(density, kTagEntries - 1e-9));
  return bin_at(first + at, first + Trunc(at), sums);
}

// On shorter paths, in entries, the mean depth is that of the entry: the quotient of two small differences would lose
// precision.
constexpr double kNoWay = 1e-6;

// Mean depth between two densities, per voxel length.
template <class Number>
[[gnu::always_inline]] inline Number mean_depth(const BinPosition<Number>& from, const BinPosition<Number>& to) {
  const Number way = to.at - from.at;
  return IfThenElse(Abs(way) < like(way, kNoWay), from.depth, (to.until - from.until) / way);
}
