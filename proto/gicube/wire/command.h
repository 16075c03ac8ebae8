// DSP commands: payloads of kCommand frames and of their completions. README.md defines the bytes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "gicube/wire/record.h"

namespace gicube::wire {

enum class Opcode : std::uint32_t {
  kRender = 1,
  kTrace = 2,
  kIlluminate = 3,
  kResume = 4,
  kVerify = 5,
  kPairs = 6,
  kContinue = 7,
  kTakeRays = 8,
  kGiveRays = 9,
  kLoadCoarse = 10
};

// Names by opcode, for counters and traces. Unknown opcodes use the first name.
inline constexpr std::array<const char*, 11> kOpcodeNames{"render",    "render",    "trace",      "illuminate",
                                                          "resume",    "verify",    "pairs",      "continue",
                                                          "take rays", "give rays", "load coarse"};

// ---- kRender: the DSP generates the viewing rays of one image and accumulates them in the framebuffer. The completion
// is empty, or a trap list without rays if some rays wait for the host.

enum class Projection : std::uint8_t { kOrthographic = 0, kPerspective = 1 };
enum class Filter : std::uint8_t { kBox = 0, kTent = 1 };  // kTent: two pixels wide

inline constexpr int kMaxImageSize = 4095;  // u, v are 12.4 pixels

// Image point (x, y), pixels from the image's top left corner:
//   perspective   origin = origin,                 direction = forward + x du + y dv
//   orthographic  origin = origin + x du + y dv,   direction = forward
// The DSP checks the range of every field and reports the faulty one. This holds for all commands.
//
// `lamps` records of type Lamp follow. Scattered rays can hit them: a scattered ray that leaves the volume gets the
// colour of the nearest lamp along it, multiplied by the remaining transmittance, and becomes opaque. Other rays do not
// hit lamps. A lamp within the volume is never hit, because the test begins where the ray leaves the volume.
struct RenderCommand {
  std::uint16_t width = 0;  // pixels
  std::uint16_t height = 0;
  Projection projection = Projection::kPerspective;
  std::uint8_t samples_per_axis = 1;  // 1, 2 or 4; there are samples_per_axis^2 rays per pixel
  Filter filter = Filter::kBox;
  std::uint8_t lamps = 0;  // number of Lamp records after the command, at most kMaxLamps
  // The card renders part `part` of the image's `parts`. Strips of `strip_rows` rows, from the top, are assigned to the
  // parts in turn. The framebuffer holds the rows of this part without gaps. If `parts` is 0, the card renders the
  // whole image, and the other two are 0.
  std::uint16_t strip_rows = 0;
  std::uint8_t part = 0;
  std::uint8_t parts = 0;
  std::array<double, 3> origin{};  // voxels, like all below
  std::array<double, 3> forward{};
  std::array<double, 3> du{};
  std::array<double, 3> dv{};

