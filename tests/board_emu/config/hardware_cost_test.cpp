#include "config/hardware_cost.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string_view>

namespace gicube::emu {
namespace {

constexpr std::uint64_t kMegabit = 1 << 20;

HardwareCost cost_with(std::uint32_t processors, std::uint32_t block, std::uint32_t volume, std::uint32_t rays) {
  v1::BoardConfig config;
  config.mutable_asic()->set_processors(processors);
  config.mutable_asic()->set_block_voxels(block);
  config.mutable_asic()->set_max_volume_voxels(volume);
  config.mutable_asic()->set_queue_rays(rays);
  return hardware_cost(config);
}

TEST(HardwareCost, IsTable1AtTheDesignPoint) {
  const HardwareCost cost = hardware_cost({});
  EXPECT_EQ(cost.ray_queues.bits, 512u * 256 * 256);
  EXPECT_EQ(cost.ray_queues.formula, "512 x 256 x 256");
  EXPECT_EQ(paper_units(cost.ray_queues.bits), "32.0 Mb");
  EXPECT_EQ(cost.volume_cache.bits, 4u * 33 * 33 * 33 * 36);
  EXPECT_EQ(paper_units(cost.volume_cache.bits), "4.9 Mb");
  EXPECT_EQ(cost.gradient_lut.bits, 4u * 2048 * 8 * 30);
  EXPECT_EQ(paper_units(cost.gradient_lut.bits), "1.9 Mb");
  EXPECT_EQ(cost.segmentation_lut.bits, 4u * 16384 * 84);
  EXPECT_EQ(paper_units(cost.segmentation_lut.bits), "5.3 Mb");
  EXPECT_EQ(cost.reflectance_map.bits, 4u * 128 * 128 * 6 * 8);
  EXPECT_EQ(paper_units(cost.reflectance_map.bits), "3.0 Mb");
  // The paper prints 10 Kb next to a formula that gives 9.1.
  EXPECT_EQ(cost.registers.formula, "32 x 256 + 20 x 55");
  EXPECT_EQ(paper_units(cost.registers.bits), "9.1 Kb");
  EXPECT_EQ((cost.sram.bits + kMegabit / 2) / kMegabit, 15u);
}

TEST(HardwareCost, EachProcessorHasItsOwnSramAndSharesTheQueues) {
  const HardwareCost four = hardware_cost({}), eight = cost_with(8, 32, 256, 256);
  EXPECT_EQ(eight.ray_queues.bits, four.ray_queues.bits);
  EXPECT_EQ(eight.volume_cache.bits, 2 * four.volume_cache.bits);
  EXPECT_EQ(eight.gradient_lut.bits, 2 * four.gradient_lut.bits);
  EXPECT_EQ(eight.segmentation_lut.bits, 2 * four.segmentation_lut.bits);
  EXPECT_EQ(eight.reflectance_map.bits, 2 * four.reflectance_map.bits);
  EXPECT_EQ(eight.registers.bits, four.registers.bits);
  EXPECT_EQ(eight.sram.bits, 2 * four.sram.bits);
}

TEST(HardwareCost, OfThreeIrradianceWordsIsTheirWidthAndWhatInterpolatesAndSplitsThem) {
  v1::BoardConfig config;
  config.mutable_asic()->set_irradiance_words(3);
  const HardwareCost one = hardware_cost({}), three = hardware_cost(config);
  EXPECT_EQ(three.volume_cache.formula, "4 x 33^3 x 58");
  EXPECT_EQ(three.logic.size(), one.logic.size() + 2);
  config.mutable_asic()->set_voxel_format(v1::rgb);
  EXPECT_EQ(hardware_cost(config).volume_cache.formula, "4 x 33^3 x 82");
}

TEST(HardwareCost, OfVoxelsWithColoursIsTheirWidthInTheCacheAndTheirChannelsInThePipeline) {
  v1::BoardConfig config;
  config.mutable_asic()->set_voxel_format(v1::rgb);
  const HardwareCost plain = hardware_cost({}), rgb = hardware_cost(config);
  EXPECT_EQ(rgb.volume_cache.formula, "4 x 33^3 x 60");
  EXPECT_EQ(rgb.volume_cache.bits * 36, plain.volume_cache.bits * 60);
  EXPECT_EQ(rgb.gradient_lut.bits, plain.gradient_lut.bits);
  EXPECT_EQ(rgb.logic.size(), plain.logic.size() + 2);
  config.mutable_asic()->set_voxel_format(v1::rgba);
  const HardwareCost rgba = hardware_cost(config);
  EXPECT_EQ(rgba.volume_cache.bits, rgb.volume_cache.bits);
  const auto transistors = [](const HardwareCost& cost) {
    std::uint64_t sum = 0;
    for (const LogicItem& item : cost.logic) sum += item.transistors();
    return sum;
  };
  EXPECT_GT(transistors(rgb), transistors(plain));
  EXPECT_GT(transistors(rgba), transistors(rgb)) << "it multiplies eight voxels, and divides";
}

TEST(HardwareCost, QueuesGrowWithTheVolumeTheirLengthAndSmallerBlocks) {
  EXPECT_EQ(cost_with(4, 32, 512, 256).ray_queues.bits, 8 * 32 * kMegabit);
  EXPECT_EQ(cost_with(4, 16, 256, 256).ray_queues.bits, 8 * 32 * kMegabit);
  EXPECT_EQ(cost_with(4, 32, 256, 64).ray_queues.bits, 8 * kMegabit);
  EXPECT_EQ(cost_with(4, 64, 32, 256).ray_queues.bits, 256u * 256);  // a volume within one block
  EXPECT_EQ(cost_with(4, 16, 256, 256).volume_cache.bits, 4u * 17 * 17 * 17 * 36);
}

TEST(HardwareCost, TheBaselineHasOneQueueAProcessor) {
  v1::BoardConfig config;
  config.mutable_sorter()->set_queues(v1::single);
  EXPECT_EQ(hardware_cost(config).ray_queues.bits, 4u * 256 * 256);
}

TEST(HardwareCost, RegistersHoldARayAStage) {
  v1::BoardConfig config;
  config.mutable_pipeline()->set_prefetch_stages(32);
  EXPECT_EQ(hardware_cost(config).registers.bits, 48u * 256 + 20 * 55);
}

TEST(HardwareCost, TheLargestConfigurationFitsItsWords) {
  const HardwareCost cost = cost_with(16, 8, 1024, 4096);
  EXPECT_EQ(cost.ray_queues.bits, (std::uint64_t{1} << 21) * 4096 * 256);
  EXPECT_EQ(paper_units(cost.ray_queues.bits), "2097152.0 Mb");
}

TEST(HardwareCost, PrintsOneItemALine) {
  const std::string text = to_string(hardware_cost({}));
  EXPECT_THAT(text, testing::HasSubstr("4 x 33^3 x 36"));
  EXPECT_THAT(text, testing::ContainsRegex("Segmentation LUT +4 x 16384 x 84 +5505024 bit +5.3 Mb SRAM\n"));
  EXPECT_THAT(text, testing::ContainsRegex("Total SRAM .* 15\\.1 Mb SRAM\n"));
}

TEST(HardwareCost, CountsThePinsOfTheMemoryChannels) {
  v1::BoardConfig config;
  EXPECT_EQ(hardware_cost(config).memory_channels, 4u);
  EXPECT_EQ(hardware_cost(config).memory_signal_count, 34u);
  config.mutable_rdram()->set_processors_per_rdram(2);
  EXPECT_EQ(hardware_cost(config).memory_channels, 2u);
  config.set_memory(v1::ddr);
  EXPECT_EQ(hardware_cost(config).memory_channels, 4u);
  EXPECT_EQ(hardware_cost(config).memory_signal_count, 105u);
  EXPECT_THAT(to_string(hardware_cost(config)), testing::HasSubstr("Memory signals: 4 channels x 105 = 420 pins"));
}

std::uint64_t transistors(const HardwareCost& cost, std::string_view part) {
  std::uint64_t sum = 0;
  for (const LogicItem& item : cost.logic) sum += item.part == part ? item.transistors() : 0;
  return sum;
}

TEST(HardwareCost, ItsLogicIsWithinAQuarterOfTable1InEachPart) {
  const HardwareCost cost = hardware_cost({});
  const std::map<std::string_view, double> paper{
      {"Queues", 2e6}, {"Volume cache", 2e6}, {"Pipeline", 4e6}, {"Control", 1.5e6}};
  double all = 0;
  for (const auto& [part, estimate] : paper) {
    const auto ours = static_cast<double>(transistors(cost, part));
    EXPECT_NEAR(ours, estimate, 0.25 * estimate) << part;
    all += ours;
  }
  EXPECT_NEAR(all, 9.5e6, 0.25 * 9.5e6);
  for (const LogicItem& item : cost.logic) EXPECT_TRUE(paper.contains(item.part)) << item.name;
}

// By hand: a rank has two buffers, a comparator and four multiplexers of 9 + 9 bits.
TEST(HardwareCost, ARankOfTheSorterIsCountedByItsBits) {
  const HardwareCost cost = hardware_cost({});
  EXPECT_EQ(cost.logic.front().count, 512u);
  EXPECT_EQ(cost.logic.front().each, 18u * (2 * 24 + 28 + 4 * 12));
}

TEST(HardwareCost, PipelinesGrowWithTheProcessorsAndSortersDoNot) {
  const HardwareCost four = hardware_cost({}), eight = cost_with(8, 32, 256, 256);
  EXPECT_EQ(transistors(eight, "Pipeline"), 2 * transistors(four, "Pipeline"));
  EXPECT_EQ(transistors(eight, "Volume cache"), 2 * transistors(four, "Volume cache"));
  EXPECT_EQ(transistors(eight, "Queues"), transistors(four, "Queues"));
}

TEST(HardwareCost, TheBaselineHasNoSorterAndOneProcessorHasNoLinks) {
  v1::BoardConfig config;
  config.mutable_sorter()->set_queues(v1::single);
  EXPECT_LT(transistors(hardware_cost(config), "Queues"), 10'000u);
  EXPECT_EQ(transistors(cost_with(1, 32, 256, 256), "Control"), ((9u + 1) * 2 * 256 + 32 * 144) * 24u);
}

TEST(HardwareCost, PrintsTheSumOfEachPartAndOfAll) {
  const std::string text = to_string(hardware_cost({}));
  EXPECT_THAT(text, testing::ContainsRegex("interpolators +140 x 9056 +1267840 transistors\n"));
  EXPECT_THAT(text, testing::ContainsRegex("Pipeline +4\\.1 M transistors\n"));
  EXPECT_THAT(text, testing::ContainsRegex("All parts +9\\.4 M transistors\n"));
}

}  // namespace
}  // namespace gicube::emu
