// Compiled once for each instruction set of Highway (foreach_target); the host's best is chosen at run time.
#include "words/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "memory/block_decoder.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include "memory/block_decoder.h"

#include <hwy/highway.h>

#include <array>
#include <cstring>

#include "gicube/wire/voxel.h"

#ifndef GICUBE_BLOCK_DECODER
#define GICUBE_BLOCK_DECODER
namespace gicube::emu {
namespace {

constexpr int kCodeBit = 12;                  // position in a voxel's word
constexpr std::uint32_t kCodeMask = 0x1FFFu;  // code and tag

// `row(first, at)` decodes the n words from `first` on to the voxels from `at` on. Returns the OR of all codes and
// tags.
template <typename Row>
std::uint16_t decode_rows(std::size_t n, const Row& row) {
  const std::size_t edge = n + 1;
  std::uint16_t any = 0;
  for (std::size_t z = 0; z < n; ++z) {
    for (std::size_t y = 0; y < n; ++y) any |= row((z * n + y) * n, (z * edge + y) * edge);
  }
  return any;
}

}  // namespace
}  // namespace gicube::emu
#endif

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

std::uint16_t decode(std::span<const std::uint8_t> packed, std::size_t n, const DecodedBlock& to) {
  return decode_one_by_one(packed, n, to);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

// Decodes the n words from the even word `first` on, in lanes of 32 bits, without the irradiance bits above those.
template <std::size_t kLanes>
HWY_INLINE std::uint16_t decode_row(std::span<const std::uint8_t> packed, std::size_t first, std::size_t n,
                                    std::int16_t* densities_to, std::uint16_t* codes_to) {
  const hn::CappedTag<std::int32_t, kLanes> d;
  const hn::Repartition<std::int64_t, decltype(d)> d64;
  const hn::RebindToUnsigned<decltype(d64)> du64;
  const hn::RebindToUnsigned<decltype(d)> du;
  const hn::Rebind<std::int16_t, decltype(d)> d16;
  const hn::Rebind<std::uint16_t, decltype(d)> du16;
  const std::size_t lanes = hn::Lanes(d);
  // Two words are nine bytes: the first's low 32 bits begin with the first byte, the second's in the middle of the
  // fifth.
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
    hn::StoreU(hn::DemoteTo(d16, hn::BitCast(d, densities)), d16, densities_to + x);
    if (codes_to != nullptr) hn::StoreU(hn::DemoteTo(du16, hn::BitCast(d, codes)), du16, codes_to + x);
  }
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < lanes; ++i) bits |= hn::ExtractLane(any, i);
  return static_cast<std::uint16_t>(bits);
}

template <std::size_t kLanes>
std::uint16_t decode_with(std::span<const std::uint8_t> packed, std::size_t n, const DecodedBlock& to) {
  return decode_rows(n, [&](std::size_t first, std::size_t at) {
    return decode_row<kLanes>(packed, first, n, to.densities + at, to.codes == nullptr ? nullptr : to.codes + at);
  });
}

std::uint16_t decode(std::span<const std::uint8_t> packed, std::size_t n, const DecodedBlock& to) {
  return n == 8 ? decode_with<8>(packed, n, to) : decode_with<16>(packed, n, to);
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

std::uint16_t decode_one_by_one(std::span<const std::uint8_t> packed, std::size_t n, const DecodedBlock& to) {
  return decode_rows(n, [&](std::size_t first, std::size_t at) {
    std::uint16_t any = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint64_t word = wire::load36(packed, first + i);
      const auto code = static_cast<std::uint16_t>(word >> kCodeBit & kCodeMask);
      to.densities[at + i] = static_cast<std::int16_t>((word & wire::kDensityMax) << kDensityFractionBits);
      if (to.codes != nullptr) to.codes[at + i] = code;
      any |= code;
    }
    return any;
  });
}

bool has_irradiance_bits(std::span<const std::uint8_t> packed) {
  // Tests bits 8 to 71 of each pair of words; bits 25..35 and 61..71 are the irradiance.
  constexpr std::uint64_t kBits = std::uint64_t{0x7FF} << 17 | std::uint64_t{0x7FF} << 53;
  std::uint64_t any = 0;
  for (std::size_t at = 1; at + 8 <= packed.size(); at += 9) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, packed.data() + at, sizeof eight);
    any |= eight;
  }
  return (any & kBits) != 0;
}

void pack(const std::int16_t* densities, const std::uint16_t* codes, std::size_t n, std::span<std::uint8_t> out) {
  const std::size_t edge = n + 1;
  std::size_t at = 0;
  for (std::size_t row = 0; row < n * n; ++row) {
    const std::size_t first = (row / n * edge + row % n) * edge;
    const auto word = [&](std::size_t i) {
      const auto density = static_cast<std::uint64_t>(densities[first + i] >> kDensityFractionBits);
      return density | std::uint64_t{codes == nullptr ? std::uint16_t{0} : codes[first + i]} << kCodeBit;
    };
    for (std::size_t x = 0; x < n; x += 2, at += 9) {
      const std::uint64_t second = word(x + 1);
      wire::store(out, at, word(x) | second << wire::kVoxelBits);
      out[at + 8] = static_cast<std::uint8_t>(second >> (64 - wire::kVoxelBits));
    }
  }
}

HWY_EXPORT(decode);

std::uint16_t decode(std::span<const std::uint8_t> packed, std::size_t n, const DecodedBlock& to) {
  return HWY_DYNAMIC_DISPATCH(decode)(packed, n, to);
}

}  // namespace gicube::emu
#endif
