// The pipeline's stages for lanes of rays. Each names the scalar stage that it repeats; the bits are the same.
//
// The files *-inl.h of this folder form one source, in which each begins with the file before it. simd_tracer.cpp and
// paths.cpp include it once for each instruction set, into the namespace of that set.
//
// Words of 32 bits are in 16 lanes. Products of more than 32 bits are computed in 64-bit lanes, once for the even and
// once for the odd ones.

namespace hn = hwy::HWY_NAMESPACE;

using D32 = hn::CappedTag<std::int32_t, 16>;
using DU32 = hn::RebindToUnsigned<D32>;
using DU64 = hn::Repartition<std::uint64_t, D32>;
using D16 = hn::Repartition<std::int16_t, D32>;
using DF = hn::RebindToFloat<D32>;
using V = hn::Vec<D32>;
using VF = hn::Vec<DF>;
using VU = hn::Vec<DU32>;
using VU64 = hn::Vec<DU64>;
using V16 = hn::Vec<D16>;
using Mask = hn::Mask<D32>;

HWY_INLINE V set(std::int32_t x) { return hn::Set(D32(), x); }
HWY_INLINE VU64 set64(std::uint64_t x) { return hn::Set(DU64(), x); }

template <class Vector>
HWY_INLINE VU64 evens(Vector v) {
  return hn::And(hn::BitCast(DU64(), v), set64(0xFFFF'FFFF));
}
template <class Vector>
HWY_INLINE VU64 odds(Vector v) {
  return hn::ShiftRight<32>(hn::BitCast(DU64(), v));
}
// Joins the low halves of both.
HWY_INLINE V together(VU64 even, VU64 odd) {
  return hn::BitCast(D32(), hn::Or(hn::And(even, set64(0xFFFF'FFFF)), hn::ShiftLeft<32>(odd)));
}
HWY_INLINE VU64 product(VU64 a, VU64 b) { return hn::MulEven(hn::BitCast(DU32(), a), hn::BitCast(DU32(), b)); }

#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX2
// Lane by lane: the gather instruction takes twice as long on AMD's cores, and on Intel's cores with mitigating
// microcode.
HWY_INLINE __m256i gather_eight(const char* base, const std::uint64_t* offsets) {  // two offsets in each of four words
  const auto word = [base](std::uint64_t offset) {
    std::int32_t at;
    std::memcpy(&at, base + static_cast<std::uint32_t>(offset), sizeof at);
    return at;
  };
  const auto four = [&](std::uint64_t a, std::uint64_t b) {
    const __m128i two = _mm_insert_epi32(_mm_cvtsi32_si128(word(a)), word(a >> 32), 1);
    return _mm_insert_epi32(_mm_insert_epi32(two, word(b), 2), word(b >> 32), 3);
  };
  return _mm256_inserti128_si256(_mm256_castsi128_si256(four(offsets[0], offsets[1])), four(offsets[2], offsets[3]), 1);
}
HWY_INLINE V gather(const void* base, V byte_offsets) {
  const auto* const bytes = static_cast<const char*>(base);
  alignas(64) std::array<std::uint64_t, hn::MaxLanes(DU64())> at;
  hn::Store(hn::BitCast(DU64(), byte_offsets), DU64(), at.data());
#if HWY_TARGET == HWY_AVX3
  const __m256i lower = gather_eight(bytes, at.data()), upper = gather_eight(bytes, at.data() + 4);
  return V{_mm512_inserti64x4(_mm512_castsi256_si512(lower), upper, 1)};
#else
  return V{gather_eight(bytes, at.data())};
#endif
}
#else
HWY_INLINE V gather(const void* base, V byte_offsets) {
  return hn::GatherOffset(D32(), static_cast<const std::int32_t*>(base), byte_offsets);
}
#endif
HWY_INLINE VU64 gather64(const void* base, VU64 index) {
  return hn::GatherIndex(DU64(), static_cast<const std::uint64_t*>(base),
                         hn::BitCast(hn::RebindToSigned<DU64>(), index));
}

// lerp() of datapath/resample.h on 16-bit lanes; `weight` 0.15.
HWY_INLINE V16 lerp16(V16 a, V16 b, V16 weight) { return hn::Add(a, hn::MulFixedPoint15(hn::Sub(b, a), weight)); }

// lerp() on the low halves of 32-bit lanes; the high halves are ignored.
HWY_INLINE V lerp(V a, V b, V weight) {
  const D16 d;
  return hn::BitCast(D32(), lerp16(hn::BitCast(d, a), hn::BitCast(d, b), hn::BitCast(d, weight)));
}
// Interpolates two neighbours along x in one word.
HWY_INLINE V along_x(V pair, V weight) {
  return lerp(pair, hn::BitCast(D32(), hn::ShiftRight<16>(hn::BitCast(DU32(), pair))), weight);
}

// A sample's position: the index of its cell among the decoded voxels, fractions of 14 and weights of 15 bits.
struct SamplePosition {
  V index;
  std::array<V, 3> fraction, weight;
};

// A compact position, for resampling later: weights of x and y in a word's halves, and of z.
struct PackedPosition {
  V index, x_and_y, z;
};

HWY_INLINE PackedPosition small(const SamplePosition& at) {
  return {at.index, hn::Or(at.weight[0], hn::ShiftLeft<16>(at.weight[1])), at.weight[2]};
}

// The eight words around a sample, of 16 bits, two neighbours along x in one.
struct Corners {
  std::array<V, 4> row;
};

template <class Word>
HWY_INLINE Corners corners_of(const Word* words, V index, std::int32_t edge) {
  const V two = hn::ShiftLeft<1>(index);
  const std::ptrdiff_t down = edge, deep = std::ptrdiff_t{edge} * edge;
  return {{gather(words, two), gather(words + down, two), gather(words + deep, two), gather(words + deep + down, two)}};
}

// resample_words() of densities, 12.3, or irradiance.
HWY_INLINE V resample_words(const Corners& corners, const std::array<V, 3>& weight) {
  const auto row = [&](std::size_t i) { return along_x(corners.row[i], weight[0]); };
  const V near = lerp(row(0), row(1), weight[1]), far = lerp(row(2), row(3), weight[1]);
  return hn::And(lerp(near, far, weight[2]), set(0xFFFF));
}

// segmentation_index(), with the tag of the nearest voxel.
HWY_INLINE V classify(V density, const SamplePosition& at, const PacketField& field) {
  constexpr int kHalf = 1 << (kDensityFractionBits - 1);
  const V entry = hn::ShiftRight<kDensityFractionBits>(hn::Add(density, set(kHalf)));
  if (!field.tagged) return entry;
  constexpr int kToHalf = wire::kPositionFractionBits - 1;
  const V nearest = hn::Add(hn::Add(at.index, hn::ShiftRight<kToHalf>(at.fraction[0])),
                            hn::Add(hn::Mul(hn::ShiftRight<kToHalf>(at.fraction[1]), set(field.edge)),
                                    hn::Mul(hn::ShiftRight<kToHalf>(at.fraction[2]), set(field.edge * field.edge))));
  const V code = gather(field.codes, hn::ShiftLeft<1>(nearest));
  return hn::Or(entry, hn::ShiftLeft<12>(hn::And(hn::ShiftRight<kCodeBits>(code), set(wire::kTags - 1))));
}

// OpacityCorrection for a voxel length's depth. 64-bit lanes.
HWY_INLINE VU64 corrected(VU64 depth, VU64 exponent, const PacketField& field) {
  constexpr int kFraction = OpacityCorrection::kFractionBits, kRest = kFraction - OpacityCorrection::kSegmentBits;
  const VU64 one = set64(wire::kOpacityOne);
  // After 25 halvings nothing is left, and more would not fit a shift.
  const VU64 x = hn::Min(hn::ShiftRight<16>(hn::Add(product(depth, exponent), set64(std::uint64_t{1} << 15))),
                         set64(std::uint64_t{25} << kFraction));
  const VU64 whole = hn::ShiftRight<kFraction>(x);
  const VU64 fraction = hn::And(x, set64((std::uint64_t{1} << kFraction) - 1));
  const VU64 segment = gather64(field.tables->exp2.data(), hn::ShiftRight<kRest>(fraction));
  const VU64 fall = product(hn::ShiftRight<32>(segment), hn::And(fraction, set64((std::uint64_t{1} << kRest) - 1)));
  const VU64 value = hn::Sub(hn::ShiftLeft<kRest>(hn::And(segment, set64(0xFFFF'FFFF))), fall);
  const VU64 rounding = hn::Shl(set64(std::uint64_t{1} << (kRest - 1)), whole);
  const VU64 through = hn::Shr(hn::ShiftRight<kRest>(hn::Add(value, rounding)), whole);
  return hn::IfThenElse(hn::Eq(depth, set64(0xFFFF'FFFF)), one, hn::Sub(one, through));
}

HWY_INLINE V corrected(V depth, V exponent, const PacketField& field) {
  return together(corrected(evens(depth), evens(exponent), field), corrected(odds(depth), odds(exponent), field));
}

// The weight of a sample of opacity `alpha` behind `opacity`, as in the first line of over(). 64-bit lanes.
HWY_INLINE VU64 behind(VU64 opacity, VU64 alpha) {
  const VU64 t = hn::Add(product(hn::Sub(set64(wire::kOpacityOne), opacity), alpha), set64(std::uint64_t{1} << 23));
  return hn::ShiftRight<24>(hn::Add(t, hn::ShiftRight<24>(t)));  // divide_by_full_scale<24>
}

HWY_INLINE V behind(V opacity, V alpha) {
  return together(behind(evens(opacity), evens(alpha)), behind(odds(opacity), odds(alpha)));
}

// The weight for an entry's word in PacketField::opacities.
HWY_INLINE V weight_of(V word, V exponent, V opacity, const PacketField& field) {
  if (field.corrected) return behind(opacity, hn::Max(hn::Sub(word, set(1)), hn::Zero(D32())));
  return together(behind(evens(opacity), corrected(evens(word), evens(exponent), field)),
                  behind(odds(opacity), corrected(odds(word), odds(exponent), field)));
}

// A channel's addend in over(): divide_by_full_scale<24> of a product whose halves, by those of the weight, fit 32
// bits.
HWY_INLINE V part_of(V colour, V weight) {
  constexpr int kHalf = 12;
  const V high = hn::Mul(colour, hn::ShiftRight<kHalf>(weight));
  const V low = hn::Add(hn::Mul(colour, hn::And(weight, set((1 << kHalf) - 1))), set(1 << 23));
  const auto upper = [&](V rest) { return hn::ShiftRight<kHalf>(hn::Add(high, hn::ShiftRight<kHalf>(rest))); };
  return upper(hn::Add(low, upper(low)));
}

HWY_INLINE V like(V, std::int32_t x) { return set(x); }
HWY_INLINE bool all(Mask mask) { return hn::AllTrue(D32(), mask); }
HWY_INLINE VF to_float(V x) { return hn::ConvertTo(DF(), x); }
HWY_INLINE V nearest(VF x) { return hn::NearestInt(x); }
#include "datapath/shading-inl.h"

// Texels, for reflectance().
struct SquareOf {
  const PacketTables& tables;

  HWY_INLINE V operator()(V i) const { return gather(tables.reflectance_map.data(), hn::ShiftLeft<2>(i)); }
};

HWY_INLINE ShadingEntry<V> shading_entry(V entry, const PacketField& field) {
  const VU64 even = gather64(field.tables->shading.data(), evens(entry)),
             odd = gather64(field.tables->shading.data(), odds(entry));
  const V low = together(even, odd), high = together(hn::ShiftRight<32>(even), hn::ShiftRight<32>(odd));
  const V colour = set(0xFFF), byte = set(0xFF);
  return {{hn::And(low, colour), hn::And(hn::ShiftRight<12>(low), colour), hn::And(high, colour)},
          hn::And(hn::ShiftRight<24>(low), byte),
          hn::And(hn::ShiftRight<12>(high), byte),
          hn::And(hn::ShiftRight<20>(high), byte)};
}

// Inverse steps along the axes, for steps_out().
struct InverseStep {
  std::array<V, 3> turned;     // all ones if the ray runs forward: distances are measured from the far end
  std::array<VF, 3> per_unit;  // steps per position unit
};

HWY_INLINE InverseStep pace_of(const std::array<V, 3>& step) {
  InverseStep out{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto way = hn::ConvertTo(DF(), hn::Abs(step[axis]));
    const auto still = hn::Eq(way, hn::Zero(DF()));
    out.turned[axis] = hn::VecFromMask(D32(), hn::Gt(step[axis], hn::Zero(D32())));
    out.per_unit[axis] = hn::IfThenElse(still, hn::Set(DF(), 0x1p24f), hn::Div(hn::Set(DF(), 1), way));
  }
  return out;
}

// skip_steps() out of cubes of `mask` + 1 units: the whole steps within the cube, plus one. The quotients are exact:
// with half a unit added they differ from whole numbers by at least half of per_unit, and the two roundings of
// dividends below 2^22 by less.
HWY_INLINE V steps_out(const std::array<V, 3>& position, V mask, const InverseStep& pace, std::int32_t most) {
  auto least = hn::Set(DF(), static_cast<float>(most - 1));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto ahead = hn::ConvertTo(DF(), hn::And(hn::Xor(position[axis], pace.turned[axis]), mask));
    least = hn::Min(least, hn::Mul(hn::Add(ahead, hn::Set(DF(), 0.5f)), pace.per_unit[axis]));
  }
  return hn::Add(hn::ConvertTo(D32(), least), set(1));
}
