// The board's memory as mapped to the host through BAR2: the addresses of kMemoryWrite and kMemoryRead.
#pragma once

#include <array>
#include <cstdint>

#include "gicube/wire/command.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/material.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"

namespace gicube::wire {

struct MemoryRegion {
  const char* name;
  std::uint64_t base;
  std::uint64_t bytes;
  bool writable;
  const char* meaning;
};

// Blocks of the volume. Block b = bx + nx * (by + ny * bz), with nx, ny, nz = ceil(size / n), begins at kVolume.base +
// b * n^3 * 36 / 8. Its n^3 words (x fastest) hold each voxel once; the DSP writes the copies on the shared faces. A
// block is written as a whole or in pieces of whole bytes. A block that was never written is zero. The card stores (N /
// n)^3 blocks; the first write to one more sets STATUS.bad_address.
inline constexpr MemoryRegion kSegmentationLut{"segmentation_lut", 0x0000'0000,
                                               kSegmentationEntries* kSegmentationEntryBytes, true,
                                               "2^14 words of 84 bits, 12 bytes each (lut.h)"};
inline constexpr MemoryRegion kGradientLut{"gradient_lut", 0x0010'0000, kGradientCodes* kGradientEntryBytes, true,
                                           "2048 words of 3 x 10 bits, 4 bytes each (lut.h)"};
inline constexpr MemoryRegion kReflectanceMap{"reflectance_map", 0x0020'0000, kReflectanceBytes, true,
                                              "6 x 128 x 128 bytes (lut.h)"};
inline constexpr MemoryRegion kEmptyFlags{"empty_flags", 0x0030'0000, std::uint64_t{1} << 18, true,
                                          "one bit per block, block 0 in bit 0 of byte 0; 1 = nothing visible"};
inline constexpr MemoryRegion kAbsentFlags{"absent_flags", 0x0038'0000, std::uint64_t{1} << 18, true,
                                           "like empty_flags; 1 = rays wait for the block (command.h, kContinue)"};
inline constexpr MemoryRegion kDarkFlags{"dark_flags", 0x0044'0000, std::uint64_t{1} << 18, true,
                                         "like empty_flags; 1 = the host has the block's irradiance (host_deposits)"};
inline constexpr MemoryRegion kMaterials{"materials", 0x0040'0000, std::uint64_t{kTags} * kMaterialBytes, true,
                                         "one record per tag (material.h)"};
inline constexpr MemoryRegion kScatteringColours{"scattering_colours", 0x0042'0000,
                                                 std::uint64_t{kTags} * kScatteringColourBytes, true,
                                                 "one record per tag (material.h)"};
inline constexpr MemoryRegion kFramebuffer{"framebuffer", 0x1000'0000, std::uint64_t{4095} * 4095 * 9 / 2 + 1, false,
                                           "36-bit pixels packed two in nine bytes, rows from the top (voxel.h)"};
inline constexpr MemoryRegion kVolume{"volume", 0x1'0000'0000, std::uint64_t{1024} * 1024 * 1024 * 9 / 2, true,
                                      "blocks of packed 36-bit voxels"};

// Irradiance of the n^3 voxels of block b, x fastest, begins at kIrradiance.base + 4 b n^3. The words are unsigned
// 32-bit numbers in units of the energy words; the paper's datapath uses 11 bits of them. A block that no ray has
// reached is zero.
inline constexpr std::size_t kIrradianceBytes = 4;
inline constexpr MemoryRegion kIrradiance{"irradiance", 0x4'0000'0000,
                                          std::uint64_t{1024} * 1024 * 1024 * kIrradianceBytes, true,
                                          "blocks of 32-bit irradiance words"};

// Irradiance of green and blue, on cards with three irradiance words (IRRADIANCE_WORDS). The region above then holds
// red.
inline constexpr MemoryRegion kGreenIrradiance{"green_irradiance", 0x6'4000'0000, kIrradiance.bytes, true,
                                               "like irradiance, for green (IRRADIANCE_WORDS)"};
inline constexpr MemoryRegion kBlueIrradiance{"blue_irradiance", 0x7'8000'0000, kIrradiance.bytes, true,
                                              "like irradiance, for blue (IRRADIANCE_WORDS)"};
constexpr const MemoryRegion& irradiance_region(std::size_t word) {
  return word == 0 ? kIrradiance : word == 1 ? kGreenIrradiance : kBlueIrradiance;
}

// Accumulators of backprojecting rays (command.h): signed 36-bit words in two's complement, at the same offsets as the
// volume's words. Reads must cover whole pairs of words, nine bytes each. A block that no ray has reached is zero.
inline constexpr MemoryRegion kSums{"sums", 0x2'4000'0000, std::uint64_t{1024} * 1024 * 1024 * 9 / 2, false,
                                    "blocks of packed signed 36-bit sums"};

// Colours of the n^3 voxels of block b, x fastest, begin at kColours.base + 3 b n^3: red, green, blue, 255 = one. Only
// cards whose voxels have colours (VoxelFormat) have this region, and only blocks that were written to kVolume. A block
// whose colours were never written is black. If none was written, the volume has no colours: all come from the
// segmentation LUT.
inline constexpr MemoryRegion kColours{"colours", 0x5'4000'0000, std::uint64_t{1024} * 1024 * 1024 * kColourBytes, true,
                                       "blocks of colours, 3 bytes per voxel (VOXEL_FORMAT)"};

// The rays of trace commands in a volume with more blocks than the card stores, in their order of arrival (command.h).
// Reads must cover whole packets.
inline constexpr std::uint32_t kMaxHostRays = 1u << 24;  // chosen: 512 MB of packets in the DSP's SDRAM
inline constexpr MemoryRegion kHostRayMemory{"host_rays", 0x4000'0000, std::uint64_t{kMaxHostRays} * kRayBytes, false,
                                             "rays of trace commands of a volume in bricks, 32 bytes each (command.h)"};

// Deposits of the latest command in blocks whose dark flag is set: HostDeposits (command.h), ascending. Reads must
// cover whole records.
inline constexpr MemoryRegion kHostDeposits{
    "host_deposits", 0x8000'0000, std::uint64_t{1} << 30, false,
    "deposits of the latest command in blocks whose dark flag is set (command.h)"};

inline constexpr std::array<MemoryRegion, 17> kMemoryMap{
    kSegmentationLut, kGradientLut,     kReflectanceMap, kEmptyFlags,   kAbsentFlags, kMaterials, kScatteringColours,
    kDarkFlags,       kFramebuffer,     kHostRayMemory,  kHostDeposits, kVolume,      kSums,      kIrradiance,
    kColours,         kGreenIrradiance, kBlueIrradiance};

// Returns the region that holds [address, address + bytes), or null.
constexpr const MemoryRegion* find_region(std::uint64_t address, std::uint64_t bytes) {
  for (const MemoryRegion& region : kMemoryMap) {
    const bool starts_inside = address >= region.base && address - region.base <= region.bytes;
    if (starts_inside && bytes <= region.bytes - (address - region.base)) return &region;
  }
  return nullptr;
}

}  // namespace gicube::wire
