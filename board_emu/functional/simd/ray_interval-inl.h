// The integration interval of a lighting ray's sample, and its medium, for lanes of rays, as in datapath/ray_interval.h and
// datapath/interaction.h, except intervals with an opaque entry or voxels of several tags. Doubles take the same operations in
// the same order, so that their bits are the same; a quotient by a power of two is a product.

// Included once for each instruction set.
#if defined(GICUBE_RAY_INTERVAL) == defined(HWY_TARGET_TOGGLE)
#ifdef GICUBE_RAY_INTERVAL
#undef GICUBE_RAY_INTERVAL
#else
#define GICUBE_RAY_INTERVAL
#endif

#include <limits>

#include "march-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR

using DI64 = hn::RebindToSigned<DU64>;
using MaskD = hn::Mask<DD>;

// A double per ray under way.
struct alignas(64) DoubleWord {
  std::array<double, 16> lane{};

  Doubles load() const { return {hn::Load(DD(), lane.data()), hn::Load(DD(), lane.data() + hn::Lanes(DD()))}; }
};

// Converts the lower or the upper lanes to doubles.
template <bool kUpper>
struct HalfLanes {
  static HWY_INLINE auto part(V v) {
    if constexpr (kUpper) {
      return hn::UpperHalf(DHalf(), v);
    } else {
      return hn::LowerHalf(DHalf(), v);
    }
  }
  HWY_INLINE VD operator()(V v) const { return hn::PromoteTo(DD(), part(v)); }
  HWY_INLINE VD operator()(const Doubles& v) const { return kUpper ? v.upper : v.lower; }
  HWY_INLINE MaskD operator()(Mask m) const {
    return hn::RebindMask(DD(), hn::MaskFromVec(hn::PromoteTo(DI64(), part(hn::VecFromMask(D32(), m)))));
  }
};
using LowerLanes = HalfLanes<false>;
using UpperLanes = HalfLanes<true>;

// Calls `make` for the lower and for the upper lanes, and joins the results.
template <class Make>
HWY_INLINE Doubles in_doubles(const Make& make) {
  return {make(LowerLanes()), make(UpperLanes())};
}
// lround() of non-negative numbers that fit.
HWY_INLINE V rounded(const Doubles& x) {
  const auto half = [](VD of) {
    const VD whole = hn::Trunc(of);
    const MaskD up = hn::Ge(hn::Sub(of, whole), hn::Set(DD(), 0.5));
    return hn::DemoteTo(DHalf(), hn::IfThenElse(up, hn::Add(whole, hn::Set(DD(), 1)), whole));
  };
  return hn::Combine(D32(), half(x.upper), half(x.lower));
}
HWY_INLINE V truncated(const Doubles& x) {
  return hn::Combine(D32(), hn::DemoteTo(DHalf(), x.upper), hn::DemoteTo(DHalf(), x.lower));
}

