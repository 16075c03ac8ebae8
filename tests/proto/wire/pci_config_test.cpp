#include "gicube/wire/pci_config.h"

#include "gicube/wire/memory_map.h"
#include "test.h"

namespace gicube::wire {
namespace {

std::uint32_t byte_at(const PciConfigSpace& space, std::uint32_t offset) {
  return space[offset / 4] >> (8 * (offset % 4)) & 0xFF;
}

// Capability ids as a driver finds them; stops with a failure if the list does not end.
std::vector<std::uint32_t> capabilities(const PciConfigSpace& space) {
  std::vector<std::uint32_t> ids;
  for (std::uint32_t at = byte_at(space, pci::kCapabilities); at != 0; at = byte_at(space, at + 1)) {
    EXPECT_EQ(at % 4, 0u);
    EXPECT_GE(at, 0x40u) << "capabilities stand behind the header";
    EXPECT_LT(at, kPciConfigBytes);
    ids.push_back(byte_at(space, at));
    if (ids.size() > kPciConfigBytes / 4) {
      ADD_FAILURE() << "the list goes in a circle";
      break;
    }
  }
  return ids;
}

TEST(PciConfig, SaysWhatTheCardIs) {
  const PciConfigSpace space = pci_config_at_reset(0);
  EXPECT_EQ(space[0], 0x0C5B'4749u);       // device, vendor
  EXPECT_EQ(byte_at(space, 0x0B), 0x0Bu);  // base class: processor
  EXPECT_EQ(byte_at(space, 0x0A), 0x40u);  // sub-class: co-processor
  EXPECT_EQ(byte_at(space, 0x09), 0x00u);
  EXPECT_EQ(byte_at(space, 0x0E), 0x00u);  // header type 0, one function
  EXPECT_NE(space[1] & 1u << 20, 0u) << "the status word announces a capability list";
}

TEST(PciConfig, ListsPowerManagementOnPciAndAgpTooOnAgp) {
  EXPECT_THAT(capabilities(pci_config_at_reset(0)), ElementsAre(0x01));
  EXPECT_THAT(capabilities(pci_config_at_reset(0x3)), ElementsAre(0x01, 0x02));
}

TEST(PciConfig, SaysWhichAgpRatesTheCardCanDo) {
  for (const std::uint32_t rates : {0x1u, 0x3u, 0x7u}) {
    const PciConfigSpace space = pci_config_at_reset(rates);
    EXPECT_EQ(space[pci::kAgp / 4 + 1] & 0x7u, rates);
    EXPECT_EQ(byte_at(space, pci::kAgp + 2), 0x20u) << "AGP revision 2.0";
  }
  EXPECT_EQ(pci_config_at_reset(0)[pci::kAgp / 4], 0u);
}

TEST(PciConfig, PlacesBothBarsOnTheirOwnSize) {
  const PciConfigSpace space = pci_config_at_reset(0);
  const std::uint32_t bar0 = space[pci::kBar0Register / 4];
  EXPECT_EQ(bar0 & 0xFu, 0x0u) << "memory, 32 bit, not prefetchable";
  EXPECT_EQ(bar0 % kBar0Bytes, 0u);
  EXPECT_EQ(space[pci::kBar2Low / 4] & 0xFu, 0xCu) << "memory, 64 bit, prefetchable";
  const std::uint64_t bar2 = std::uint64_t{space[pci::kBar2High / 4]} << 32 | (space[pci::kBar2Low / 4] & ~0xFu);
  EXPECT_EQ(bar2, kBar2);
  std::uint64_t bar2_bytes = 1;
  for (const MemoryRegion& region : kMemoryMap) {
    while (bar2_bytes < region.base + region.bytes) bar2_bytes *= 2;
  }
  EXPECT_EQ(bar2 % bar2_bytes, 0u);
}

}  // namespace
}  // namespace gicube::wire
