// Compiled once for each instruction set that Highway knows (foreach_target); the host's best is chosen at run time.
#include "words/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "memory/block_decoder.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include "memory/block_decoder.h"

#include <hwy/highway.h>

#include <algorithm>

#include "gicube/wire/voxel.h"

#ifndef GICUBE_BLOCK_DECODER
#define GICUBE_BLOCK_DECODER
namespace gicube::emu {
namespace {

// `to`, from its place `at` on.
inline DecodedBlock beyond(const DecodedBlock& to, std::size_t at) {
  return {to.densities + at, to.codes == nullptr ? nullptr : to.codes + at};
}

inline void clear(const DecodedBlock& to, std::size_t count) {
  std::fill_n(to.densities, count, std::int16_t{0});
  if (to.codes != nullptr) std::fill_n(to.codes, count, std::uint16_t{0});
}

constexpr int kCodeBit = 12;                  // of a voxel's word
constexpr std::uint32_t kCodeMask = 0x1FFFu;  // code and tag

// `count` words from `first` on; the bits of their codes and tags.
inline std::uint16_t decode_words(std::span<const std::uint8_t> packed, std::size_t first, std::size_t count,
                                  const DecodedBlock& to) {
  std::uint16_t any = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t word = wire::load36(packed, first + i);
    const auto code = static_cast<std::uint16_t>(word >> kCodeBit & kCodeMask);
    to.densities[i] = static_cast<std::int16_t>((word & wire::kDensityMax) << kDensityFractionBits);
    if (to.codes != nullptr) to.codes[i] = code;
    any |= code;
  }
  return any;
}

// `row(packed, first, to)` decodes the n words from `first` on, and gives the bits that their codes and tags have.
template <typename Row>
std::uint16_t decode_rows(const BlockWords& from, const DecodedBlock& to, const Row& row) {
  const std::size_t n = from.voxels, edge = n + 1;
  std::uint16_t any = 0;
  for (std::size_t z = 0; z <= n; ++z) {
    for (std::size_t y = 0; y <= n; ++y) {
      const std::size_t first = (z % n * n + y % n) * n, neighbour = y / n * 2 + z / n * 4;
      const DecodedBlock begin = beyond(to, (z * edge + y) * edge), end = beyond(begin, n);
      const auto own = from.packed[neighbour], next = from.packed[neighbour + 1];
      if (own.empty()) {
        clear(begin, n);
      } else {
        any |= row(own, first, begin);
      }
      if (next.empty()) {
        clear(end, 1);
      } else {
        any |= decode_words(next, first, 1, end);
      }
    }
  }
  return any;
}

}  // namespace
}  // namespace gicube::emu
#endif

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

std::uint16_t decode(const BlockWords& from, const DecodedBlock& to) { return decode_one_by_one(from, to); }

#else

namespace hn = hwy::HWY_NAMESPACE;

// The n words from the even word `first` on, in lanes of 32 bits: a voxel's irradiance, above those, stands elsewhere.
template <std::size_t kLanes>
HWY_INLINE std::uint16_t decode_row(std::span<const std::uint8_t> packed, std::size_t first, std::size_t n,
                                    const DecodedBlock& to) {
  const hn::CappedTag<std::int32_t, kLanes> d;
  const hn::Repartition<std::int64_t, decltype(d)> d64;
  const hn::RebindToUnsigned<decltype(d64)> du64;
  const hn::RebindToUnsigned<decltype(d)> du;
  const hn::Rebind<std::int16_t, decltype(d)> d16;
  const hn::Rebind<std::uint16_t, decltype(d)> du16;
  const std::size_t lanes = hn::Lanes(d);
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
    const auto codes = hn::And(hn::ShiftRight<kCodeBit>(words), hn::Set(du, kCodeMask));
    any = hn::Or(any, codes);
    hn::StoreU(hn::DemoteTo(d16, hn::BitCast(d, densities)), d16, to.densities + x);
    if (to.codes != nullptr) hn::StoreU(hn::DemoteTo(du16, hn::BitCast(d, codes)), du16, to.codes + x);
  }
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < lanes; ++i) bits |= hn::ExtractLane(any, i);
  return static_cast<std::uint16_t>(bits);
}

template <std::size_t kLanes>
std::uint16_t decode_with(const BlockWords& from, const DecodedBlock& to) {
  return decode_rows(from, to, [&](auto packed, std::size_t first, const DecodedBlock& row) {
    return decode_row<kLanes>(packed, first, from.voxels, row);
  });
}

std::uint16_t decode(const BlockWords& from, const DecodedBlock& to) {
  return from.voxels == 8 ? decode_with<8>(from, to) : decode_with<16>(from, to);
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

std::uint16_t decode_one_by_one(const BlockWords& from, const DecodedBlock& to) {
  return decode_rows(from, to, [&](auto packed, std::size_t first, const DecodedBlock& row) {
    return decode_words(packed, first, from.voxels, row);
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

std::uint16_t decode(const BlockWords& from, const DecodedBlock& to) { return HWY_DYNAMIC_DISPATCH(decode)(from, to); }

}  // namespace gicube::emu
#endif