// has_one_tag() for samples whose voxels begin at `index`.
HWY_INLINE Mask has_one_tag(V index, const PacketField& field) {
  if (!field.tagged) return hn::Eq(index, index);
  const Corners codes = corners_of(field.codes, index, field.edge);
  const auto& row = codes.row;
  const V rows = hn::Or(hn::Xor(row[0], row[1]), hn::Or(hn::Xor(row[0], row[2]), hn::Xor(row[0], row[3])));
  const V pair = hn::Xor(row[0], hn::ShiftRight<16>(row[0]));
  const auto differ = [](V codes_of, std::uint32_t which) {
    return hn::And(codes_of, set(static_cast<std::int32_t>(((wire::kTags - 1) << kCodeBits) * which)));
  };
  return hn::Eq(hn::Or(differ(rows, 0x1'0001), differ(pair, 1)), hn::Zero(D32()));
}

// DepthTable::uniform() for the densities around samples with entry `entry` of the segmentation LUT.
HWY_INLINE Mask is_even(const Corners& corners, V entry, const LightField& light) {
  const D16 d;
  const auto of = [&](std::size_t i) { return hn::BitCast(d, corners.row[i]); };
  const V16 low = hn::Min(hn::Min(of(0), of(1)), hn::Min(of(2), of(3)));
  const V16 high = hn::Max(hn::Max(of(0), of(1)), hn::Max(of(2), of(3)));
  const auto other = [&](V16 v) { return hn::BitCast(d, hn::ShiftRight<16>(hn::BitCast(D32(), v))); };
  const auto run = [&](V16 density) {
    constexpr int kHalf = 1 << (kDensityFractionBits - 1);
    const V word = hn::And(hn::BitCast(D32(), density), set(0xFFFF));
    const V in_tag = hn::ShiftRight<kDensityFractionBits>(hn::Add(word, set(kHalf)));
    return gather(light.runs, hn::ShiftLeft<2>(hn::Or(in_tag, hn::And(entry, set(~0xFFF)))));
  };
  return hn::Eq(run(hn::Min(low, other(low))), run(hn::Max(high, other(high))));
}

struct MaterialLanes {
  Mask traps;
  Mask reflects;
  Mask straight;  // scatters nothing
  V kept;         // units of wire::kScatteringOne that are not scattered
  Doubles scattering;
};

HWY_INLINE MaterialLanes material_of(V tag, const LightField& light) {
  const V kind = gather(light.kind.data(), hn::ShiftLeft<2>(tag));
  const auto is = [&](std::int32_t what) { return hn::Eq(kind, set(what)); };
  return {is(LightField::kTrap), is(LightField::kSurface), is(LightField::kStraight),
          gather(light.kept.data(), hn::ShiftLeft<2>(tag)), in_doubles([&](auto half) {
            return hn::GatherIndex(DD(), light.scattering.data(), hn::PromoteTo(DI64(), half.part(tag)));
          })};
}

// absorption_opacity().
HWY_INLINE V absorption_opacity(V a, const MaterialLanes& material) {
  static_assert(wire::kScatteringOne == 0xFFFF);
  const auto half = [](VU64 of, VU64 kept) {  // divided as in energy_after()
    const VU64 x = hn::Add(product(of, kept), set64(wire::kScatteringOne / 2));
    const VU64 rounds = hn::ShiftRight<16>(x), rest = hn::Add(rounds, hn::And(x, set64(0xFFFF)));
    return hn::Add(rounds, hn::ShiftRight<16>(hn::Add(hn::Add(rest, hn::ShiftRight<16>(rest)), set64(1))));
  };
  return together(half(evens(a), evens(material.kept)), half(odds(a), odds(material.kept)));
}

// scattering_opacity().
HWY_INLINE V scattering_opacity(V a, const MaterialLanes& material) {
  const V one = set(static_cast<std::int32_t>(wire::kOpacityOne));
  const V part = rounded(in_doubles([&](auto half) {
    const VD unit = hn::Set(DD(), 1), ks = half(material.scattering);
    const VD alpha = hn::Div(half(a), hn::Set(DD(), wire::kOpacityOne));
    // At least 2^-24, or 0 if an opaque sample scatters nothing: the maximum avoids 0 / 0, which has no integer value.
    const VD under = hn::Max(hn::Sub(unit, hn::Mul(hn::Sub(unit, ks), alpha)), hn::Set(DD(), 0x1p-60));
    return hn::Mul(hn::Div(hn::Mul(ks, alpha), under), hn::Set(DD(), wire::kOpacityOne));
  }));
  const V scatters = truncated(in_doubles([&](auto half) {  // for opaque samples
    const VD ks = half(material.scattering);
    return hn::IfThenElseZero(hn::Gt(ks, hn::Zero(DD())), hn::Set(DD(), wire::kOpacityOne));
  }));
  return hn::IfThenElse(hn::Eq(a, one), scatters, part);
}

// The interval in which a ray is in a cell, in steps from its sample.
struct ReachLanes {
  VD entry, exit;
};

// Intervals of half of the lanes, as in RayInterval::of().
struct IntervalLanes {
  VD begin, end;  // ends of the sample's interval
  ReachLanes own;
};

// Data that determine a sample's interval: positions of the samples before and after it.
struct WayLanes {
  std::array<V, 3> here, before, after;  // in the cells of the sample, and of those before and after it
  std::array<V, 3> ahead;                // to the volume's face, signed like the step
  Mask begins_here, ends_here;           // the sample before or after is in the same cell
  Mask first, last;                      // the sample is the first of its path segment, or the last in the volume
  std::array<Doubles, 3> slope, inverse;
};

// `begun`: all ones unless the sample is the first of its path segment.
template <bool kWide>
HWY_INLINE WayLanes way_of(const LaneState& ray, const std::array<Doubles, 3>& slope,
                           const std::array<Doubles, 3>& inverse, V begun, const PacketField& field) {
  WayLanes out;
  out.slope = slope;
  out.inverse = inverse;
  const V low_bits = set(wire::kVoxel - 1);
  V left_cell = hn::Zero(D32()), right_cell = left_cell, outside = left_cell;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    V previous = hn::Sub(ray.position[axis], ray.step[axis]), next = hn::Add(ray.position[axis], ray.step[axis]);
    if constexpr (kWide) {
      const V back = hn::Sub(ray.rest[axis], ray.step_rest[axis]), on = hn::Add(ray.rest[axis], ray.step_rest[axis]);
      previous = hn::Add(previous, hn::ShiftRight<kRestBits>(back));
      next = hn::Add(next, hn::ShiftRight<kRestBits>(on));
    }
    const V extent = set(field.extent[axis]);
    outside = hn::Or(outside, hn::Or(next, hn::Sub(extent, next)));  // negative: outside
    const Mask backward = hn::Lt(ray.step[axis], hn::Zero(D32()));   // a step's rest is not negative
    out.ahead[axis] = hn::Sub(hn::IfThenZeroElse(backward, extent), ray.position[axis]);
    left_cell = hn::Or(left_cell, hn::Xor(previous, ray.position[axis]));
    right_cell = hn::Or(right_cell, hn::Xor(next, ray.position[axis]));
    out.here[axis] = hn::And(ray.position[axis], low_bits);
    out.before[axis] = hn::And(previous, low_bits);
    out.after[axis] = hn::And(next, low_bits);
  }
  const auto same_cell = [&](V difference) { return hn::Eq(hn::And(difference, set(-wire::kVoxel)), hn::Zero(D32())); };
  out.begins_here = same_cell(left_cell);
  out.ends_here = same_cell(right_cell);
  out.first = hn::Eq(begun, hn::Zero(D32()));
  out.last = hn::Lt(outside, hn::Zero(D32()));
  return out;
}

template <class HalfOf>
HWY_INLINE IntervalLanes interval_of_way(const WayLanes& way, HalfOf half) {
  const DD d;
  const VD size = hn::Set(d, wire::kVoxel);
  const auto reach = [&](const std::array<V, 3>& at, double steps) {
    ReachLanes out{hn::Set(d, -std::numeric_limits<double>::infinity()),
                   hn::Set(d, std::numeric_limits<double>::infinity())};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const VD a = half(at[axis]), per_unit = half(way.inverse[axis]);
      const VD low = hn::Add(hn::Mul(hn::Neg(a), per_unit), hn::Set(d, steps));
      const VD high = hn::Add(hn::Mul(hn::Sub(size, a), per_unit), hn::Set(d, steps));
      const MaskD moves = hn::Ne(per_unit, hn::Zero(d));
      out.entry = hn::IfThenElse(moves, hn::Max(out.entry, hn::Min(low, high)), out.entry);
      out.exit = hn::IfThenElse(moves, hn::Min(out.exit, hn::Max(low, high)), out.exit);
    }
    return out;
  };
  const VD a_half = hn::Set(d, 0.5);
  IntervalLanes out;
  out.own = reach(way.here, 0);
  const VD last_exit = reach(way.before, -1).exit, next_entry = reach(way.after, 1).entry;
  const VD begin = hn::Mul(hn::Add(hn::Min(last_exit, out.own.entry), out.own.entry), a_half);
  const VD end = hn::Mul(hn::Add(out.own.exit, hn::Max(out.own.exit, next_entry)), a_half);
  out.begin = hn::IfThenZeroElse(half(way.first), hn::IfThenElse(half(way.begins_here), hn::Set(d, -0.5), begin));
  out.end = hn::IfThenElse(half(way.ends_here), hn::Set(d, 0.5), end);
  VD to_the_face = hn::Set(d, 1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const VD per_unit = half(way.inverse[axis]), steps = hn::Mul(half(way.ahead[axis]), per_unit);
    to_the_face = hn::IfThenElse(hn::Ne(per_unit, hn::Zero(d)), hn::Min(to_the_face, steps), to_the_face);
  }
  out.end = hn::IfThenElse(half(way.last), to_the_face, out.end);
  return out;
}

// Optical depth of an interval with varying density, as in RayInterval::of(), if no entry from `least` to `most` is opaque.
struct DepthLanes {
  VD depth, least, most;
};

// `tag`: of the samples, in the bits above those of a density.
template <class HalfOf>
HWY_INLINE DepthLanes depth_of_interval(const IntervalLanes& interval, const WayLanes& way, const Corners& corners,
                                        const std::array<V, 3>& fraction, V tag, V exponent, const LightField& light,
                                        HalfOf half) {
  const DD d;
  const VD zero = hn::Zero(d), one = hn::Set(d, 1);
  const auto lerp = [](VD a, VD b, VD w) { return hn::Add(a, hn::Mul(hn::Sub(b, a), w)); };
  const auto density = [&](VD steps) {  // density_at()
    std::array<VD, 3> w;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const VD at = hn::Add(half(fraction[axis]), hn::Mul(steps, half(way.slope[axis])));
      w[axis] = hn::Min(hn::Max(hn::Mul(at, hn::Set(d, 1.0 / wire::kVoxel)), zero), one);
    }
    const auto along_x = [&](std::size_t row) {
      const V pair = corners.row[row];
      return lerp(half(hn::And(pair, set(0xFFFF))), half(hn::ShiftRight<16>(pair)), w[0]);
    };
    const VD near = lerp(along_x(0), along_x(1), w[1]), far = lerp(along_x(2), along_x(3), w[1]);
    return hn::Mul(lerp(near, far, w[2]), hn::Set(d, 1.0 / (1 << kDensityFractionBits)));
  };
  constexpr double kDensities = wire::kSegmentationEntries / wire::kTags;
  struct BinPositionLanes {
    VD at, bin, until, slope;  // DepthTable::BinPosition, until(), and the depth of its entry
  };
  const VD first = half(tag);
  const auto place = [&](VD of) {
    const VD at = hn::Min(hn::Max(hn::Add(of, hn::Set(d, 0.5)), zero), hn::Set(d, kDensities - 1e-9));
    const VD bin = hn::Add(first, hn::Trunc(at)), sum = hn::Add(first, at);
    const auto index = hn::ConvertTo(DI64(), bin);
    const VD below = hn::GatherIndex(d, light.sums, index), above = hn::GatherIndex(d, light.sums + 1, index);
    return BinPositionLanes{sum, bin, lerp(below, above, hn::Sub(sum, bin)), hn::Sub(above, below)};
  };
  const VD entry = hn::Max(interval.begin, interval.own.entry), exit = hn::Min(interval.end, interval.own.exit);
  const VD middle = hn::Min(hn::Max(zero, entry), exit);
  const BinPositionLanes from = place(density(entry)), here = place(density(middle)), to = place(density(exit));
  const VD lengths = hn::Mul(half(exponent), hn::Set(d, 1.0 / 65536));
  VD depth = zero;
  const auto add = [&](VD begin, VD end, VD mean) {  // DepthTable::between()
    const VD steps = hn::Sub(end, begin), more = hn::Mul(hn::Mul(steps, lengths), mean);
    depth = hn::Add(depth, hn::IfThenElseZero(hn::Gt(steps, zero), more));
  };
  const auto mean = [&](const BinPositionLanes& a, const BinPositionLanes& b) {
    const VD passed = hn::Sub(b.at, a.at);
    const MaskD stays = hn::Lt(hn::Abs(passed), hn::Set(d, kNoWay));
    return hn::IfThenElse(stays, a.slope, hn::Div(hn::Sub(b.until, a.until), passed));
  };
  add(interval.begin, entry, from.slope);
  add(entry, middle, mean(from, here));
  add(middle, exit, mean(here, to));
  add(exit, interval.end, to.slope);
  return DepthLanes{depth, hn::Min(hn::Min(from.bin, here.bin), to.bin), hn::Max(hn::Max(from.bin, here.bin), to.bin)};
}

