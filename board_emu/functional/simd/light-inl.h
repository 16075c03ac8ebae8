// Stages for lanes of rays of frames that are jittered, lit by irradiance, or on the wide datapath.

#include "functional/simd/gradient-inl.h"

// a * b modulo 2^64.
HWY_INLINE VU64 times(VU64 a, std::uint64_t b) {
  const VU64 low = set64(b & 0xFFFF'FFFF), high = set64(b >> 32);
  const VU64 cross = hn::Add(product(hn::ShiftRight<32>(a), low), product(a, high));
  return hn::Add(product(a, low), hn::ShiftLeft<32>(cross));
}

// wire::mix64().
HWY_INLINE VU64 mix64(VU64 x) {
  x = times(hn::Xor(x, hn::ShiftRight<30>(x)), 0xBF58476D1CE4E5B9u);
  x = times(hn::Xor(x, hn::ShiftRight<27>(x)), 0x94D049BB133111EBu);
  return hn::Xor(x, hn::ShiftRight<31>(x));
}

// Index of the jitter LUT's entry for the ray at `position`; `destination`: v << 16 | u.
HWY_INLINE V jitter_index(const std::array<V, 3>& position, V destination) {
  const auto half = [](VU64 x, VU64 y, VU64 z, VU64 uv) {
    const VU64 low = hn::Or(x, hn::ShiftLeft<24>(y)), high = hn::Or(z, hn::ShiftLeft<24>(uv));
    return hn::And(mix64(hn::Xor(mix64(low), high)), set64(kJitterEntries - 1));
  };
  return together(half(evens(position[0]), evens(position[1]), evens(position[2]), evens(destination)),
                  half(odds(position[0]), odds(position[1]), odds(position[2]), odds(destination)));
}

// step_vector() along one axis: direction * distance has more than 32 bits, its products with the distance's halves do
// not.
HWY_INLINE V step_of(V direction, V distance) {
  const V low = hn::Mul(direction, hn::And(distance, set(0xFFFF)));
  return hn::Add(hn::Mul(direction, hn::ShiftRight<16>(distance)), hn::ShiftRight<16>(hn::Add(low, set(1 << 15))));
}

// fine_step_vector() along one axis: whole units, and the bits below.
struct FineStep {
  V whole, rest;
};
HWY_INLINE FineStep fine_step_of(V direction, V distance) {
  const V low = hn::Mul(direction, hn::And(distance, set(0xFFFF)));
  return {hn::Add(hn::Mul(direction, hn::ShiftRight<16>(distance)), hn::ShiftRight<kRestBits>(low)),
          hn::And(low, set((1 << kRestBits) - 1))};
}

// InverseStep for fine steps: in doubles, for the lower and the upper lanes.
using DD = hn::Repartition<double, D32>;
using VD = hn::Vec<DD>;
using DHalf = hn::Half<D32>;
struct Doubles {
  VD lower, upper;
};
struct FineInverseStep {
  std::array<V, 3> turned;
  std::array<Doubles, 3> per_unit;
};

HWY_INLINE Doubles doubles(V whole, V rest) {
  const DD d;
  const VD unit = hn::Set(d, double{1 << kRestBits});
  const auto sum = [&](auto high, auto low) {
    return hn::Add(hn::Mul(hn::PromoteTo(d, high), unit), hn::PromoteTo(d, low));
  };
  return {sum(hn::LowerHalf(DHalf(), whole), hn::LowerHalf(DHalf(), rest)),
          sum(hn::UpperHalf(DHalf(), whole), hn::UpperHalf(DHalf(), rest))};
}

HWY_INLINE FineInverseStep pace_of(const std::array<V, 3>& step, const std::array<V, 3>& rest) {
  const DD d;
  FineInverseStep out{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Doubles way = doubles(step[axis], rest[axis]);
    const auto inverse = [&](VD of) {
      return hn::IfThenElse(hn::Eq(of, hn::Zero(d)), hn::Set(d, 0x1p40), hn::Div(hn::Set(d, 1), hn::Abs(of)));
    };
    out.turned[axis] = hn::VecFromMask(D32(), hn::Gt(step[axis], set(-1)));
    out.per_unit[axis] = {inverse(way.lower), inverse(way.upper)};
  }
  return out;
}

// steps_out() for fine steps: dividends have 36 bits and quotients 13, so that doubles are exact in the same way.
HWY_INLINE V steps_out(const std::array<V, 3>& position, const std::array<V, 3>& rest, V mask,
                       const FineInverseStep& pace, std::int32_t most) {
  const DD d;
  Doubles least{hn::Set(d, double(most - 1)), hn::Set(d, double(most - 1))};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Doubles ahead = doubles(hn::And(hn::Xor(position[axis], pace.turned[axis]), mask),
                                  hn::And(hn::Xor(rest[axis], pace.turned[axis]), set((1 << kRestBits) - 1)));
    const VD half = hn::Set(d, 0.5);
    least.lower = hn::Min(least.lower, hn::Mul(hn::Add(ahead.lower, half), pace.per_unit[axis].lower));
    least.upper = hn::Min(least.upper, hn::Mul(hn::Add(ahead.upper, half), pace.per_unit[axis].upper));
  }
  const V whole = hn::Combine(D32(), hn::DemoteTo(DHalf(), least.upper), hn::DemoteTo(DHalf(), least.lower));
  return hn::Add(whole, set(1));
}

