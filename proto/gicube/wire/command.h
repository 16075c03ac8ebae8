// DSP commands: the payload of kCommand frames, and of the completions that answer them. README.md has their bytes.
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

// By opcode, for counters and traces; what is no opcode is called as the first.
inline constexpr std::array<const char*, 11> kOpcodeNames{"render",    "render",    "trace",      "illuminate",
                                                          "resume",    "verify",    "pairs",      "continue",
                                                          "take rays", "give rays", "load coarse"};

// ---- kRender: the DSP makes the viewing rays of one image and gathers them in the framebuffer. Its completion is empty, or a
// trap list without rays if some of its rays wait for the host.

enum class Projection : std::uint8_t { kOrthographic = 0, kPerspective = 1 };
enum class Filter : std::uint8_t { kBox = 0, kTent = 1 };  // kTent: two pixels wide

inline constexpr int kMaxImageSize = 4095;  // u, v are 12.4 pixels

// Image point (x, y), pixels from the image's top left corner:
//   perspective   origin = origin,                 direction = forward + x du + y dv
//   orthographic  origin = origin + x du + y dv,   direction = forward
// The DSP checks every field's range and names the one that is wrong; so it does with all commands.
//
// `lamps` records of Lamp follow. They are what scattered rays see: a ray that was scattered and leaves the volume takes the colour
// of the nearest lamp in its way, times what it still lets through, and is opaque then. Other rays see no lamps, and no ray sees
// one within the volume, since it is tested from where it leaves on.
struct RenderCommand {
  std::uint16_t width = 0;  // pixels
  std::uint16_t height = 0;
  Projection projection = Projection::kPerspective;
  std::uint8_t samples_per_axis = 1;  // 1, 2 or 4: rays per pixel are its square
  Filter filter = Filter::kBox;
  std::uint8_t lamps = 0;  // records behind the command, at most kMaxLamps
  // A card makes part `part` of the picture's `parts`: strips of `strip_rows` rows from the top are dealt to the parts in turn. The
  // framebuffer has the part's rows, one below the other. 0 parts: the whole picture, and the two others are 0.
  std::uint16_t strip_rows = 0;
  std::uint8_t part = 0;
  std::uint8_t parts = 0;
  std::array<double, 3> origin{};  // voxels, as all below
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

// Rows of pixels that a card makes for a command that it takes.
constexpr int rows_of(const RenderCommand& command) {
  if (command.parts == 0) return command.height;
  const int strip = command.strip_rows, period = strip * command.parts;
  return command.height / period * strip + std::clamp(command.height % period - command.part * strip, 0, strip);
}

// ---- kTrace: host rays in, host rays out in its completion, in the order in which they were sent. A TraceHeader, then `count`
// ray packets (ray.h) with the flag kHostRay alone; of deposit also kLightingRay, and kHighAlbedo as `albedo`.
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
// After a command each sum is within +-(2^34 - 1), and what is beyond is clipped and counted. Within a command it can't
// leave its 36 bits: a command whose rays could move a word by more than 2^34 is refused, by the sum of max_moved().

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
enum class SumWords : std::uint8_t { kIrradiance = 0, kWhole = 1 };  // kWhole: sums, all 36 bits of a voxel's word
enum class Albedo : std::uint8_t { kLow = 0, kHigh = 1 };
enum class EnergyRules : std::uint8_t { kAsPrinted = 0, kConserving = 1 };

inline constexpr std::int32_t kMaxAmount = (1 << 23) - 1;             // that a sample leaves
inline constexpr int kAmountFractionBits = 12;                        // in irradiance words
inline constexpr std::int64_t kMaxSum = (std::int64_t{1} << 34) - 1;  // between commands
inline constexpr std::uint32_t kMaxLength = 4096u << 16;  // of a segment, 16.16 voxels: beyond any volume's diagonal

struct TraceHeader {
  std::uint32_t count = 0;
  RayType type = RayType::kIntegrate;
  Albedo albedo = Albedo::kLow;                 // of deposit; else 0
  EnergyRules rules = EnergyRules::kAsPrinted;  // the same
  SumWords words = SumWords::kIrradiance;       // of backproject; else 0
  std::uint32_t opacity = 0;  // 24 bits, 2^24 - 1 = 1, not 0: at which a first hit, segment or opacity ray ends; else 0

  constexpr void fields(auto&& list) { list(Opcode::kTrace, count, type, albedo, rules, words, opacity); }
  friend constexpr bool operator==(const TraceHeader&, const TraceHeader&) = default;
};
inline constexpr std::size_t kTraceHeaderBytes = bytes_of<TraceHeader>();

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

