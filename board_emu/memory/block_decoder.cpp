// Compiled once for each instruction set that Highway knows (foreach_target); the host's best is chosen at run time.
#include "words/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "memory/block_decoder.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include "memory/block_decoder.h"

#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "gicube/wire/voxel.h"

#ifndef GICUBE_BLOCK_DECODER
#define GICUBE_BLOCK_DECODER
namespace gicube::emu {
namespace {

// `to`, from its place `at` on.
inline DecodedBlock beyond(const DecodedBlock& to, std::size_t at) {
  return {to.voxels == nullptr ? nullptr : to.voxels + at, to.densities == nullptr ? nullptr : to.densities + at,
          to.tags == nullptr ? nullptr : to.tags + at};
}

inline void clear(const DecodedBlock& to, std::size_t count) {
  if (to.voxels != nullptr) std::fill_n(to.voxels, count, DecodedVoxel{});
  if (to.densities != nullptr) std::fill_n(to.densities, count, std::int16_t{0});
  if (to.tags != nullptr) std::fill_n(to.tags, count, std::uint8_t{0});
}

// `count` words from `first` on; the tags that they have.
inline unsigned decode_words(std::span<const std::uint8_t> packed, std::size_t first, std::size_t count,
                             std::span<const DecodedVoxel> codes, const DecodedBlock& to) {
  unsigned tagged = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const wire::Voxel voxel = wire::to_voxel(wire::load36(packed, first + i));
    const auto density = static_cast<std::int16_t>(voxel.density << kDensityFractionBits);
    if (to.voxels != nullptr) {
      const auto code = std::bit_cast<std::array<std::int16_t, 4>>(codes[voxel.gradient]);
      to.voxels[i] = {{density, code[1], code[2], code[3]}};
    }
    if (to.densities != nullptr) to.densities[i] = density;
    if (to.tags != nullptr) to.tags[i] = voxel.tag;
    tagged |= voxel.tag;
  }
  return tagged;
}

// `row(packed, first, to)` decodes the n words from `first` on, and gives the tags that they have.
template <typename Row>
bool decode_rows(const BlockWords& from, std::span<const DecodedVoxel> codes, const DecodedBlock& to, const Row& row) {
  const std::size_t n = from.voxels, edge = n + 1;
  unsigned tagged = 0;
  for (std::size_t z = 0; z <= n; ++z) {
    for (std::size_t y = 0; y <= n; ++y) {
      const std::size_t first = (z % n * n + y % n) * n, neighbour = y / n * 2 + z / n * 4;
      const DecodedBlock begin = beyond(to, (z * edge + y) * edge), end = beyond(begin, n);
      const auto own = from.packed[neighbour], next = from.packed[neighbour + 1];
      if (own.empty()) {
        clear(begin, n);
      } else {
        tagged |= row(own, first, begin);
      }
      if (next.empty()) {
        clear(end, 1);
      } else {
        tagged |= decode_words(next, first, 1, codes, end);
      }
    }
  }
  return tagged != 0;
}

}  // namespace
}  // namespace gicube::emu
#endif

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