// The exponent as in space().
HWY_INLINE V exponent_of(V distance, V length) {
  const auto half = [](VU64 a, VU64 b) { return hn::ShiftRight<16>(hn::Add(product(a, b), set64(1u << 15))); };
  return together(half(evens(distance), evens(length)), half(odds(distance), odds(length)));
}

// wide_alpha().
HWY_INLINE VF wide_alpha(VF depth, V exponent) {
  const DF d;
  const VF lengths = hn::Mul(hn::ConvertTo(d, exponent), hn::Set(d, 0x1p-16f));
  const VF x = hn::Min(hn::Mul(depth, lengths), hn::Set(d, kMaxDepth));
  const V whole = hn::ConvertTo(D32(), x);
  const VF rest = hn::Sub(x, hn::ConvertTo(d, whole));
  const VF left = hn::BitCast(d, hn::ShiftLeft<23>(hn::Sub(set(127), whole)));
  VF fall = hn::Set(d, kFall.back());
  for (std::size_t i = kFall.size() - 1; i-- > 0;) fall = hn::Add(hn::Mul(fall, rest), hn::Set(d, kFall[i]));
  const VF alpha = hn::Add(hn::Sub(hn::Set(d, 1), left), hn::Mul(left, hn::Mul(fall, rest)));
  return hn::IfThenElse(hn::Ge(depth, hn::Set(d, kOpaqueDepth)), hn::Set(d, 1), alpha);
}

// wide_alpha() for an entry's word in PacketField::opacities.
HWY_INLINE VF wide_alpha(V word, V exponent, const PacketField& field) {
  if (field.corrected) return hn::BitCast(DF(), hn::Max(hn::Sub(word, set(1)), hn::Zero(D32())));
  return wide_alpha(hn::BitCast(DF(), word), exponent);
}

// Index of the irradiance of samples in `block` at its cell `cell`; negative: there is none.
HWY_INLINE V irradiance_index(V block, V cell, const PacketField& field) {
  const V first = gather(field.irradiance_first, hn::ShiftLeft<2>(block));
  return hn::IfThenElse(hn::Lt(first, hn::Zero(D32())), first, hn::Add(first, cell));
}

// irradiance() for one irradiance word, 11.4.
HWY_INLINE V irradiance(const PackedPosition& at, V index, std::size_t word, const PacketField& field) {
  const Mask has = hn::Gt(index, set(-1));
  const std::array<V, 3> weight{at.x_and_y, hn::ShiftRight<16>(at.x_and_y), at.z};
  return hn::IfThenElseZero(has, resample_words(corners_of(field.irradiance + word * field.irradiance_plane,
                                                           hn::IfThenElseZero(has, index), field.edge),
                                                weight));
}

// The diffuse part of illuminated(): irradiance * gain * exposure, 15 fraction bits, at most 8.
HWY_INLINE V lit(V light, V gain, const PacketField& field) {
  constexpr int kTooMany = kIrradianceFractionBits + wire::kGainFractionBits + 16 - kShadeFractionBits;
  const V gained = hn::Mul(light, gain);  // 15 and 16 bits
  const auto half = [&](VU64 v) {
    const VU64 t = hn::Add(product(v, set64(field.frame->exposure)), set64(std::uint64_t{1} << (kTooMany - 1)));
    return hn::Min(hn::ShiftRight<kTooMany>(t), set64(std::uint64_t{8} << kShadeFractionBits));
  };
  return together(half(evens(gained)), half(odds(gained)));
}

// illuminated() for the irradiance at `irradiance_at`.
HWY_INLINE std::array<V, 3> illuminated(const ShadingEntry<V>& shading, V entry, const PackedPosition& at,
                                        V irradiance_at, const PacketField& field) {
  const V gain = hn::Or(shading.reflect, hn::ShiftLeft<8>(shading.knee)), zero = hn::Zero(D32());
  std::array<V, 3> diffuse;
  for (std::size_t c = 0; c < 3; ++c) {
    const bool own = c == 0 || field.irradiance_plane > 0;
    diffuse[c] = own ? lit(irradiance(at, irradiance_at, c, field), gain, field) : diffuse[0];
  }
  V specular = zero;
  std::array<V, 3> gradient{zero, zero, zero};
  if (field.specular != nullptr) {
    specular = hn::And(gather(field.specular, entry), set(0xFF));
    if (!hn::AllTrue(D32(), hn::Eq(specular, zero))) gradient = resample_gradient(at, field);
  }
  return illuminated(shading, specular, diffuse, gradient, SquareOf{*field.tables});
}