  constexpr void fields(auto&& list) { list(rays, samples, kept, clipped, overflowed); }
  friend constexpr bool operator==(const DepositLedger&, const DepositLedger&) = default;
};
inline constexpr std::size_t kDepositLedgerBytes = bytes_of<DepositLedger>();

// ---- kIlluminate: the DSP makes the lighting rays of one light; they leave their energy in the irradiance words. Its
// completion holds a LightingLedger, and then as kRender's.

enum class LightKind : std::uint8_t { kPoint = 0, kDirectional = 1, kRectangle = 2, kSphere = 3 };

inline constexpr std::uint32_t kMaxRaysPerVoxel = 4096;

// The volume's faces: x = 0, x = size - 1, y = 0, and so on. A ray that leaves across an edge or a corner leaves by the face
// whose plane it crosses first; if it crosses several at once, by that of the first axis.
inline constexpr std::size_t kFaces = 6;

struct IlluminateCommand {
  LightKind kind = LightKind::kPoint;
  Albedo albedo = Albedo::kLow;
  EnergyRules rules = EnergyRules::kConserving;
  std::uint32_t rays_per_voxel = 1;  // k: rays a face voxel of the whole pass
  std::uint32_t first = 0;           // of those k, this command sends first .. first + count - 1
  std::uint32_t count = 1;
  // The light's power, directional: irradiance; units of the energy words, physical lengths in those of the SPACING registers.
  double energy = 0;
  // point: position (voxels). directional: u is towards the light. rectangle: position is a corner, u and v its edges
  // (physical), it shines along u x v. sphere: position is the centre, u[0] the radius (physical).
  std::array<double, 3> position{}, u{}, v{};

  constexpr void fields(auto&& list) {
    list(Opcode::kIlluminate, kind, albedo, rules, Reserved<1>{}, rays_per_voxel, first, count, Reserved<4>{}, energy,
         position, u, v);
  }
  friend constexpr bool operator==(const IlluminateCommand&, const IlluminateCommand&) = default;
};
inline constexpr std::size_t kIlluminateCommandBytes = bytes_of<IlluminateCommand>();

// What scattered rays of a render command see. kRectangle: `position` is a corner, u and v its edges; it is seen from the side of u x v.
// kSphere: `position` is the centre, u[0] the radius; it is seen from outside. Units as above.
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
  std::array<std::uint64_t, kFaces> escaped_by_face{};  // sum to `escaped`

  constexpr void fields(auto&& list) {
    list(rays, emitted, deposited, escaped, scattered_away, given_up, clipped, light_in_solid, escaped_by_face);
  }
  friend constexpr bool operator==(const LightingLedger&, const LightingLedger&) = default;
};
inline constexpr std::size_t kLightingLedgerBytes = bytes_of<LightingLedger>();

// What several commands did, as one.
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

// What a session of that minor version has of a ledger: before 2.2 it ends without `escaped_by_face`, which are 0 then.
inline constexpr std::uint16_t kEscapedByFaceMinor = 2;
constexpr std::size_t lighting_ledger_bytes(std::uint16_t minor) {
  return minor < kEscapedByFaceMinor ? kLightingLedgerBytes - 8 * kFaces : kLightingLedgerBytes;
}
inline LightingLedger decode_lighting_ledger(std::span<const std::uint8_t> bytes, std::uint16_t minor) {
  std::array<std::uint8_t, kLightingLedgerBytes> whole{};
  std::ranges::copy(bytes.first(lighting_ledger_bytes(minor)), whole.begin());
  return decode<LightingLedger>(whole);
}

// ---- kResume: answers for rays of the last kRender or kIlluminate that wait for the host (routine 255), which go on from where
// they trapped; and asks for more of them. Registers, tables and volume must be as they were. The next kRender or
// kIlluminate forgets the rays that still wait. A ResumeHeader, then `count` ray packets as trap.h says.
//
// Its completion: after a kIlluminate first a LightingLedger of what these rays did, `emitted` being the energy that they
// brought back and `rays` those that came to an end; then a trap list: a TrapListHeader, then `count` trapped rays (trap.h),
// those of one command by their (v, u).

struct ResumeHeader {
  std::uint32_t count = 0;     // at most as many as were handed out and not answered
  std::uint32_t max_rays = 0;  // that the completion may hold

  constexpr void fields(auto&& list) { list(Opcode::kResume, count, max_rays, Reserved<4>{}); }
};
inline constexpr std::size_t kResumeHeaderBytes = bytes_of<ResumeHeader>();