  constexpr void fields(auto&& list) {
    list(Opcode::kRender, width, height, projection, samples_per_axis, filter, lamps, strip_rows, part, parts, origin,
         forward, du, dv);
  }
  friend constexpr bool operator==(const RenderCommand&, const RenderCommand&) = default;
};
inline constexpr std::size_t kRenderCommandBytes = bytes_of<RenderCommand>();

// Number of pixel rows that a card renders for a valid command.
constexpr int rows_of(const RenderCommand& command) {
  if (command.parts == 0) return command.height;
  const int strip = command.strip_rows, period = strip * command.parts;
  return command.height / period * strip + std::clamp(command.height % period - command.part * strip, 0, strip);
}

// ---- kTrace: traces rays from the host. The completion returns them in the order in which they were sent. The payload
// is a TraceHeader, then `count` ray packets (ray.h) with only the flag kHostRay; deposit rays also have kLightingRay,
// and kHighAlbedo according to `albedo`.
//
// The 36 colour bits of a ray packet sent to the board:
//   integrate         colour that the ray has already gathered, 3 x 12 bits
//   first hit         the same; it does not change
//   segment, opacity  low 32 bits: length, 16.16 voxels, at most 4096; the other bits are 0. These rays start with no
//                     opacity.
//   deposit           energy, 24.12 units of the energy words, not 0; at most 255 units of low albedo, 15 of high,
//                     2^24 - 1 on the wide datapath
//   integral          length, as for a segment
//   backproject       length, as for a segment; the opacity's 24 bits are the amount that each sample adds: to
//                     irradiance words in 11.12 units, not negative; to accumulators in signed whole units, at least
//                     -(2^23 - 1)
// A segment's step divides its length evenly and is at most STEP. Segments do not use contribution, lifetime,
// generation and interaction: on the ASIC these 38 bits hold the number of remaining steps and their length. First-hit
// and opacity rays return no colour. For integral rays, the colour's 36 bits are the sum of the samples' densities,
// 12.3 each, and the opacity is 0. They do not skip empty blocks, which may have density. They take at most 2^18
// samples of 2^15: 33 bits. Deposit and backproject return no rays. Their completions are a LightingLedger and a
// DepositLedger.
//
// Backprojection does not change its rays. Each sample adds the ray's amount, distributed over the eight voxels around
// it: to irradiance words with systematic rounding and saturation, like a deposit; to accumulators by repeated halving
// (board_emu/datapath/trilinear_splat.h). After a command each accumulator is limited to +-(2^34 - 1), and the excess
// is counted as clipped. Within a command an accumulator cannot exceed its 36 bits, because a command is refused if the
// sum of max_moved() over its rays is above 2^34.

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
constexpr bool is_one_of(RayType type) {  // a mask, because it is called for each sample
  return (((1u << static_cast<unsigned>(kTypes)) | ...) >> static_cast<unsigned>(type) & 1) != 0;
}
// Segments run between two points and have a length in the packet.
constexpr bool is_segment(RayType type) {
  return is_one_of<RayType::kSegment, RayType::kOpacity, RayType::kIntegral, RayType::kBackproject>(type);
}
// These rays end at the sample at which they reach the requested opacity.
constexpr bool has_threshold(RayType type) {
  return is_one_of<RayType::kFirstHit, RayType::kSegment, RayType::kOpacity>(type);
}
enum class SumWords : std::uint8_t { kIrradiance = 0, kWhole = 1 };  // kWhole: accumulators of 36 bits
enum class Albedo : std::uint8_t { kLow = 0, kHigh = 1 };
enum class EnergyRules : std::uint8_t { kAsPrinted = 0, kConserving = 1 };

inline constexpr std::int32_t kMaxAmount = (1 << 23) - 1;             // per sample
inline constexpr int kAmountFractionBits = 12;                        // for irradiance words
inline constexpr std::int64_t kMaxSum = (std::int64_t{1} << 34) - 1;  // between commands
inline constexpr std::uint32_t kMaxLength = 4096u << 16;              // 16.16 voxels: exceeds any volume's diagonal

struct TraceHeader {
  std::uint32_t count = 0;
  RayType type = RayType::kIntegrate;
  Albedo albedo = Albedo::kLow;                 // of deposit; otherwise 0
  EnergyRules rules = EnergyRules::kAsPrinted;  // of deposit; otherwise 0
  SumWords words = SumWords::kIrradiance;       // of backproject; otherwise 0
  std::uint32_t opacity = 0;  // 24 bits, 2^24 - 1 = 1: end of first-hit, segment and opacity rays, not 0; otherwise 0

