// The gradient of samples in lanes.

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

// resample_all(): of the low or, `kOdd`, high halves of 64-bit lanes, all four channels.
template <bool kOdd>
HWY_INLINE VU64 resample_channels(const SmallPlace& at, const PacketField& field) {
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
    const DecodedVoxel* const from = field.voxels + offset;
    const V16 a = hn::BitCast(D16(), gather64(from, index)), b = hn::BitCast(D16(), gather64(from + 1, index));
    return lerp16(a, b, x);
  };
  const V16 near = lerp16(row(0), row(down), y), far = lerp16(row(deep), row(deep + down), y);
  return hn::BitCast(DU64(), lerp16(near, far, z));
}

HWY_INLINE std::array<V, 3> resample_gradient(const SmallPlace& at, const PacketField& field) {
  const VU64 even = resample_channels<false>(at, field), odd = resample_channels<true>(at, field);
  const V low = together(even, odd), high = together(hn::ShiftRight<32>(even), hn::ShiftRight<32>(odd));
  return {hn::ShiftRight<16>(low), hn::ShiftRight<16>(hn::ShiftLeft<16>(high)), hn::ShiftRight<16>(high)};
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
