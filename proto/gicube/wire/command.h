// DSP commands: the payload of kCommand frames, and of the completions that answer them.
//
// kRender: the DSP makes the viewing rays of one image and gathers them in the framebuffer. Its completion is empty, or a
// trap list (below) without rays if some of its rays wait for the host.
//
//   byte  size  field
//      0     4  opcode = 1
//      4     2  width, pixels        6  2  height, pixels
//      8     1  projection           0 orthographic, 1 perspective
//      9     1  samples_per_axis     1, 2 or 4: rays a pixel are its square
//     10     1  filter               0 box, 1 tent (two pixels wide)
//     11     1  reserved, 0
//     12     4  reserved, 0
//     16  4x24  origin, forward, du, dv: three doubles each, voxels
//
// Image point (x, y), pixels from the image's top left corner:
//   perspective   origin = origin,                 direction = forward + x du + y dv
//   orthographic  origin = origin + x du + y dv,   direction = forward
//
// kTrace: host rays in, host rays out in its completion, in the order in which they were sent.
//
//   byte  size  field
//      0     4  opcode = 2
//      4     4  count
//      8     1  type     0 integrate, 1 first hit, 2 segment, 3 opacity, 4 deposit, 5 integral, 6 backproject
//      9     1  albedo   0 low, 1 high             } of deposit; else 0
//     10     1  rules    0 as printed, 1 conserving }
//     11     1  words    of backproject: 0 irradiance words, 1 sums, the whole 36-bit voxel words; else 0
//     12     4  opacity  24 bits, 2^24 - 1 = 1, not 0: at which a ray of type 1, 2 or 3 ends; else 0
//     16  32 n  ray packets (ray.h), flags kHostRay alone; and of deposit: also kLightingRay, and kHighAlbedo as `albedo`
//
// The colour of a ray packet on its way to the board, 36 bits:
//   integrate         colour that is gathered already, 3 x 12 bits
//   first hit         the same, and it stays as it is
//   segment, opacity  low 32 bits: length, 16.16 voxels, at most 4096; the other bits 0. They start without opacity.
//   deposit           energy, 24.12 units of the energy words, not 0; at most 255 units of low albedo, 15 of high,
//                     2^24 - 1 on the wide datapath
//   integral          length, as a segment
//   backproject       length, as a segment; the opacity's 24 bits are the amount that each sample leaves: in irradiance
//                     words 11.12 units, not negative; in sums signed whole units, at least -(2^23 - 1)
// A segment's step divides its length evenly, and is at most STEP. Its packet has no need for contribution, lifetime,
// generation and interaction: on the ASIC these 38 bits are the steps that are left and their length.
// First hit, opacity: no colour comes back. Integral: the colour's 36 bits are the sum of the samples' densities, 12.3
// each, with no opacity; it leaps over nothing, since an empty block may have density. At most 2^18 samples of 2^15: 33 bits.
// Deposit, backproject: no ray comes back; their completions are a LightingLedger and a DepositLedger.
//
// Backproject takes nothing from its rays: each sample leaves the ray's amount, split among the eight voxels around it. In
// irradiance words by systematic rounding, saturating, as lighting deposits; in sums by halves (board_emu/datapath/trilinear_splat.h).
// After a command each sum is within +-(2^34 - 1), and what is beyond is clipped and counted; within a command it can't
// leave its 36 bits, because one whose rays could move a word by more than 2^34 is refused: the sum over the rays of
// |amount| x (3 + floor(2 / step in voxels)) is at most 2^34.
//
// kIlluminate: the DSP makes the lighting rays of one light; they leave their energy in the irradiance words. Its
// completion holds a LightingLedger: kLightingLedgerBytes of u64 in its order; and then as kRender's.
//
//   byte  size  field
//      0     4  opcode = 3
//      4     1  kind             0 point, 1 directional, 2 rectangle, 3 sphere
//      5     1  albedo           0 low, 1 high
//      6     1  rules            0 as printed, 1 conserving
//      7     1  reserved, 0
//      8     4  rays_per_voxel   k: rays a face voxel of the whole pass
//     12     4  first            of those k, this command sends first .. first + count - 1
//     16     4  count
//     20     4  reserved, 0
//     24     8  energy           double: the light's power, directional: irradiance; units of the energy words, physical
//                                lengths in those of the SPACING registers
//     32  3x24  position, u, v   three doubles each. point: position (voxels). directional: u is towards the light.
//                                rectangle: position is a corner, u and v its edges (physical), it shines along u x v.
//                                sphere: position is the centre, u.x the radius (physical)
//
// kResume: answers for rays of the last kRender or kIlluminate that wait for the host (routine 255), which go on from where
// they trapped; and asks for more of them. Registers, tables and volume must be as they were. The next kRender or
// kIlluminate forgets the rays that still wait.
//
//   byte  size  field
//      0     4  opcode = 4
//      4     4  count   at most as many as were handed out and not answered
//      8     4  most    rays that the completion may hold
//     12     4  reserved, 0
//     16  32 n  ray packets as trap.h says
//
// Its completion: after a kIlluminate first a LightingLedger of what these rays did, `emitted` being the energy that they
// brought back and `rays` those that came to an end; then a trap list.
//
// kVerify: reads blocks of the volume's memory back and sums them up; of the blocks first .. first + count - 1 that are
// stored each is read once. Its completion: u32 CRC-32C of each block's n^3 packed words (memory_map.h), those of a block
// that was never written being zero.
//
//   byte  size  field
//      0     4  opcode = 5
//      4     4  first
//      8     4  count   1 to 65536
//     12     4  reserved, 0
//
// Trap list:
//      0     4  count    rays that follow
//      4     4  waiting  rays that still wait on the board
//      8  64 n  trapped rays (trap.h), those of one command by their (v, u)
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