  constexpr void fields(auto&& list) { list(Opcode::kTrace, count, type, albedo, rules, words, opacity); }
  friend constexpr bool operator==(const TraceHeader&, const TraceHeader&) = default;
};
inline constexpr std::size_t kTraceHeaderBytes = bytes_of<TraceHeader>();

// Number of steps of a segment of `length`, both 16.16 voxels. Each step is at most `step`.
constexpr std::uint32_t steps_of(std::uint32_t length, std::uint32_t step) { return (length + step - 1) / step; }

// The maximum that a backprojecting ray can add to one word. The samples that are less than a voxel from a point on
// every axis lie on a piece of the ray that is shorter than 2 sqrt(3) voxels. The weights on such a piece add up to no
// more than this.
constexpr std::uint64_t max_moved(std::uint32_t amount_size, std::uint32_t length, std::uint32_t step) {
  const std::uint32_t steps = steps_of(length, step);
  if (steps == 0) return 0;
  const std::uint32_t each = length / steps;
  const std::uint64_t weight = each == 0 ? steps : 3 + (2u << 16) / each;
  return std::uint64_t{amount_size} * (weight < steps ? weight : steps);
}

// Result of a backprojection in units of its words. The total amount added is kept + clipped.
struct DepositLedger {
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;     // all samples, including those of rays with amount 0
  std::int64_t kept = 0;         // added to the words, each voxel counted once
  std::int64_t clipped = 0;      // lost in full words; for accumulators signed, like the excess
  std::uint64_t overflowed = 0;  // accumulators that were clipped after the command

  constexpr void fields(auto&& list) { list(rays, samples, kept, clipped, overflowed); }
  friend constexpr bool operator==(const DepositLedger&, const DepositLedger&) = default;
};
inline constexpr std::size_t kDepositLedgerBytes = bytes_of<DepositLedger>();

// ---- kIlluminate: the DSP generates the lighting rays of one light, which deposit their energy in the irradiance
// words. The completion is a LightingLedger, followed by the data of kRender's completion.

enum class LightKind : std::uint8_t { kPoint = 0, kDirectional = 1, kRectangle = 2, kSphere = 3 };

inline constexpr std::uint32_t kMaxRaysPerVoxel = 4096;

// The volume's faces: x = 0, x = size - 1, y = 0, and so on. A ray that leaves across an edge or a corner is assigned
// to the face whose plane it crosses first. If it crosses several at once, the face of the first axis counts.
inline constexpr std::size_t kFaces = 6;

struct IlluminateCommand {
  LightKind kind = LightKind::kPoint;
  Albedo albedo = Albedo::kLow;
  EnergyRules rules = EnergyRules::kConserving;
  std::uint32_t rays_per_voxel = 1;  // k: rays per face voxel in the whole pass
  std::uint32_t first = 0;           // of those k, this command sends rays first .. first + count - 1
  std::uint32_t count = 1;
  // Power of the light, or irradiance of a directional one, in units of the energy words. Physical lengths are in the
  // unit of the SPACING registers.
  double energy = 0;
  // point: position (voxels). directional: u points towards the light. rectangle: position is a corner, u and v are the
  // edges (physical); it shines along u x v. sphere: position is the centre, u[0] the radius (physical).
  std::array<double, 3> position{}, u{}, v{};

  constexpr void fields(auto&& list) {
    list(Opcode::kIlluminate, kind, albedo, rules, Reserved<1>{}, rays_per_voxel, first, count, Reserved<4>{}, energy,
         position, u, v);
  }
  friend constexpr bool operator==(const IlluminateCommand&, const IlluminateCommand&) = default;
};
inline constexpr std::size_t kIlluminateCommandBytes = bytes_of<IlluminateCommand>();

// Light sources that scattered rays of a render command can hit. kRectangle: `position` is a corner, u and v are the
// edges; it is visible from the side of u x v. kSphere: `position` is the centre, u[0] the radius; it is visible from
// outside. Units as above.
inline constexpr std::size_t kMaxLamps = 32;  // chosen: their records in the DSP's tables fill half of its data cache
inline constexpr std::uint16_t kLampsMinor = 3;
inline constexpr std::uint16_t kPartsMinor = 3;  // RenderCommand::parts
struct Lamp {
  LightKind kind = LightKind::kRectangle;
  std::array<std::uint32_t, 3> colour{};  // 16.16, 65536 = full colour
  std::array<double, 3> position{}, u{}, v{};

