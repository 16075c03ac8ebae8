// Records that pass between the board's parts, in the word formats of its datapaths. The ray itself is wire::Ray.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "gicube/archive.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

inline constexpr int kDensityFractionBits = 3;
inline constexpr int kGradientFractionBits = 5;

// Words of up to four channels that are interpolated together. Eight bytes, so that one load fetches them.
struct alignas(8) ChannelWords {
  std::array<std::int16_t, 4> channel{};

  friend constexpr bool operator==(const ChannelWords&, const ChannelWords&) = default;
};

// A decoded gradient, as the gradient LUT passes it to the resampling unit: 0, then x, y, z, signed with five fraction
// bits (511 * 32 = one; with six, the difference of two opposite vectors would not fit into 16 bits).
using DecodedGradient = ChannelWords;
// 13 bits of a voxel's word: the gradient code, and above it the tag.
inline constexpr int kCodeBits = 11;
constexpr std::size_t gradient_code(std::uint16_t code_and_tag) { return code_and_tag & 0x7FFu; }
constexpr unsigned tag_of(std::uint16_t code_and_tag) { return code_and_tag >> kCodeBits; }

// A voxel's colour as memory passes it to the resampling unit: red, green, blue, 12.3 with 32760 = one. If alpha is the
// voxel's density (wire::VoxelFormat::kRgba), they are multiplied by it, and the fourth word is the density.
using DecodedColour = ChannelWords;
inline constexpr int kDecodedColourOne = 4095 << kDensityFractionBits;

inline constexpr int kIrradianceFractionBits = 4;  // in the interpolator's 15-bit words

// Converts a word of the irradiance memory to the interpolator's format, 11.4. `narrow`: the words have 16 bits more
// than the paper's 11 (wide datapath); only the upper four of them are kept.
constexpr std::int16_t irradiance_word(std::uint32_t word, bool narrow) {
  const std::uint32_t value = narrow ? word >> 12 : word << kIrradianceFractionBits;
  return static_cast<std::int16_t>(std::min(value, std::uint32_t{32767}));
}

// Positions and steps as signed words with 14 fraction bits: a position one step outside the volume may be negative.
using Point = std::array<std::int32_t, 3>;

constexpr std::int64_t dot(const Point& a, const Point& b) {
  return std::int64_t{a[0]} * b[0] + std::int64_t{a[1]} * b[1] + std::int64_t{a[2]} * b[2];
}

// kTrapped: waits for a routine of the DSP. kGone: a carrier that has delivered its energy. kSlot: no ray; a queue
// informs the DSP that it has reserved a slot for its first overflowed ray. kNonResident: has reached a block that is
// not on the card.
enum class TokenStatus : std::uint8_t { kUnderWay, kDone, kOverflowed, kTrapped, kGone, kSlot, kNonResident };

// A cut plane: positions p with normal . p >= offset are kept.
struct Plane {
  Point normal{};           // 1.14
  std::int64_t offset = 0;  // 28 fraction bits, like the product of normal and position
};

// Energy units for the eight voxels of a cell: voxel i is at (i & 1, i >> 1 & 1, i >> 2).
using Shares = std::array<std::uint32_t, 8>;

// A ray's contribution to the irradiance words: shares for the cell whose least corner is `voxel` of the volume. Voxels
// outside the volume get none.
struct Deposit {
  std::array<std::int32_t, 3> voxel{};
  Shares shares{};
};

// A bit error in the board's memory. `block` indexes the stored blocks, `bit` the bits of the block's packed words;
// both indices wrap around.
struct MemoryError {
  std::uint32_t block = 0;
  std::uint32_t bit = 0;
  bool detected = false;

  void state(Archive::Record& record) { record(block, bit, detected); }
};

// A ray in the FIFOs of the cycle level: the handle of its 256-bit packet, which stays in one slot (ray_store.h), and
// the fields that the sorter reads.
struct RayToken {
  std::uint32_t ray = 0;           // handle
  std::uint32_t queue = 0;         // number of its block's queue in its processor
  std::uint16_t contribution = 0;  // 12 bits
  std::uint8_t processor = 0;      // owner of its block
  TokenStatus state = TokenStatus::kUnderWay;
  // Set by the pipeline on a ray that returns to the queue that issued it: its slot there is reserved, so it cannot
  // overflow. For any other destination it is false, and the pipeline releases the slot (sorter/sorter.h).
  bool has_reserved_slot = false;
  bool watched = false;  // its steps are reported to an observer (asic/sim/ray_event.h)
  // Avoids an odd size: 13 bytes are copied by two overlapping moves, and reading those back stalls the host's store
  // buffer.
  std::array<std::uint8_t, 2> unused{};
};

// Limits for the tokens of a checkpoint.
struct TokenLimits {
  std::vector<std::uint8_t> in_block{};    // by handle: the ray is in its block and can be sampled
  std::vector<std::uint32_t> queues{};     // number of queues, by processor
  std::uint32_t here = ~std::uint32_t{0};  // queues of the processor whose state is restored
};

// `watched` is left out: no observer of another process follows the ray.
inline void state_of(Archive::Record& record, RayToken& token) {
  record(token.ray, token.queue, token.contribution, token.processor);
  record.at_most(token.state, TokenStatus::kNonResident);
  record(token.has_reserved_slot);
  const TokenLimits* const limits = record.token_limits();
  if (limits == nullptr) return;
  const bool has_home = token.processor < limits->queues.size() && token.queue < limits->queues[token.processor];
  record.expect(has_home && token.queue < limits->here, "a queue of its processor", token.queue);
  const bool may_have_left = token.state == TokenStatus::kDone || token.state == TokenStatus::kGone;
  const bool is_slot = token.state == TokenStatus::kSlot;
  const bool is_there =
      is_slot || (token.ray < limits->in_block.size() && (may_have_left || limits->in_block[token.ray]));
  record.expect(is_there, "a ray in its block", token.ray);
}

inline constexpr int kPlaneFractionBits = 2 * wire::kPositionFractionBits;

}  // namespace gicube::emu