// kPairs: the DSP makes rays between elements (pair.h), traces them as opacity rays, and sums them up.
//
//   byte  size  field
//      0     4  opcode = 6
//      4     4  E, elements
//      8     4  P, pairs
//     12     4  rays a pair, 1..65536; P times that at most 2^22
//     16     4  the first of the samples to be taken
//     20     4  seed
//     24     4  opacity at which a ray ends, 24 bits, not 0
//     28     4  reserved, 0
//     32  56 E  elements
//         12 P  pairs
//
// Its completion: 16 bytes a pair: f64 mean of G T, f32 mean of G, f32 standard error of the first.
//
enum class Opcode : std::uint32_t { kRender = 1, kTrace = 2, kIlluminate = 3, kResume = 4, kVerify = 5, kPairs = 6 };
enum class Projection : std::uint8_t { kOrthographic = 0, kPerspective = 1 };
enum class Filter : std::uint8_t { kBox = 0, kTent = 1 };

inline constexpr int kMaxImageSize = 4095;  // u, v are 12.4 pixels
inline constexpr std::size_t kRenderCommandBytes = 112;
inline constexpr std::size_t kTraceHeaderBytes = 16;
inline constexpr std::size_t kResumeHeaderBytes = 16;
inline constexpr std::size_t kTrapListHeaderBytes = 8;
inline constexpr std::size_t kVerifyCommandBytes = 16;
inline constexpr std::uint32_t kMaxVerifyBlocks = 65'536;  // chosen: their sums fit the smallest usual payload limit

struct RenderCommand {
  std::uint16_t width = 0;
  std::uint16_t height = 0;
  Projection projection = Projection::kPerspective;
  std::uint8_t samples_per_axis = 1;
  Filter filter = Filter::kBox;
  std::array<double, 3> origin{};
  std::array<double, 3> forward{};
  std::array<double, 3> du{};
  std::array<double, 3> dv{};

  friend constexpr bool operator==(const RenderCommand&, const RenderCommand&) = default;
};

inline void encode(const RenderCommand& command, std::span<std::uint8_t, kRenderCommandBytes> out) {
  store(out, 0, static_cast<std::uint32_t>(Opcode::kRender));
  store(out, 4, command.width);
  store(out, 6, command.height);
  store(out, 8, static_cast<std::uint8_t>(command.projection));
  store(out, 9, command.samples_per_axis);
  store(out, 10, static_cast<std::uint8_t>(command.filter));
  store(out, 11, std::uint8_t{0});
  store(out, 12, std::uint32_t{0});
  const std::array<const std::array<double, 3>*, 4> vectors{&command.origin, &command.forward, &command.du,
                                                            &command.dv};
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) store_double(out, 16 + 24 * i + 8 * axis, (*vectors[i])[axis]);
  }
}

enum class RayType : std::uint8_t {
  kIntegrate = 0,
  kFirstHit = 1,
  kSegment = 2,
  kOpacity = 3,
  kDeposit = 4,
  kIntegral = 5,
  kBackproject = 6,
};
template <RayType... kTypes>
constexpr bool is_one_of(RayType type) {  // by a mask: it is asked for each sample
  return (((1u << static_cast<unsigned>(kTypes)) | ...) >> static_cast<unsigned>(type) & 1) != 0;
}
// Between two points, with a length in the packet.
constexpr bool is_segment(RayType type) {
  return is_one_of<RayType::kSegment, RayType::kOpacity, RayType::kIntegral, RayType::kBackproject>(type);
}
// Ends at the sample that brings it to the opacity asked for.
constexpr bool has_threshold(RayType type) {
  return is_one_of<RayType::kFirstHit, RayType::kSegment, RayType::kOpacity>(type);
}
enum class SumWords : std::uint8_t { kIrradiance = 0, kWhole = 1 };
inline constexpr std::int32_t kMaxAmount = (1 << 23) - 1;             // that a sample leaves
inline constexpr int kAmountFractionBits = 12;                        // in irradiance words
inline constexpr std::int64_t kMaxSum = (std::int64_t{1} << 34) - 1;  // between commands
inline constexpr std::uint32_t kMaxLength = 4096u << 16;  // of a segment, 16.16 voxels: beyond any volume's diagonal