  constexpr void fields(auto&& list) { list(kind, Reserved<3>{}, colour, position, u, v); }
  friend constexpr bool operator==(const Lamp&, const Lamp&) = default;
};
inline constexpr std::size_t kLampBytes = bytes_of<Lamp>();

// Energy balance of a lighting command, in units of the energy words:
// emitted = deposited + escaped + scattered_away + clipped + the energy of rays that wait for the host (trap.h).
struct LightingLedger {
  std::uint64_t rays = 0;
  std::uint64_t emitted = 0;
  std::uint64_t deposited = 0;       // added to irradiance words, each voxel counted once
  std::uint64_t escaped = 0;         // left the volume
  std::uint64_t scattered_away = 0;  // lost by the printed rules, with abandoned rays, or in routines
  std::uint64_t given_up = 0;        // part of scattered_away: lost at the end of a ray's lifetime
  std::uint64_t clipped = 0;         // lost in saturated irradiance words
  std::uint64_t light_in_solid = 0;  // 1: the voxels at the light's position are opaque
  std::array<std::uint64_t, kFaces> escaped_by_face{};  // sum to `escaped`

  constexpr void fields(auto&& list) {
    list(rays, emitted, deposited, escaped, scattered_away, given_up, clipped, light_in_solid, escaped_by_face);
  }
  friend constexpr bool operator==(const LightingLedger&, const LightingLedger&) = default;
};
inline constexpr std::size_t kLightingLedgerBytes = bytes_of<LightingLedger>();

// Adds the ledger of one command to the sum of several.
inline void add(const LightingLedger& ledger, LightingLedger& sum) {
  sum.rays += ledger.rays;
  sum.emitted += ledger.emitted;
  sum.deposited += ledger.deposited;
  sum.escaped += ledger.escaped;
  sum.scattered_away += ledger.scattered_away;
  sum.given_up += ledger.given_up;
  sum.clipped += ledger.clipped;
  sum.light_in_solid |= ledger.light_in_solid;
  for (std::size_t face = 0; face < kFaces; ++face) sum.escaped_by_face[face] += ledger.escaped_by_face[face];
}

// Size of a ledger in a session of this minor version. Before 2.2 it has no `escaped_by_face`, which are then decoded
// as 0.
inline constexpr std::uint16_t kEscapedByFaceMinor = 2;
constexpr std::size_t lighting_ledger_bytes(std::uint16_t minor) {
  return minor < kEscapedByFaceMinor ? kLightingLedgerBytes - 8 * kFaces : kLightingLedgerBytes;
}
inline LightingLedger decode_lighting_ledger(std::span<const std::uint8_t> bytes, std::uint16_t minor) {
  std::array<std::uint8_t, kLightingLedgerBytes> whole{};
  std::ranges::copy(bytes.first(lighting_ledger_bytes(minor)), whole.begin());
  return decode<LightingLedger>(whole);
}

// ---- kResume: returns host answers for rays of the last kRender or kIlluminate that wait for the host (routine 255),
// and requests more such rays. The answered rays continue from where they trapped. Registers, tables and volume must be
// unchanged. The next kRender or kIlluminate discards the rays that still wait. The payload is a ResumeHeader, then
// `count` ray packets (trap.h).
//
// The completion after a kIlluminate begins with a LightingLedger of these rays: `emitted` is the energy that they
// brought back, and `rays` the number that ended. Then follows a trap list: a TrapListHeader and `count` trapped rays
// (trap.h), in the order of their (v, u) within a command.

struct ResumeHeader {
  std::uint32_t count = 0;     // at most the number of rays handed out and not yet answered
  std::uint32_t max_rays = 0;  // maximum number of rays in the completion

  constexpr void fields(auto&& list) { list(Opcode::kResume, count, max_rays, Reserved<4>{}); }
};
inline constexpr std::size_t kResumeHeaderBytes = bytes_of<ResumeHeader>();

struct TrapListHeader {
  std::uint32_t count = 0;    // rays that follow
  std::uint32_t waiting = 0;  // rays that still wait on the board

  constexpr void fields(auto&& list) { list(count, waiting); }
};
inline constexpr std::size_t kTrapListHeaderBytes = bytes_of<TrapListHeader>();

// ---- kVerify: reads stored blocks of the volume back and computes their checksums. Of the blocks first .. first +
// count - 1, each stored one is read once. The completion has a u32 CRC-32C for each block's n^3 packed words
// (memory_map.h). The words of a block that was never written are zero.

inline constexpr std::uint32_t kMaxVerifyBlocks = 65'536;  // chosen: their sums fit the smallest usual payload limit

struct VerifyCommand {
  std::uint32_t first = 0;
  std::uint32_t count = 0;  // 1..kMaxVerifyBlocks

