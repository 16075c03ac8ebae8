// The documents' tables and examples say what the code says.
#include "gicube/wire/checksum.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/pci_config.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/register_markdown.h"
#include "gicube/wire/voxel.h"
#include "hex.h"
#include "test.h"

namespace gicube::wire {
namespace {

// The text between the lines <!-- name --> and <!-- /name -->.
std::string marked(const std::string& text, const std::string& name) {
  const std::string open = "<!-- " + name + " -->\n", close = "<!-- /" + name + " -->";
  const std::size_t begin = text.find(open), end = text.find(close);
  if (begin == std::string::npos || end == std::string::npos || end < begin) {
    ADD_FAILURE() << "the marks of " << name << " are missing";
    return {};
  }
  return text.substr(begin + open.size(), end - begin - open.size());
}

// The first `quoted` text of every row, in one line.
std::string hex_column(const std::string& table) {
  std::istringstream rows(table);
  std::string row, hex;
  while (std::getline(rows, row)) {
    if (!row.starts_with("| `")) continue;
    const std::string bytes = row.substr(3, row.find('`', 3) - 3);
    hex += (hex.empty() ? "" : " ") + bytes;
  }
  return hex;
}

// The rows of a Markdown table as lines of a CSV file.
std::string csv_of(const std::string& markdown) {
  std::istringstream rows(markdown);
  std::string row, csv;
  while (std::getline(rows, row)) {
    if (row.starts_with("|---")) continue;
    std::string line;
    for (std::size_t at = 2; at < row.size();) {
      const std::size_t end = row.find(" |", at);
      std::string cell = row.substr(at, end - at);
      if (cell.find_first_of(",\"") != std::string::npos) {
        for (std::size_t quote = 0; (quote = cell.find('"', quote)) != std::string::npos; quote += 2) {
          cell.insert(quote, 1, '"');
        }
        cell = '"' + cell + '"';
      }
      line += (line.empty() ? "" : ",") + cell;
      at = end + 3;
    }
    csv += line + '\n';
  }
  return csv;
}

TEST(ProtocolDocument, HoldsTheRegisterTable) {
  EXPECT_EQ(text_of(GICUBE_SOURCE_DIR "/docs/reference/registers.csv"), csv_of(register_markdown()));
}

TEST(ProtocolDocument, HoldsTheMemoryMap) {
  EXPECT_EQ(text_of(GICUBE_SOURCE_DIR "/docs/reference/memory.csv"), csv_of(memory_markdown()));
}

TEST(ProtocolDocument, NamesThePciHeaderAsItIsAtReset) {
  const std::string text = text_of(GICUBE_SOURCE_DIR "/docs/reference/protocol.md");
  const PciConfigSpace space = pci_config_at_reset(0);
  for (std::uint32_t offset = 0; offset < kPciConfigBytes; offset += 4) {
    const std::string row = "\n| " + hex_text(offset, 2) + " | " + hex_text(space[offset / 4], 8) + " |";
    EXPECT_EQ(text.find(row) != std::string::npos, space[offset / 4] != 0) << row;
  }
  const PciConfigSpace agp = pci_config_at_reset(0x7);
  EXPECT_NE(text.find("AGP card " + hex_text(agp[pci::kPowerManagement / 4], 8)), std::string::npos);
  EXPECT_NE(text.find("| 0x50 | " + hex_text(agp[pci::kAgp / 4], 8) + " |"), std::string::npos);
  EXPECT_NE(text.find("| 0x54 | " + hex_text(agp[pci::kAgp / 4 + 1] & ~0x7u, 8) + " + rates |"), std::string::npos);
}

TEST(WireReadme, ShowsTheBytesOfARegisterWrite) {
  FrameHeader header;
  header.type = FrameType::kRegisterWrite;
  header.flags = kPosted;
  header.id = 42;
  header.size = 8;
  header.credit_slots = 1;
  header.time_ps = 1'000'000;
  header.credit_bytes = 4;
  header.sequence = 17;
  std::array<std::uint8_t, 8> payload{};
  store(std::span(payload), 0, reg::kStep);
  store(std::span(payload), 4, kStepOne / 2);
  std::array<std::uint8_t, kFrameHeaderBytes> bytes{};
  encode_sealed(header, payload, bytes);
  EXPECT_EQ(hex_column(marked(text_of(GICUBE_SOURCE_DIR "/proto/gicube/wire/README.md"), "frame example")),
            to_hex(bytes) + " " + to_hex(payload));
}

TEST(WireReadme, ShowsTheBytesOfAHostRay) {
  Ray ray;
  ray.set_host_id(7);
  ray.position = {kVoxel * 21 / 2, kVoxel * 20, kVoxel * 121 / 4};
  ray.direction = {0, 0, 1 << kDirectionFractionBits};
  ray.flags = kHostRay;
  EXPECT_EQ(hex_column(marked(text_of(GICUBE_SOURCE_DIR "/proto/gicube/wire/README.md"), "ray example")),
            hex_of<kRayBytes>(ray));
}

TEST(WireReadme, ShowsTheBytesOfTwoVoxels) {
  std::array<std::uint8_t, 9> bytes{};
  store36(bytes, 0, to_word(Voxel{1000, 5, 1, 0}));
  store36(bytes, 1, to_word(Voxel{}));
  EXPECT_EQ(hex_column(marked(text_of(GICUBE_SOURCE_DIR "/proto/gicube/wire/README.md"), "voxel example")),
            to_hex(bytes));
}

}  // namespace
}  // namespace gicube::wire