enum class LightKind : std::uint8_t { kPoint = 0, kDirectional = 1, kRectangle = 2, kSphere = 3 };
enum class Albedo : std::uint8_t { kLow = 0, kHigh = 1 };
enum class EnergyRules : std::uint8_t { kAsPrinted = 0, kConserving = 1 };

inline constexpr std::size_t kIlluminateCommandBytes = 104;
inline constexpr std::uint32_t kMaxRaysPerVoxel = 4096;

struct IlluminateCommand {
  LightKind kind = LightKind::kPoint;
  Albedo albedo = Albedo::kLow;
  EnergyRules rules = EnergyRules::kConserving;
  std::uint32_t rays_per_voxel = 1;
  std::uint32_t first = 0;
  std::uint32_t count = 1;
  double energy = 0;
  std::array<double, 3> position{};
  std::array<double, 3> u{};
  std::array<double, 3> v{};

  friend constexpr bool operator==(const IlluminateCommand&, const IlluminateCommand&) = default;
};

inline void encode(const IlluminateCommand& command, std::span<std::uint8_t, kIlluminateCommandBytes> out) {
  store(out, 0, static_cast<std::uint32_t>(Opcode::kIlluminate));
  store(out, 4, static_cast<std::uint8_t>(command.kind));
  store(out, 5, static_cast<std::uint8_t>(command.albedo));
  store(out, 6, static_cast<std::uint8_t>(command.rules));
  store(out, 7, std::uint8_t{0});
  store(out, 8, command.rays_per_voxel);
  store(out, 12, command.first);
  store(out, 16, command.count);
  store(out, 20, std::uint32_t{0});
  store_double(out, 24, command.energy);
  const std::array<const std::array<double, 3>*, 3> vectors{&command.position, &command.u, &command.v};
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) store_double(out, 32 + 24 * i + 8 * axis, (*vectors[i])[axis]);
  }
}

// What precedes the ray packets of kTrace.
struct TraceHeader {
  std::uint32_t count = 0;
  RayType type = RayType::kIntegrate;
  Albedo albedo = Albedo::kLow;
  EnergyRules rules = EnergyRules::kAsPrinted;
  SumWords words = SumWords::kIrradiance;
  std::uint32_t opacity = 0;

  friend constexpr bool operator==(const TraceHeader&, const TraceHeader&) = default;
};

inline void encode(const TraceHeader& header, std::span<std::uint8_t, kTraceHeaderBytes> out) {
  store(out, 0, static_cast<std::uint32_t>(Opcode::kTrace));
  store(out, 4, header.count);
  store(out, 8, static_cast<std::uint8_t>(header.type));
  store(out, 9, static_cast<std::uint8_t>(header.albedo));
  store(out, 10, static_cast<std::uint8_t>(header.rules));
  store(out, 11, static_cast<std::uint8_t>(header.words));
  store(out, 12, header.opacity);
}

inline TraceHeader decode_trace(std::span<const std::uint8_t, kTraceHeaderBytes> in) {
  TraceHeader header;
  header.count = load<std::uint32_t>(in, 4);
  header.type = static_cast<RayType>(load<std::uint8_t>(in, 8));
  header.albedo = static_cast<Albedo>(load<std::uint8_t>(in, 9));
  header.rules = static_cast<EnergyRules>(load<std::uint8_t>(in, 10));
  header.words = static_cast<SumWords>(load<std::uint8_t>(in, 11));
  header.opacity = load<std::uint32_t>(in, 12);
  return header;
}

inline IlluminateCommand decode_illuminate(std::span<const std::uint8_t, kIlluminateCommandBytes> in) {
  IlluminateCommand command;
  command.kind = static_cast<LightKind>(load<std::uint8_t>(in, 4));
  command.albedo = static_cast<Albedo>(load<std::uint8_t>(in, 5));
  command.rules = static_cast<EnergyRules>(load<std::uint8_t>(in, 6));
  command.rays_per_voxel = load<std::uint32_t>(in, 8);
  command.first = load<std::uint32_t>(in, 12);
  command.count = load<std::uint32_t>(in, 16);
  command.energy = load_double(in, 24);
  const std::array<std::array<double, 3>*, 3> vectors{&command.position, &command.u, &command.v};
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) (*vectors[i])[axis] = load_double(in, 32 + 24 * i + 8 * axis);
  }
  return command;
}

