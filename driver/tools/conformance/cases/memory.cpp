// The memory behind BAR2.
#include <algorithm>
#include <array>

#include "gicube/wire/checksum.h"
#include "gicube/wire/memory_map.h"
#include "tools/conformance/host.h"
#include "tools/conformance/scene.h"

namespace gicube::conformance {
namespace {

constexpr std::array kTables{wire::kSegmentationLut, wire::kGradientLut, wire::kReflectanceMap, wire::kEmptyFlags,
                             wire::kAbsentFlags,     wire::kMaterials,   wire::kDarkFlags};

void no_memory(Host& host, std::uint64_t address, std::uint64_t length) {
  host.refused_request(FrameType::kMemoryRead, long_words({address, length}), ErrorCode::kBadAddress);
}

void bad_write(Host& host, std::uint64_t address, std::size_t length) {
  host.write_memory(address, Bytes(length, 0xA5));
  check(host.read_register(reg::kStatus) == wire::kStatusBadAddress, "0x{:x}: expected STATUS.bad_address", address);
  check_same("ERROR_ADDRESS", host.read_register(reg::kErrorAddress), static_cast<std::uint32_t>(address));
  host.write_register(reg::kStatusClear, ~0u);
}

constexpr Case kCases[] = {
    {0, "memory.tables", "P1207",
     [](Host& host) {
       for (const wire::MemoryRegion& table : kTables) {
         check(host.read_memory(table.base, table.bytes) == Bytes(table.bytes), "{}: expected zeros at reset",
               table.name);
       }
       Noise noise(1);
       std::vector<Bytes> written;
       for (const wire::MemoryRegion& table : kTables) {
         written.push_back(noise.bytes(table.bytes));
         host.write_memory(table.base, written.back());
       }
       for (std::size_t i = 0; i < kTables.size(); ++i) {
         check(host.read_memory(kTables[i].base, kTables[i].bytes) == written[i], "{}: expected what was written",
               kTables[i].name);
       }
     }},
    {0, "memory.pieces", "P1207",
     [](Host& host) {
       host.write_memory(wire::kReflectanceMap.base + 5, {1, 2, 3});
       host.write_memory(wire::kReflectanceMap.base + 7, {9});
       check(host.read_memory(wire::kReflectanceMap.base + 4, 6) == Bytes{0, 1, 2, 9, 0, 0},
             "expected the bytes of both");
     }},
    {0, "memory.volume", "P1202",
     [](Host& host) {
       Volume volume(host, {19, 18, 17});
       const std::size_t bytes = volume.bytes();
       Noise noise(2);
       const Bytes some = noise.voxels(bytes);
       host.write_memory(wire::kVolume.base + 7, Bytes(some.begin() + 7, some.end()));
       host.write_memory(wire::kVolume.base, Bytes(some.begin(), some.begin() + 7));
       check(host.read_memory(wire::kVolume.base, bytes) == some, "expected the volume that was written");
       check_same("STATUS", host.read_register(reg::kStatus), 0);
     }},
    {0, "memory.zero", "P1203",
     [](Host& host) {
       const Volume volume(host, {19, 18, 17});
       check(host.read_memory(wire::kVolume.base, volume.bytes()) == Bytes(volume.bytes()), "expected zeros");
     }},
    {0, "memory.size_clears", "P1103",
     [](Host& host) {
       for (const std::uint32_t offset : {reg::kVolumeX, reg::kVolumeY, reg::kVolumeZ}) {
         const Volume volume(host, {9, 9, 9});
         host.write_memory(wire::kVolume.base, Bytes(volume.bytes(), 0x11));
         host.write_memory(wire::kEmptyFlags.base, {0xFF});
         host.write_register(offset, 9);
         check(host.read_memory(wire::kVolume.base, volume.bytes()) == Bytes(volume.bytes()),
               "expected a cleared volume");
         check(host.read_memory(wire::kEmptyFlags.base, 1) == Bytes{0}, "expected cleared empty flags");
       }
     }},
    {0, "memory.clear", "P1110",
     [](Host& host) {
       const Volume volume(host, {9, 9, 9});
       host.write_memory(wire::kVolume.base, Bytes(volume.bytes(), 0x11));
       host.write_memory(wire::kEmptyFlags.base, {0xFF});
       host.write_memory(wire::kReflectanceMap.base, {5});
       host.write_register(reg::kControl, wire::kControlClearVolume);
       check(host.read_memory(wire::kVolume.base, volume.bytes()) == Bytes(volume.bytes()),
             "expected a cleared volume");
       check(host.read_memory(wire::kEmptyFlags.base, 1) == Bytes{0}, "expected cleared empty flags");
       check(host.read_memory(wire::kReflectanceMap.base, 1) == Bytes{5}, "expected the tables to stay");
       check_same("VOLUME_X", host.read_register(reg::kVolumeX), 9);
     }},
    {0, "memory.bad_writes", "P1201",
     [](Host& host) {
       const Volume volume(host, {9, 9, 9});
       for (const wire::MemoryRegion& table : kTables) {
         bad_write(host, table.base + table.bytes - 4, 8);
         check(host.read_memory(table.base + table.bytes - 4, 4) == Bytes(4), "{}: expected no part of a bad write",
               table.name);
       }
       bad_write(host, wire::kVolume.base + volume.bytes() - 4, 8);
       check(host.read_memory(wire::kVolume.base + volume.bytes() - 4, 4) == Bytes(4), "volume: expected no part");
       bad_write(host, wire::kFramebuffer.base, 4);
       bad_write(host, 0x0800'0000, 4);
       bad_write(host, ~std::uint64_t{0} - 3, 4);
     }},
    {0, "memory.bad_reads", "P1201",
     [](Host& host) {
       const Volume volume(host, {9, 9, 9});
       no_memory(host, wire::kReflectanceMap.base + wire::kReflectanceMap.bytes - 4, 8);
       no_memory(host, wire::kVolume.base + volume.bytes() - 4, 8);
       no_memory(host, 0x0800'0000, 4);
       no_memory(host, ~std::uint64_t{0} - 3, 8);
       check_same("ID", host.read_register(reg::kId), wire::kIdValue);
     }},
    {0, "memory.long_read", "P904",
     [](Place& place) {
       wire::VersionInfo mine = host_version();
       mine.max_payload_bytes = 8192;
       Host host(place, mine);
       check_same("bytes of the longest read", host.read_memory(wire::kReflectanceMap.base, 8192).size(), 8192);
       host.post(FrameType::kMemoryRead, long_words({wire::kReflectanceMap.base, 8193}), 0);
       host.ends(ErrorCode::kTooLarge);
     }},
    {1, "memory.verify", "P412",
     [](Host& host) {
       const Volume volume(host, {9, 9, 70});
       Noise noise(3);
       const Bytes first = noise.voxels(volume.block_bytes());
       host.write_memory(wire::kVolume.base, first);
       const Bytes sums = host.run(wire::encoded(wire::VerifyCommand{0, 2}));
       check_same("bytes of the sums", sums.size(), 8);
       check_same("block 0", wire::load<std::uint32_t>(sums, 0), wire::crc32c(first));
       check_same("block 1", wire::load<std::uint32_t>(sums, 4), wire::crc32c(Bytes(volume.block_bytes())));
       host.refused(wire::VerifyCommand{0, 0}, "count");
     }},
};

}  // namespace

std::span<const Case> memory_cases() { return kCases; }

}  // namespace gicube::conformance