struct Exponent {
  V word;
  Mask valid;  // the exponent fits its word
};

// The exponent of an interval in a medium of one opacity.
HWY_INLINE Exponent exponent_of(const Doubles& begin, const Doubles& end, V exponent) {
  const Doubles product =
      in_doubles([&](auto half) { return hn::Mul(half(exponent), hn::Sub(half(end), half(begin))); });
  const auto in_range = [](VD x) {
    return hn::IfThenElseZero(hn::And(hn::Ge(x, hn::Zero(DD())), hn::Lt(x, hn::Set(DD(), 0x1p30))), hn::Set(DD(), -1));
  };
  const Mask fits = hn::Ne(truncated({in_range(product.lower), in_range(product.upper)}), hn::Zero(D32()));
  return {hn::IfThenElseZero(fits, rounded(product)), fits};
}

// Opacities of optical depths, for the lanes of `which`.
HWY_INLINE V opacity_of(const Doubles& depth, Mask which) {
  DoubleWord depths;
  Word opacity, wanted;
  hn::Store(depth.lower, DD(), depths.lane.data());
  hn::Store(depth.upper, DD(), depths.lane.data() + hn::Lanes(DD()));
  wanted.store(hn::VecFromMask(D32(), which));
  for (std::size_t i = 0; i < hn::Lanes(D32()); ++i) {
    if (wanted.lane[i] != 0) opacity.lane[i] = static_cast<std::int32_t>(opacity_of_depth(depths.lane[i]));
  }
  return opacity.load();
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
