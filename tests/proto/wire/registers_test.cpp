#include "gicube/wire/registers.h"

#include "gicube/wire/pci_config.h"
#include "gicube/wire/ray.h"
#include "test.h"

namespace gicube::wire {
namespace {

TEST(RegisterTable, RisesInAlignedOffsetsInsideBar0) {
  for (std::size_t i = 0; i < kRegisterTable.size(); ++i) {
    const RegisterInfo& info = kRegisterTable[i];
    EXPECT_EQ(info.offset % 4, 0u) << info.name;
    EXPECT_LE(info.offset + 4, kBar0Bytes) << info.name;
    if (i > 0) {
      EXPECT_GT(info.offset, kRegisterTable[i - 1].offset) << info.name << " stands twice or out of order";
    }
  }
}

TEST(RegisterTable, GivesEachRegisterANameAndAMeaning) {
  std::set<std::string_view> names;
  for (const RegisterInfo& info : kRegisterTable) {
    EXPECT_FALSE(info.meaning.empty()) << info.name;
    EXPECT_EQ(info.meaning.find('|'), std::string_view::npos) << info.name << " would break the Markdown table";
    EXPECT_TRUE(names.insert(info.name).second) << info.name << " stands twice";
  }
}

TEST(RegisterTable, FindsEveryRegisterAndNothingElse) {
  std::set<std::uint32_t> offsets;
  for (const RegisterInfo& info : kRegisterTable) offsets.insert(info.offset);
  for (std::uint32_t offset = 0; offset < kBar0Bytes; ++offset) {
    const RegisterInfo* info = find_register(offset);
    ASSERT_EQ(info != nullptr, offsets.contains(offset)) << offset;
    if (info == nullptr) continue;
    EXPECT_EQ(info->offset, offset);
  }
  EXPECT_EQ(find_register(0xFFFF'FFFC), nullptr);
}

TEST(RegisterTable, ResetsToAUsableBoard) {
  EXPECT_EQ(find_register(reg::kId)->reset, 0x42434947u);  // 'G' 'I' 'C' 'B', low byte first
  EXPECT_EQ(find_register(reg::kStatus)->reset, 0u);
  EXPECT_EQ(find_register(reg::kStep)->reset, kStepOne);
  EXPECT_EQ(find_register(reg::kOpacityThreshold)->reset, kOpacityOne);
  EXPECT_EQ(find_register(reg::kPipeline)->reset, kPipelineShade | kPipelineLeap);
  EXPECT_EQ(find_register(reg::kCutPlanes)->reset, 0u);
  for (const std::uint32_t spacing : {reg::kSpacingX, reg::kSpacingY, reg::kSpacingZ}) {
    EXPECT_EQ(find_register(spacing)->reset, kSpacingOne);
  }
}

TEST(RegisterTable, HasFourWordsForEveryCutPlane) {
  for (std::uint32_t plane = 0; plane < kMaxCutPlanes; ++plane) {
    const std::string prefix = "CUT" + std::to_string(plane) + "_";
    EXPECT_EQ(find_register(reg::kCutPlane0 + 16 * plane)->name, prefix + "NORMAL_X");
    EXPECT_EQ(find_register(reg::kCutPlane0 + 16 * plane + 12)->name, prefix + "OFFSET");
  }
  EXPECT_EQ(find_register(reg::kCutPlane0 + 16 * kMaxCutPlanes), nullptr);
}

}  // namespace
}  // namespace gicube::wire