  constexpr void fields(auto&& list) { list(Opcode::kVerify, first, count, Reserved<4>{}); }
};
inline constexpr std::size_t kVerifyCommandBytes = bytes_of<VerifyCommand>();

// ---- kPairs: the DSP generates rays between elements (pair.h), traces them as opacity rays and sums up the results.
// The payload is a PairsHeader, the elements and the pairs. All pairs together have at most kMaxPairRays rays. The
// completion is a PairResult for each pair.

// ---- kContinue: continues rays that waited for blocks which are no longer absent. Registers and tables must be
// unchanged.
//
// A ray waits when it enters a block whose flag in absent_flags (memory_map.h) is set, unless it skips the block. A ray
// that traps waits for the block at its position, skipped or not. It later continues with all its bits. Rays of kRender
// can wait; rays of kTrace and kIlluminate only if the volume has more blocks than the card stores. Other commands are
// refused while a flag is set. The completions of these commands and of kContinue end with a WaitingHeader and `blocks`
// WaitingBlocks, ascending, or with nothing if no ray waits and the host has nothing to deposit. Materials that the
// host scatters are not allowed here.
//
// The rays of such a kTrace are kept in the DSP's memory (kHostRayMemory, memory_map.h), after those of earlier kTraces
// with the same header except for `count`, at most kMaxHostRays. The completion holds no rays. Deposit rays are not
// kept. When no ray waits, all of them have reached their end there. kBackproject is refused.
//
// If a block's flag in dark_flags is set, the host holds its irradiance. Energy for such a block is neither deposited
// nor clipped. The completion counts the voxels that received some. The host reads these deposits from host_deposits
// before the next command and adds them to its own words. So over all commands of a light, together with the host's
// deposits and clipped energy, the ledgers add up to those of a card that stores the whole volume. The ledger of
// kContinue has emitted nothing; its `rays` are those that ended.
//
// The next kRender or kIlluminate, a kTrace with another header, and bit 5 of CONTROL discard all these rays.

inline constexpr std::uint16_t kBricksMinor = 3;  // the first minor version that supports it

struct ContinueCommand {
  constexpr void fields(auto&& list) { list(Opcode::kContinue, Reserved<4>{}); }
};
inline constexpr std::size_t kContinueCommandBytes = bytes_of<ContinueCommand>();

struct WaitingHeader {
  std::uint32_t blocks = 0;         // number of WaitingBlocks
  std::uint32_t rays = 0;           // total number of waiting rays
  std::uint32_t host_deposits = 0;  // records of this command

  constexpr void fields(auto&& list) { list(blocks, rays, host_deposits, Reserved<4>{}); }
};
inline constexpr std::size_t kWaitingHeaderBytes = bytes_of<WaitingHeader>();

struct WaitingBlock {
  std::uint32_t block = 0;
  std::uint32_t rays = 0;        // rays that wait for this block, not 0
  std::uint64_t importance = 0;  // sum of their contributions, 12 bits each, as the sorter counts them

  constexpr void fields(auto&& list) { list(block, rays, importance); }
  friend constexpr bool operator==(const WaitingBlock&, const WaitingBlock&) = default;
};
inline constexpr std::size_t kWaitingBlockBytes = bytes_of<WaitingBlock>();

struct HostDeposit {
  std::uint64_t word = 0;   // index of the irradiance word: block * n^3 + voxel in the block, x fastest
  std::uint64_t units = 0;  // amount to add; the word saturates

  constexpr void fields(auto&& list) { list(word, units); }
  friend constexpr bool operator==(const HostDeposit&, const HostDeposit&) = default;
};
inline constexpr std::size_t kHostDepositBytes = bytes_of<HostDeposit>();

}  // namespace gicube::wire
