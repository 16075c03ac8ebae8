// The register table of BAR0, shared by driver, board, tests and docs/reference/protocol.md.
//
// Registers are 32 bits wide and lie at multiples of 4. Reads of unmapped addresses return all ones. Writes to unmapped
// or read-only addresses set STATUS.bad_address and change nothing else. Values out of range set STATUS.bad_value. A
// write that is refused for lack of memory sets STATUS.no_memory, together with bad_address or bad_value.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace gicube::wire {

enum class Access : std::uint8_t { kReadOnly, kReadWrite, kWriteOnly };

// If the value of a read-only register comes from the configuration, `reset` is 0 and `meaning` says so.
struct RegisterInfo {
  std::uint32_t offset;
  std::string_view name;
  Access access;
  std::uint32_t reset;
  std::string_view meaning;
};

namespace reg {
inline constexpr std::uint32_t kId = 0x000;
inline constexpr std::uint32_t kStatus = 0x004;
inline constexpr std::uint32_t kStatusClear = 0x008;
inline constexpr std::uint32_t kControl = 0x00C;
inline constexpr std::uint32_t kErrorAddress = 0x010;
inline constexpr std::uint32_t kDatapath = 0x014;
inline constexpr std::uint32_t kMaxMemory = 0x018;
inline constexpr std::uint32_t kMemoryAsked = 0x01C;
inline constexpr std::uint32_t kFidelity = 0x020;
inline constexpr std::uint32_t kProcessors = 0x024;
inline constexpr std::uint32_t kBlockVoxels = 0x028;
inline constexpr std::uint32_t kMaxVolumeVoxels = 0x02C;
inline constexpr std::uint32_t kQueueRays = 0x030;
inline constexpr std::uint32_t kCoreKhz = 0x034;
inline constexpr std::uint32_t kConfigHashLow = 0x038;
inline constexpr std::uint32_t kConfigHashHigh = 0x03C;
inline constexpr std::uint32_t kVolumeX = 0x040;
inline constexpr std::uint32_t kVolumeY = 0x044;
inline constexpr std::uint32_t kVolumeZ = 0x048;
inline constexpr std::uint32_t kVoxelFormat = 0x04C;
inline constexpr std::uint32_t kSpacingX = 0x050;
inline constexpr std::uint32_t kSpacingY = 0x054;
inline constexpr std::uint32_t kSpacingZ = 0x058;
inline constexpr std::uint32_t kStep = 0x060;
inline constexpr std::uint32_t kOpacityThreshold = 0x064;
inline constexpr std::uint32_t kPipeline = 0x068;
inline constexpr std::uint32_t kLifetime = 0x06C;
inline constexpr std::uint32_t kExposure = 0x070;
inline constexpr std::uint32_t kSeed = 0x074;
inline constexpr std::uint32_t kIrradianceWords = 0x078;
inline constexpr std::uint32_t kCutPlanes = 0x080;
inline constexpr std::uint32_t kDropBlock = 0x084;
inline constexpr std::uint32_t kBricks = 0x088;
inline constexpr std::uint32_t kCutPlane0 = 0x090;  // plane i, word w at kCutPlane0 + 16 i + 4 w
inline constexpr std::uint32_t kLightRed = 0x100;   // green and blue follow
inline constexpr std::uint32_t kLightGreen = 0x104;
inline constexpr std::uint32_t kLightBlue = 0x108;
}  // namespace reg

inline constexpr std::uint32_t kIdValue = 0x42434947;  // "GICB"
inline constexpr std::uint32_t kUnmappedRead = 0xFFFF'FFFF;
inline constexpr std::uint32_t kMaxCutPlanes = 6;
inline constexpr std::uint32_t kMaxVolumeEdge = 1024;  // voxels: limit of the memory map and of a position's bits

enum StatusBit : std::uint32_t {
  kStatusBadAddress = 1 << 0,
  kStatusBadValue = 1 << 1,
  kStatusBadCommand = 1 << 2,
  kStatusMemory = 1 << 3,
  kStatusNoMemory = 1 << 4,
};
enum ControlBit : std::uint32_t {
  kControlReset = 1 << 0,
  kControlClearVolume = 1 << 1,
  kControlClearIrradiance = 1 << 2,
  kControlClearSums = 1 << 3,
  kControlDropBlocks = 1 << 4,
  kControlDropRays = 1 << 5,
};
enum PipelineBit : std::uint32_t {
  kPipelineJitter = 1 << 0,
  kPipelineShade = 1 << 1,
  kPipelineLeap = 1 << 2,
  kPipelineIrradiance = 1 << 3,
  kPipelineScatter = 1 << 4,
  kPipelineHighAlbedo = 1 << 5,
  kPipelineCutFaces = 1 << 6,
};
inline constexpr std::uint32_t kPipelineBits = (1 << 7) - 1;
inline constexpr std::uint16_t kCutFacesMinor = 3;  // kPipelineCutFaces
enum class Fidelity : std::uint32_t { kFunctional = 1, kApproximate = 2, kCycle = 3 };