bool decode(const BlockWords& from, std::span<const DecodedVoxel> codes, const DecodedBlock& to) {
  return decode_one_by_one(from, codes, to);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

// The n words from the even word `first` on, in lanes of 32 bits: a voxel's irradiance, above those, stands elsewhere.
template <std::size_t kLanes>
HWY_INLINE unsigned decode_row(std::span<const std::uint8_t> packed, std::size_t first, std::size_t n,
                               std::span<const DecodedVoxel> codes, const DecodedBlock& to) {
  const hn::CappedTag<std::int32_t, kLanes> d;
  const hn::Repartition<std::int64_t, decltype(d)> d64;
  const hn::RebindToUnsigned<decltype(d64)> du64;
  const hn::RebindToUnsigned<decltype(d)> du;
  const hn::Half<decltype(du)> half;
  const hn::Rebind<std::int16_t, decltype(d)> d16;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  constexpr int kGradientBit = 12, kTagBit = 23;
  constexpr std::uint32_t kTag = wire::kTags - 1;
  const std::size_t lanes = hn::Lanes(d), pairs = hn::Lanes(d64);
  // Two words are nine bytes: the first's low 32 bits are theirs, the second's begin in the middle of the fifth byte.
  alignas(64) constexpr std::array<std::int64_t, 8> kPairBytes{0, 9, 18, 27, 36, 45, 54, 63};
  const auto pair_bytes = hn::Load(d64, kPairBytes.data());
  auto any = hn::Zero(du);
  for (std::size_t x = 0; x < n; x += lanes) {
    const void* const at = packed.data() + (first + x) / 2 * 9;
    const auto pair = hn::BitCast(du, hn::GatherOffset(du64, static_cast<const std::uint64_t*>(at), pair_bytes));
    const auto words = hn::OddEven(hn::ShiftRight<4>(pair), pair);
    const auto densities =
        hn::And(hn::ShiftLeft<kDensityFractionBits>(words), hn::Set(du, wire::kDensityMax << kDensityFractionBits));
    any = hn::Or(any, words);
    if (to.tags != nullptr) {
      const auto tags = hn::And(hn::ShiftRight<kTagBit>(words), hn::Set(du, kTag));
      hn::StoreU(hn::DemoteTo(d8, hn::BitCast(d, tags)), d8, to.tags + x);
    }
    if (to.densities != nullptr) {
      hn::StoreU(hn::DemoteTo(d16, hn::BitCast(d, densities)), d16, to.densities + x);
    }
    if (to.voxels == nullptr) continue;
    const auto gradients = hn::And(hn::ShiftRight<kGradientBit>(words), hn::Set(du, wire::kGradientCodes - 1));
    const void* const table = codes.data();
    void* const out = to.voxels + x;
    const auto put = [&](auto density, auto gradient, std::size_t where) {
      const auto index = hn::BitCast(d64, hn::PromoteTo(du64, gradient));
      const auto code = hn::GatherIndex(du64, static_cast<const std::uint64_t*>(table), index);
      hn::StoreU(hn::Or(code, hn::PromoteTo(du64, density)), du64, static_cast<std::uint64_t*>(out) + where);
    };
    put(hn::LowerHalf(half, densities), hn::LowerHalf(half, gradients), 0);
    put(hn::UpperHalf(half, densities), hn::UpperHalf(half, gradients), pairs);
  }
  const auto tags = hn::And(any, hn::Set(du, kTag << kTagBit));
  return hn::AllTrue(du, hn::Eq(tags, hn::Zero(du))) ? 0 : 1;
}

template <std::size_t kLanes>
bool decode_with(const BlockWords& from, std::span<const DecodedVoxel> codes, const DecodedBlock& to) {
  return decode_rows(from, codes, to, [&](auto packed, std::size_t first, const DecodedBlock& row) {
    return decode_row<kLanes>(packed, first, from.voxels, codes, row);
  });
}

bool decode(const BlockWords& from, std::span<const DecodedVoxel> codes, const DecodedBlock& to) {
  return from.voxels == 8 ? decode_with<8>(from, codes, to) : decode_with<16>(from, codes, to);
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

bool decode_one_by_one(const BlockWords& from, std::span<const DecodedVoxel> codes, const DecodedBlock& to) {
  return decode_rows(from, codes, to, [&](auto packed, std::size_t first, const DecodedBlock& row) {
    return decode_words(packed, first, from.voxels, codes, row);
  });
}

void decode_colours(const BlockWords& from, const BlockColours& colours, bool premultiplied, DecodedColour* to) {
  const std::size_t n = from.voxels, edge = n + 1;
  for (std::size_t row = 0; row < edge * edge; ++row) {
    const std::size_t y = row % edge, z = row / edge, first = (z % n * n + y % n) * n, begin = y / n * 2 + z / n * 4;
    for (std::size_t x = 0; x < edge; ++x, ++to) {
      const std::size_t block = begin + x / n, voxel = first + x % n;
      const auto words = from.packed[block], bytes = colours.bytes[block];
      int density = 0;
      if (premultiplied && !words.empty()) {
        density = wire::to_voxel(wire::load36(words, voxel)).density << kDensityFractionBits;
      }
      const int factor = premultiplied ? density : kDecodedColourOne;
      for (std::size_t c = 0; c < wire::kColourBytes; ++c) {
        const int byte = bytes.empty() ? 0 : bytes[wire::kColourBytes * voxel + c];
        to->channel[c] = static_cast<std::int16_t>((byte * factor + 127) / 255);
      }
      to->channel[3] = static_cast<std::int16_t>(density);
    }
  }
}

HWY_EXPORT(decode);

bool decode(const BlockWords& from, std::span<const DecodedVoxel> codes, const DecodedBlock& to) {
  return HWY_DYNAMIC_DISPATCH(decode)(from, codes, to);
}

}  // namespace gicube::emu
#endif
