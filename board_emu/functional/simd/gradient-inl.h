// The gradient of samples in lanes, and the colour of their voxels.

#include "functional/simd/stages-inl.h"

// resample_all() for the low or, with `kOdd`, high halves of 64-bit lanes, all four channels. `pair(offset)`: the words
// of the voxels at `offset` from the sample's first, and of their neighbours along x.
template <bool kOdd, typename Pair>
HWY_INLINE VU64 resample_channels(const PackedPosition& at, const PacketField& field, const Pair& pair) {
  const std::ptrdiff_t down = field.edge, deep = std::ptrdiff_t{field.edge} * field.edge;
  const auto spread = [](V weights, int half) {  // copies a 16-bit half of each 64-bit lane to all of it
    const auto byte = static_cast<std::uint64_t>(4 * kOdd + 2 * half);
    const std::uint64_t low = (byte | (byte + 1) << 8) * 0x0001'0001'0001'0001u;
    alignas(16) const std::array<std::uint64_t, 2> bytes{low, low + 0x0808'0808'0808'0808u};
    return hn::BitCast(D16(), hn::TableLookupBytes(hn::BitCast(DU64(), weights), hn::LoadDup128(DU64(), bytes.data())));
  };
  const V16 x = spread(at.x_and_y, 0), y = spread(at.x_and_y, 1), z = spread(at.z, 0);
  const auto row = [&](std::ptrdiff_t offset) {
    const auto [a, b] = pair(offset);
    return lerp16(hn::BitCast(D16(), a), hn::BitCast(D16(), b), x);
  };
  const V16 near = lerp16(row(0), row(down), y), far = lerp16(row(deep), row(deep + down), y);
  return hn::BitCast(DU64(), lerp16(near, far, z));
}

struct PairOfWords {
  VU64 first, next;
};

// gradient_at(), which decodes the voxels' codes.
template <bool kOdd>
HWY_INLINE VU64 resample_codes(const PackedPosition& at, const PacketField& field) {
  return resample_channels<kOdd>(at, field, [&](std::ptrdiff_t offset) {
    const V codes = gather(field.codes + offset, hn::ShiftLeft<1>(at.index));  // two neighbours' codes per word
    const VU64 both = kOdd ? odds(codes) : evens(codes), mask = set64((1u << kCodeBits) - 1);
    return PairOfWords{gather64(field.gradients, hn::And(both, mask)),
                       gather64(field.gradients, hn::And(hn::ShiftRight<16>(both), mask))};
  });
}

// The decoded colours of the voxels.
template <bool kOdd>
HWY_INLINE VU64 resample_colours(const PackedPosition& at, const PacketField& field) {
  const VU64 index = kOdd ? odds(at.index) : evens(at.index);
  return resample_channels<kOdd>(at, field, [&](std::ptrdiff_t offset) {
    return PairOfWords{gather64(field.colours + offset, index), gather64(field.colours + offset + 1, index)};
  });
}

HWY_INLINE std::array<V, 3> resample_gradient(const PackedPosition& at, const PacketField& field) {
  if (field.codes == nullptr) {
    const auto& all = field.gradients[0].channel;
    return {set(all[1]), set(all[2]), set(all[3])};
  }
  const VU64 even = resample_codes<false>(at, field), odd = resample_codes<true>(at, field);
  const V low = together(even, odd), high = together(hn::ShiftRight<32>(even), hn::ShiftRight<32>(odd));
  return {hn::ShiftRight<16>(low), hn::ShiftRight<16>(hn::ShiftLeft<16>(high)), hn::ShiftRight<16>(high)};
}

// colour_of_words() for the samples' colours.
HWY_INLINE std::array<V, 3> voxel_colour(const PackedPosition& at, const PacketField& field) {
  const VU64 even = resample_colours<false>(at, field), odd = resample_colours<true>(at, field);
  const V low = together(even, odd), high = together(hn::ShiftRight<32>(even), hn::ShiftRight<32>(odd));
  const V word = set(0xFFFF);  // words are not negative
  return factor_of_words<V>(
      {hn::And(low, word), hn::ShiftRight<16>(low), hn::And(high, word), hn::ShiftRight<16>(high)},
      field.premultiplied);
}