// Where the energy of a lighting command went, in units of the energy words:
// emitted = deposited + escaped + scattered_away + clipped + what rays carry that wait for the host (trap.h).
struct LightingLedger {
  std::uint64_t rays = 0;
  std::uint64_t emitted = 0;
  std::uint64_t deposited = 0;       // into irradiance words, each voxel counted once
  std::uint64_t escaped = 0;         // left the volume
  std::uint64_t scattered_away = 0;  // by the printed rules, with rays that were given up, by routines
  std::uint64_t given_up = 0;        // of that, with rays at the end of their lifetime
  std::uint64_t clipped = 0;         // by saturated irradiance words
  std::uint64_t light_in_solid = 0;  // 1: the voxels at the light's place are opaque

  friend constexpr bool operator==(const LightingLedger&, const LightingLedger&) = default;
};
inline constexpr std::size_t kLightingLedgerBytes = 64;

inline void encode(const LightingLedger& ledger, std::span<std::uint8_t, kLightingLedgerBytes> out) {
  const std::array words{ledger.rays,           ledger.emitted,  ledger.deposited, ledger.escaped,
                         ledger.scattered_away, ledger.given_up, ledger.clipped,   ledger.light_in_solid};
  for (std::size_t i = 0; i < words.size(); ++i) store(out, 8 * i, words[i]);
}

inline LightingLedger decode_lighting_ledger(std::span<const std::uint8_t, kLightingLedgerBytes> in) {
  const auto word = [in](std::size_t i) { return load<std::uint64_t>(in, 8 * i); };
  return {word(0), word(1), word(2), word(3), word(4), word(5), word(6), word(7)};
}

// The steps that a segment of `length` is divided into, both 16.16 voxels; each is at most `step`.
constexpr std::uint32_t steps_of(std::uint32_t length, std::uint32_t step) { return (length + step - 1) / step; }

// The most that a backprojecting ray can add to one word: the samples along it that are less than a voxel from a place
// on every axis lie on a piece shorter than 2 sqrt(3) voxels, and the weights of a piece of line sum to no more than this.
constexpr std::uint64_t max_moved(std::uint32_t amount_size, std::uint32_t length, std::uint32_t step) {
  const std::uint32_t steps = steps_of(length, step);
  if (steps == 0) return 0;
  const std::uint32_t each = length / steps;
  const std::uint64_t weight = each == 0 ? steps : 3 + (2u << 16) / each;
  return std::uint64_t{amount_size} * (weight < steps ? weight : steps);
}

// What a backprojection left, in units of its words: left = kept + clipped.
struct DepositLedger {
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;     // that left something or, of amount 0, nothing
  std::int64_t kept = 0;         // by the words, each voxel counted once
  std::int64_t clipped = 0;      // by words that were full; of sums: signed, as what was clipped
  std::uint64_t overflowed = 0;  // sums that were clipped after the command

  friend constexpr bool operator==(const DepositLedger&, const DepositLedger&) = default;
};
inline constexpr std::size_t kDepositLedgerBytes = 40;

inline void encode(const DepositLedger& ledger, std::span<std::uint8_t, kDepositLedgerBytes> out) {
  store(out, 0, ledger.rays);
  store(out, 8, ledger.samples);
  store(out, 16, static_cast<std::uint64_t>(ledger.kept));
  store(out, 24, static_cast<std::uint64_t>(ledger.clipped));
  store(out, 32, ledger.overflowed);
}

inline DepositLedger decode_deposit_ledger(std::span<const std::uint8_t, kDepositLedgerBytes> in) {
  const auto word = [in](std::size_t i) { return load<std::uint64_t>(in, 8 * i); };
  return {word(0), word(1), static_cast<std::int64_t>(word(2)), static_cast<std::int64_t>(word(3)), word(4)};
}

// The enumerations are taken as they come: the DSP checks every field's range and names the one that is wrong.
inline RenderCommand decode_render(std::span<const std::uint8_t, kRenderCommandBytes> in) {
  RenderCommand command;
  command.width = load<std::uint16_t>(in, 4);
  command.height = load<std::uint16_t>(in, 6);
  command.projection = static_cast<Projection>(load<std::uint8_t>(in, 8));
  command.samples_per_axis = load<std::uint8_t>(in, 9);
  command.filter = static_cast<Filter>(load<std::uint8_t>(in, 10));
  const std::array<std::array<double, 3>*, 4> vectors{&command.origin, &command.forward, &command.du, &command.dv};
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) (*vectors[i])[axis] = load_double(in, 16 + 24 * i + 8 * axis);
  }
  return command;
}

}  // namespace gicube::wire