struct TrapListHeader {
  std::uint32_t count = 0;    // rays that follow
  std::uint32_t waiting = 0;  // rays that still wait on the board

  constexpr void fields(auto&& list) { list(count, waiting); }
};
inline constexpr std::size_t kTrapListHeaderBytes = bytes_of<TrapListHeader>();

// ---- kVerify: reads blocks of the volume's memory back and sums them up; of the blocks first .. first + count - 1 that are
// stored each is read once. Its completion: u32 CRC-32C of each block's n^3 packed words (memory_map.h), those of a block
// that was never written being zero.

inline constexpr std::uint32_t kMaxVerifyBlocks = 65'536;  // chosen: their sums fit the smallest usual payload limit

struct VerifyCommand {
  std::uint32_t first = 0;
  std::uint32_t count = 0;  // 1..kMaxVerifyBlocks

  constexpr void fields(auto&& list) { list(Opcode::kVerify, first, count, Reserved<4>{}); }
};
inline constexpr std::size_t kVerifyCommandBytes = bytes_of<VerifyCommand>();

// ---- kPairs: the DSP makes rays between elements (pair.h), traces them as opacity rays, and sums them up. A PairsHeader, its
// elements, its pairs; rays of all pairs at most kMaxPairRays. Its completion: a PairResult for each pair.

// ---- kContinue: rays that wait for blocks which are no longer absent go on. Registers and tables must be as they were.
//
// A ray waits when it comes to a block whose flag of absent_flags (memory_map.h) is set, unless it leaps over the block. A ray that
// traps waits for the block of its place, leapt over or not. It goes on with all its bits. Rays wait of kRender, and of kTrace and
// kIlluminate if the volume has more blocks than the card stores; other commands are refused while a flag is set. The completion of
// these and of kContinue ends with a WaitingHeader and `blocks` WaitingBlocks, ascending, or with nothing if no ray waits and the host
// has nothing to deposit.
// No material may let the host scatter then.
//
// The rays of such a kTrace stay in the DSP's memory (kHostRayMemory, memory_map.h) behind those of the kTraces before with the same
// header but for `count`, at most kMaxHostRays, and its completion holds no rays; those of deposit do not stay. When none waits,
// all have come to their ends there. kBackproject is refused.
//
// Energy that goes to a block whose flag of dark_flags is set, since the host has its irradiance, is neither deposited nor clipped: the
// command's completion counts the voxels that got some, and the host reads them from host_deposits before the next command, and
// adds them to its words. So in all commands of a light, with what the host has deposited and clipped besides, the ledgers' sums
// are those of a card that stores the whole volume. The ledger of kContinue has emitted nothing; its `rays` are those that came to an end.
//
// The next kRender, kIlluminate or kTrace with another header, and bit 5 of CONTROL, forget all these rays.

inline constexpr std::uint16_t kBricksMinor = 3;  // the first minor version with it

struct ContinueCommand {
  constexpr void fields(auto&& list) { list(Opcode::kContinue, Reserved<4>{}); }
};
inline constexpr std::size_t kContinueCommandBytes = bytes_of<ContinueCommand>();

struct WaitingHeader {
  std::uint32_t blocks = 0;         // that rays wait for
  std::uint32_t rays = 0;           // in all
  std::uint32_t host_deposits = 0;  // records, of this command

  constexpr void fields(auto&& list) { list(blocks, rays, host_deposits, Reserved<4>{}); }
};
inline constexpr std::size_t kWaitingHeaderBytes = bytes_of<WaitingHeader>();

struct WaitingBlock {
  std::uint32_t block = 0;
  std::uint32_t rays = 0;        // that wait for it, not 0
  std::uint64_t importance = 0;  // the sum of their contributions, 12 bits each, as the sorter counts them

  constexpr void fields(auto&& list) { list(block, rays, importance); }
  friend constexpr bool operator==(const WaitingBlock&, const WaitingBlock&) = default;
};
inline constexpr std::size_t kWaitingBlockBytes = bytes_of<WaitingBlock>();

struct HostDeposit {
  std::uint64_t word = 0;   // of the irradiance: block * n^3 + voxel of the block, x fastest
  std::uint64_t units = 0;  // to be added; the word saturates

  constexpr void fields(auto&& list) { list(word, units); }
  friend constexpr bool operator==(const HostDeposit&, const HostDeposit&) = default;
};
inline constexpr std::size_t kHostDepositBytes = bytes_of<HostDeposit>();

}  // namespace gicube::wire
