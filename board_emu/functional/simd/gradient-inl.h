// The gradient of samples in lanes, and the colour of their voxels.

// Included once for each instruction set.
#if defined(GICUBE_PACKET_GRADIENT) == defined(HWY_TARGET_TOGGLE)
#ifdef GICUBE_PACKET_GRADIENT
#undef GICUBE_PACKET_GRADIENT
#else
#define GICUBE_PACKET_GRADIENT
#endif

#include "stages-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR

// resample_all(): of the low or, `kOdd`, high halves of 64-bit lanes, all four channels of `words`.
template <bool kOdd>
HWY_INLINE VU64 resample_channels(const DecodedVoxel* words, const SmallPlace& at, const PacketField& field) {
  const std::ptrdiff_t down = field.edge, deep = std::ptrdiff_t{field.edge} * field.edge;
  const auto spread = [](V weights, int half) {  // a 16-bit half of each 64-bit lane into the whole of it
    const auto byte = static_cast<std::uint64_t>(4 * kOdd + 2 * half);
    const std::uint64_t low = (byte | (byte + 1) << 8) * 0x0001'0001'0001'0001u;
    alignas(16) const std::array<std::uint64_t, 2> bytes{low, low + 0x0808'0808'0808'0808u};
    return hn::BitCast(D16(), hn::TableLookupBytes(hn::BitCast(DU64(), weights), hn::LoadDup128(DU64(), bytes.data())));
  };
  const VU64 index = kOdd ? odds(at.index) : evens(at.index);
  const V16 x = spread(at.x_and_y, 0), y = spread(at.x_and_y, 1), z = spread(at.z, 0);
  const auto row = [&](std::ptrdiff_t offset) {
    const DecodedVoxel* const from = words + offset;
    const V16 a = hn::BitCast(D16(), gather64(from, index)), b = hn::BitCast(D16(), gather64(from + 1, index));
    return lerp16(a, b, x);
  };
  const V16 near = lerp16(row(0), row(down), y), far = lerp16(row(deep), row(deep + down), y);
  return hn::BitCast(DU64(), lerp16(near, far, z));
}

HWY_INLINE std::array<V, 3> resample_gradient(const SmallPlace& at, const PacketField& field) {
  const VU64 even = resample_channels<false>(field.voxels, at, field);
  const VU64 odd = resample_channels<true>(field.voxels, at, field);
  const V low = together(even, odd), high = together(hn::ShiftRight<32>(even), hn::ShiftRight<32>(odd));
  return {hn::ShiftRight<16>(low), hn::ShiftRight<16>(hn::ShiftLeft<16>(high)), hn::ShiftRight<16>(high)};
}

// colour_of_words() of the samples' colours.
HWY_INLINE std::array<V, 3> voxel_colour(const SmallPlace& at, const PacketField& field) {
  const VU64 even = resample_channels<false>(field.colours, at, field);
  const VU64 odd = resample_channels<true>(field.colours, at, field);
  const V low = together(even, odd), high = together(hn::ShiftRight<32>(even), hn::ShiftRight<32>(odd));
  const V word = set(0xFFFF), one = set(static_cast<std::int32_t>(wire::kColourOne));  // words are not negative
  const std::array<V, 3> words{hn::And(low, word), hn::ShiftRight<16>(low), hn::And(high, word)};
  const V alpha = hn::ShiftRight<16>(high);
  std::array<V, 3> out{};
  for (std::size_t c = 0; c < 3; ++c) {
    if (!field.premultiplied) {
      out[c] = hn::ShiftRight<kDensityFractionBits>(hn::Add(words[c], set(1 << (kDensityFractionBits - 1))));
      continue;
    }
    const VF part = hn::Div(hn::ConvertTo(DF(), words[c]), hn::ConvertTo(DF(), alpha));
    const V factor = hn::NearestInt(hn::Mul(part, hn::Set(DF(), static_cast<float>(wire::kColourOne))));
    out[c] = hn::IfThenElseZero(hn::Gt(alpha, hn::Zero(D32())), hn::Min(factor, one));
  }
  return out;
}

// tinted().
HWY_INLINE V tinted(V colour, V factor) {
  const V product = hn::Add(hn::Mul(colour, factor), set(1 << 11));
  return hn::ShiftRight<12>(hn::Add(product, hn::ShiftRight<12>(product)));
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