enum class Datapath : std::uint32_t { kPaper = 1, kWide = 2 };

inline constexpr std::uint32_t kStepOne = 1u << 16;       // STEP of one voxel
inline constexpr std::uint32_t kStepMin = kStepOne / 64;  // below it a step's fixed-point error exceeds 1% (HARDWARE)
inline constexpr std::uint32_t kStepMax = 16 * kStepOne;
inline constexpr std::uint32_t kLifetimeReset = 32;
inline constexpr std::uint32_t kLightColourReset = 65535;
inline constexpr std::uint32_t kExposureReset = 256;  // 256 units of irradiance: full colour
inline constexpr std::uint32_t kSpacingOne = 1u << 16;
inline constexpr std::uint32_t kSpacingMax = 64 * kSpacingOne;

inline constexpr std::array kRegisterTable{
    RegisterInfo{reg::kId, "ID", Access::kReadOnly, kIdValue, "\"GICB\""},
    RegisterInfo{reg::kStatus, "STATUS", Access::kReadOnly, 0,
                 "sticky: bit 0 bad_address, 1 bad_value, 2 bad_command, 3 memory_error, 4 no_memory"},
    RegisterInfo{reg::kStatusClear, "STATUS_CLEAR", Access::kWriteOnly, 0, "ones clear these bits of STATUS"},
    RegisterInfo{reg::kControl, "CONTROL", Access::kWriteOnly, 0,
                 "ones: bit 0 reset, 1 clear volume, 2 clear irradiance, 3 clear sums, 4 drop blocks, 5 drop waiting "
                 "rays (P1150)"},
    RegisterInfo{reg::kErrorAddress, "ERROR_ADDRESS", Access::kReadOnly, 0,
                 "low 32 bits of the address that last set bad_address or bad_value"},
    RegisterInfo{reg::kDatapath, "DATAPATH", Access::kReadOnly, 0, "1 paper, 2 wide; from the configuration"},
    RegisterInfo{reg::kMaxMemory, "MAX_MEMORY", Access::kReadOnly, 0,
                 "host memory that the board may use, MiB; all ones: no limit; from --max-memory"},
    RegisterInfo{reg::kMemoryAsked, "MEMORY_ASKED", Access::kReadOnly, 0,
                 "host memory that was needed when no_memory was last set, MiB"},
    RegisterInfo{reg::kFidelity, "FIDELITY", Access::kReadOnly, 0,
                 "1 functional, 3 cycle (2: approximate, boards of 0.2); from the configuration"},
    RegisterInfo{reg::kProcessors, "PROCESSORS", Access::kReadOnly, 0,
                 "ray integration processors; from the configuration"},
    RegisterInfo{reg::kBlockVoxels, "BLOCK_VOXELS", Access::kReadOnly, 0,
                 "block edge n, voxels; from the configuration"},
    RegisterInfo{reg::kMaxVolumeVoxels, "MAX_VOLUME_VOXELS", Access::kReadOnly, 0,
                 "N: the card stores the blocks of N^3 voxels; from the configuration"},
    RegisterInfo{reg::kQueueRays, "QUEUE_RAYS", Access::kReadOnly, 0, "rays per queue; from the configuration"},
    RegisterInfo{reg::kCoreKhz, "CORE_KHZ", Access::kReadOnly, 0, "core clock, kHz; from the configuration"},
    RegisterInfo{reg::kConfigHashLow, "CONFIG_HASH_LOW", Access::kReadOnly, 0,
                 "hash of the resolved configuration, bits 0-31"},
    RegisterInfo{reg::kConfigHashHigh, "CONFIG_HASH_HIGH", Access::kReadOnly, 0, "bits 32-63"},
    RegisterInfo{reg::kVolumeX, "VOLUME_X", Access::kReadWrite, 0,
                 "volume size in x, voxels; at least 2; written before its blocks"},
    RegisterInfo{reg::kVolumeY, "VOLUME_Y", Access::kReadWrite, 0, "volume size in y"},
    RegisterInfo{reg::kVolumeZ, "VOLUME_Z", Access::kReadWrite, 0, "volume size in z"},
    RegisterInfo{reg::kVoxelFormat, "VOXEL_FORMAT", Access::kReadOnly, 0,
                 "1 density, 2 rgb, 3 rgba; from the configuration"},
    RegisterInfo{reg::kSpacingX, "SPACING_X", Access::kReadWrite, kSpacingOne,
                 "voxel length along x, 16.16, relative to the length that opacities refer to; 1/64 to 64"},
    RegisterInfo{reg::kSpacingY, "SPACING_Y", Access::kReadWrite, kSpacingOne, "voxel length along y"},
    RegisterInfo{reg::kSpacingZ, "SPACING_Z", Access::kReadWrite, kSpacingOne, "voxel length along z"},
    RegisterInfo{reg::kStep, "STEP", Access::kReadWrite, kStepOne, "sample distance d, 16.16 voxels, 1/64 to 16"},
    RegisterInfo{reg::kOpacityThreshold, "OPACITY_THRESHOLD", Access::kReadWrite, 0xFFFFFF,
                 "a ray ends at this opacity; 2^24-1 = 1"},
    RegisterInfo{reg::kPipeline, "PIPELINE", Access::kReadWrite, kPipelineShade | kPipelineLeap,
                 "bit 0 jitter, 1 shade, 2 skip empty blocks, 3 irradiance, 4 scatter, 5 absorbed colour, 6 flat cut "
                 "faces (P1151)"},
    RegisterInfo{reg::kLifetime, "LIFETIME", Access::kReadWrite, kLifetimeReset,
                 "scatterings after which a ray made by the DSP is given up, 0 to 1023"},
    RegisterInfo{reg::kExposure, "EXPOSURE", Access::kReadWrite, kExposureReset,
                 "brightness of one unit of irradiance, 16.16; 65536 = full colour"},
    RegisterInfo{reg::kSeed, "SEED", Access::kReadWrite, 0,
                 "seed of the random numbers of lighting rays and scatterings"},
    RegisterInfo{reg::kIrradianceWords, "IRRADIANCE_WORDS", Access::kReadOnly, 0,
                 "per voxel: 1, or 3 for red, green and blue; from the configuration"},
    RegisterInfo{reg::kCutPlanes, "CUT_PLANES", Access::kReadWrite, 0, "number of cut planes in use, 0 to 6"},
    RegisterInfo{reg::kDropBlock, "DROP_BLOCK", Access::kWriteOnly, 0,
                 "number of a block whose voxels and irradiance the card drops"},
    RegisterInfo{reg::kBricks, "BRICKS", Access::kReadWrite, 0,
                 "1: rays wait for absent blocks also if the card could store the whole volume"},
#define GICUBE_CUT_PLANE(i)                                                                                     \
  RegisterInfo{reg::kCutPlane0 + 16 * (i) + 0, "CUT" #i "_NORMAL_X", Access::kReadWrite, 0,                     \
               "signed 1.14: points with normal . p >= offset are kept"},                                       \
      RegisterInfo{reg::kCutPlane0 + 16 * (i) + 4, "CUT" #i "_NORMAL_Y", Access::kReadWrite, 0, "normal in y"}, \
      RegisterInfo{reg::kCutPlane0 + 16 * (i) + 8, "CUT" #i "_NORMAL_Z", Access::kReadWrite, 0, "normal in z"}, \
      RegisterInfo{reg::kCutPlane0 + 16 * (i) + 12, "CUT" #i "_OFFSET", Access::kReadWrite, 0,                  \
                   "signed, 10 fraction bits, voxels"}
    GICUBE_CUT_PLANE(0),
    GICUBE_CUT_PLANE(1),
    GICUBE_CUT_PLANE(2),
    GICUBE_CUT_PLANE(3),
    GICUBE_CUT_PLANE(4),
    GICUBE_CUT_PLANE(5),
#undef GICUBE_CUT_PLANE
    RegisterInfo{reg::kLightRed, "LIGHT_RED", Access::kReadWrite, kLightColourReset,
                 "red share of an illumination's energy, 65535 = all; with three irradiance words"},
    RegisterInfo{reg::kLightGreen, "LIGHT_GREEN", Access::kReadWrite, kLightColourReset,
                 "green share of an illumination's energy, 65535 = all; with three irradiance words"},
    RegisterInfo{reg::kLightBlue, "LIGHT_BLUE", Access::kReadWrite, kLightColourReset,
                 "blue share of an illumination's energy, 65535 = all; with three irradiance words"},
};

inline constexpr int kCutOffsetFractionBits = 10;

constexpr const RegisterInfo* find_register(std::uint32_t offset) {
  for (const RegisterInfo& info : kRegisterTable) {
    if (info.offset == offset) return &info;
  }
  return nullptr;
}

}  // namespace gicube::wire
