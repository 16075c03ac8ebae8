// The integration interval of a lighting ray's sample, and its medium, for lanes of rays: datapath/interval-inl.h for
// vectors, and datapath/interaction.h's absorption and scattering. Intervals with an opaque entry or voxels of several
// tags are left to scalar code.

#include "functional/simd/lane_scheduler-inl.h"

using DI64 = hn::RebindToSigned<DU64>;
using MaskD = hn::Mask<DD>;

HWY_INLINE VD like(VD, double x) { return hn::Set(DD(), x); }
HWY_INLINE bool all(MaskD mask) { return hn::AllTrue(DD(), mask); }
HWY_INLINE VD look_up(const double* table, VD index) {
  return hn::GatherIndex(DD(), table, hn::ConvertTo(DI64(), index));
}
#include "datapath/interval-inl.h"

// A double per ray under way.
struct alignas(64) DoubleWord {
  std::array<double, 16> lane{};

  Doubles load() const { return {hn::Load(DD(), lane.data()), hn::Load(DD(), lane.data() + hn::Lanes(DD()))}; }
  // Stores the lanes of `which`.
  void store(const Doubles& v, const std::array<MaskD, 2>& which) {
    hn::BlendedStore(v.lower, which[0], DD(), lane.data());
    hn::BlendedStore(v.upper, which[1], DD(), lane.data() + hn::Lanes(DD()));
  }
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
    const V extent = set(field.frame->extent[axis]);
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
HWY_INLINE PathAround<VD, MaskD> path_around(const WayLanes& way, HalfOf half) {
  PathAround<VD, MaskD> out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.here[axis] = half(way.here[axis]);
    out.before[axis] = half(way.before[axis]);
    out.after[axis] = half(way.after[axis]);
    out.ahead[axis] = half(way.ahead[axis]);
    out.per_unit[axis] = half(way.inverse[axis]);
  }
  out.begins_here = half(way.begins_here);
  out.ends_here = half(way.ends_here);
  out.first = half(way.first);
  out.last = half(way.last);
  return out;
}

// The pieces of an interval whose density varies, as in RayInterval::of(), and its optical depth if no entry from
// `least` to `most` is opaque.
struct DepthLanes {
  std::array<VD, 5> ends;
  std::array<VD, 3> density;
  std::array<VD, 4> piece;  // depths
  VD depth, least, most;
};

// `tag`: of the samples, in the bits above those of a density.
template <class HalfOf>
HWY_INLINE DepthLanes depth_of_interval(const Interval<VD>& interval, const WayLanes& way, const Corners& corners,
                                        const std::array<V, 3>& fraction, V tag, V exponent, const LightField& light,
                                        HalfOf half) {
  const VD zero = hn::Zero(DD()), first = half(tag), lengths = hn::Mul(half(exponent), hn::Set(DD(), 1.0 / 65536));
  std::array<VD, 8> corner;
  for (std::size_t row = 0; row < 4; ++row) {
    corner[2 * row] = half(hn::And(corners.row[row], set(0xFFFF)));
    corner[2 * row + 1] = half(hn::ShiftRight<16>(corners.row[row]));
  }
  const std::array<VD, 3> at{half(fraction[0]), half(fraction[1]), half(fraction[2])},
      slope{half(way.slope[0]), half(way.slope[1]), half(way.slope[2])};
  DepthLanes out;
  const VD entry = hn::Max(interval.begin, interval.own.entry), exit = hn::Min(interval.end, interval.own.exit);
  const VD middle = hn::Min(hn::Max(zero, entry), exit);
  out.ends = {interval.begin, entry, middle, exit, interval.end};
  const auto bin = [&](std::size_t i) {
    out.density[i] = density_at(corner, in_cell(at, slope, out.ends[i + 1]));
    return bin_position(first, out.density[i], light.sums);
  };
  const BinPosition<VD> from = bin(0), here = bin(1), to = bin(2);
  const std::array<VD, 4> mean{from.depth, mean_depth(from, here), mean_depth(here, to), to.depth};
  out.depth = zero;
  for (std::size_t i = 0; i < mean.size(); ++i) {  // DepthTable::between()
    const VD steps = hn::Sub(out.ends[i + 1], out.ends[i]), depth = hn::Mul(hn::Mul(steps, lengths), mean[i]);
    out.piece[i] = hn::IfThenElseZero(hn::Gt(steps, zero), depth);
    out.depth = hn::Add(out.depth, out.piece[i]);
  }
  out.least = hn::Min(hn::Min(from.bin, here.bin), to.bin);
  out.most = hn::Max(hn::Max(from.bin, here.bin), to.bin);
  return out;
}

// The intervals of samples that lanes have computed (KnownInterval), by lane.
struct KnownLanes {
  Word found;  // all ones: one medium that is nowhere opaque; of other intervals nothing is computed
  Word entry, opacity, even;
  std::array<DoubleWord, 5> ends;
  std::array<DoubleWord, 3> density;
  std::array<DoubleWord, 4> depth;

  HWY_INLINE void put_ends(std::size_t i, const Doubles& v, Mask which) {
    ends[i].store(v, {LowerLanes()(which), UpperLanes()(which)});
  }
  HWY_INLINE void put_pieces(const DepthLanes& below, const DepthLanes& above, Mask which) {
    const std::array<MaskD, 2> both{LowerLanes()(which), UpperLanes()(which)};
    for (std::size_t i = 1; i < 4; ++i) ends[i].store({below.ends[i], above.ends[i]}, both);
    for (std::size_t i = 0; i < 3; ++i) density[i].store({below.density[i], above.density[i]}, both);
    for (std::size_t i = 0; i < 4; ++i) depth[i].store({below.piece[i], above.piece[i]}, both);
  }
  HWY_INLINE void put(V its_entry, V its_opacity, Mask is_even, Mask is_found, Mask which) {
    const auto store = [which](V v, Word& word) { hn::BlendedStore(v, which, D32(), word.lane.data()); };
    store(its_entry, entry);
    store(its_opacity, opacity);
    store(hn::VecFromMask(D32(), is_even), even);
    store(hn::VecFromMask(D32(), is_found), found);
  }

  KnownInterval of_lane(std::size_t lane) const {
    KnownInterval out{.entry = static_cast<std::size_t>(entry.lane[lane]),
                      .opacity = static_cast<std::uint32_t>(opacity.lane[lane]),
                      .even = even.lane[lane] != 0};
    for (std::size_t i = 0; i < 5; ++i) out.ends[i] = ends[i].lane[lane];
    for (std::size_t i = 0; i < 3; ++i) out.density[i] = density[i].lane[lane];
    for (std::size_t i = 0; i < 4; ++i) out.depth[i] = depth[i].lane[lane];
    return out;
  }
};

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
