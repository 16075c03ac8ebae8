#include "config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace gicube::emu {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> texts(const std::vector<Diagnostic>& found) {
  std::vector<std::string> all;
  for (const Diagnostic& each : found) all.push_back(to_string(each));
  return all;
}

v1::BoardConfig with(std::initializer_list<const char*> overrides) {
  v1::BoardConfig config;
  for (const char* each : overrides) EXPECT_THAT(texts(apply_override(config, each)), IsEmpty());
  return config;
}

TEST(Config, EmptyTextIsTheDesignPoint) {
  const ParsedConfig parsed = parse_config("");
  EXPECT_THAT(texts(parsed.diagnostics), IsEmpty());
  EXPECT_THAT(texts(check(parsed.config)), IsEmpty());
  EXPECT_EQ(parsed.config.asic().processors(), 4u);
}

TEST(Config, ReportsEveryFaultOfATextInOneGo) {
  const ParsedConfig parsed = parse_config(
      "fidelity: fast\n"
      "asic {\n"
      "  processors: \"eight\"\n"
      "\tqueue_rays: -1 block_voxel: 32\n"
      "  core_khz: 100000 core_khz: 200000\n"
      "}\n"
      "asik { processors: 8 }\n"
      "bus { model: pci66 }\n");
  EXPECT_THAT(
      texts(parsed.diagnostics),
      testing::ElementsAre("line 1: fidelity: expected one of functional, cycle, got fast",
                           "line 3: asic.processors: expected a whole number from 0 to 4294967295, got \"eight\"",
                           "line 4: asic.queue_rays: expected a whole number from 0 to 4294967295, got -1",
                           AllOf(HasSubstr("line 4: asic.block_voxel: expected one of processors, block_voxels"),
                                 HasSubstr("got \"block_voxel\"")),
                           "line 5: asic.core_khz: expected one value, got a second one",
                           "line 7: asik: expected one of fidelity, asic, dsp, bus, sorter, pipeline, cache, link, "
                           "memory, rdram, ddr, sdram, ideal, energy, pace, threads, got \"asik\"",
                           "line 8: bus.model: expected one of pci33, agp1x, agp2x, agp4x, got pci66"));
}

TEST(Config, ReportsARepeatedMessage) {
  const ParsedConfig parsed = parse_config("dsp { clock_khz: 1000 }\ndsp { framebuffer_mb: 64 }\n");
  EXPECT_THAT(texts(parsed.diagnostics), testing::ElementsAre("line 2: dsp: expected one value, got a second one"));
  EXPECT_EQ(parsed.config.dsp().clock_khz(), 1000u);
}

TEST(Config, ReportsAScalarWhereAMessageBelongs) {
  EXPECT_THAT(texts(parse_config("asic: 4\n").diagnostics),
              testing::ElementsAre(HasSubstr("line 1: asic: expected a message")));
  EXPECT_THAT(texts(parse_config("threads { }\n").diagnostics),
              testing::ElementsAre(HasSubstr("line 1: threads: expected")));
}

TEST(Config, ReportsBrokenStructureWithItsLine) {
  EXPECT_THAT(texts(parse_config("asic {\n  processors: 4\n").diagnostics),
              testing::ElementsAre("line 3: expected a field's name or \"}\", got the end of the text"));
  EXPECT_THAT(texts(parse_config("asic {}\n}\n").diagnostics),
              testing::ElementsAre("line 2: expected a field's name, got \"}\""));
  EXPECT_FALSE(parse_config(std::string("\x00\xff\x07{{{", 6)).diagnostics.empty());
  EXPECT_FALSE(parse_config("threads: \"never closed").diagnostics.empty());
}

TEST(Config, RefusesAHugeText) {
  EXPECT_THAT(texts(parse_config(std::string(std::size_t{2} << 20, ' ')).diagnostics),
              testing::ElementsAre(HasSubstr("at most")));
}

TEST(Config, RefusesATextThatIsNestedDeepWhereverThatIs) {
  const std::pair<const char*, const char*> kinds[] = {
      {"", "a{"}, {"", "a: <"}, {"asic { processors: ", "["}, {"fidelity: ", "[{"}, {"asik ", "{a "}, {"", "asic {"}};
  for (const auto& [before, one] : kinds) {
    std::string text = before;
    for (int i = 0; i < 120'000; ++i) text += one;
    EXPECT_THAT(texts(parse_config(text).diagnostics),
                testing::Contains("line 1: expected a value, got the end of the text"))
        << before << one;
  }
}

TEST(Config, AFaultShowsTheBeginningOfALongValue) {
  const std::string text = "asic { processors: \"" + std::string(200'000, 'x') + "\" }";
  const auto found = texts(parse_config(text).diagnostics);
  ASSERT_THAT(found, testing::SizeIs(1));
  EXPECT_THAT(found[0], AllOf(HasSubstr("asic.processors: expected a whole number"), HasSubstr("got \"xxx"),
                              testing::EndsWith("xxx...")));
  EXPECT_LT(found[0].size(), 200u);
}

TEST(Config, EndsOnATextFullOfFaults) {
  std::string text;
  for (int i = 0; i < 500; ++i) text += "threads: \"many\"\n";
  EXPECT_THAT(parse_config(text).diagnostics.size(), testing::AllOf(testing::Ge(2u), testing::Le(500u)));
}

TEST(Config, ChecksEveryRangeAtOnceWithItsLine) {
  const ParsedConfig parsed =
      parse_config("asic {\n processors: 17\n block_voxels: 48\n}\nbus { latency_timer_clocks: 7 }\n");
  ASSERT_THAT(texts(parsed.diagnostics), IsEmpty());
  EXPECT_THAT(texts(check(parsed.config, parsed.lines)),
              testing::UnorderedElementsAre("line 2: asic.processors: expected 1 to 16 processors, got 17",
                                            "line 3: asic.block_voxels: expected 8, 16, 32 or 64 voxels, got 48",
                                            "line 5: bus.latency_timer_clocks: expected 8 to 255 bus clocks, got 7"));
}

TEST(Config, AcceptsTheEndsOfEveryRange) {
  EXPECT_THAT(texts(check(with({"asic.processors=1", "asic.queue_rays=1", "asic.core_khz=1000", "dsp.clock_khz=1000",
                                "asic.max_volume_voxels=32", "asic.block_voxels=8", "dsp.framebuffer_mb=1",
                                "bus.max_burst_dwords=1", "bus.latency_timer_clocks=8", "bus.read_latency_clocks=0"}))),
              IsEmpty());
  EXPECT_THAT(
      texts(check(with({"asic.processors=16", "asic.queue_rays=4096", "asic.core_khz=1000000", "dsp.clock_khz=2000000",
                        "asic.max_volume_voxels=1024", "asic.block_voxels=64", "dsp.framebuffer_mb=1024",
                        "sdram.ranks=22", "bus.max_burst_dwords=1024", "bus.latency_timer_clocks=255",
                        "bus.read_latency_clocks=64", "bus.model=agp4x", "threads=1024"}))),
      IsEmpty());
}

TEST(Config, RefusesAVolumeThatIsNoPowerOfTwoOrSmallerThanABlock) {
  EXPECT_THAT(texts(check(with({"asic.max_volume_voxels=96"}))),
              testing::ElementsAre("asic.max_volume_voxels: expected a power of two, got 96"));
  EXPECT_THAT(texts(check(with({"asic.max_volume_voxels=32", "asic.block_voxels=64"}))),
              testing::ElementsAre("asic.max_volume_voxels: expected at least asic.block_voxels, 64 voxels, got 32"));
  EXPECT_THAT(texts(check(with({"asic.max_volume_voxels=2048"}))),
              testing::ElementsAre("asic.max_volume_voxels: expected 32 to 1024 voxels, got 2048"));
}

TEST(Config, ChecksThePartsOfTheCycleLevel) {
  EXPECT_THAT(texts(check(with({"cache.ways=3", "link.bits=257", "link.rays=1", "rdram.device_mbit=128",
                                "rdram.processors_per_rdram=3", "pipeline.prefetch_stages=0", "ideal.memory=2"}))),
              testing::UnorderedElementsAre(
                  "cache.ways: expected 1, 2, 4 or 8 ways, got 3", "link.bits: expected 1 to 256 bits, got 257",
                  "link.rays: expected 2 to 64 rays, got 1", "rdram.device_mbit: expected 144 or 288 Mbit, got 128",
                  "rdram.processors_per_rdram: expected 1 to 2 processors, got 3",
                  "pipeline.prefetch_stages: expected 1 to 256 core cycles, got 0",
                  "ideal.memory: expected 0 to 1 (0 or 1), got 2"));
  EXPECT_THAT(texts(check(with({"asic.partition=PARTITION_UNSPECIFIED", "sorter.policy=POLICY_UNSPECIFIED"}))),
              testing::UnorderedElementsAre(HasSubstr("asic.partition: expected one of simple_slab, repeated_slab"),
                                            HasSubstr("sorter.policy: expected one of most_rays, most_contribution")));
}

TEST(Config, TagsOfVoxelsAreOfADirectMappedCacheThatIsNotWrittenBack) {
  EXPECT_THAT(texts(check(with({"cache.tags=of_voxels", "cache.ways=2", "cache.write_policy=write_back"}))),
              testing::UnorderedElementsAre(
                  "cache.ways: expected 1 with cache.tags=of_voxels, got 2",
                  "cache.write_policy: expected combining or write_through with cache.tags=of_voxels, got write_back"));
  EXPECT_THAT(texts(check(with({"cache.tags=of_voxels", "cache.write_policy=write_through"}))), IsEmpty());
  EXPECT_THAT(texts(check(with({"cache.ports=3"}))), testing::ElementsAre("cache.ports: expected 1 to 2 ports, got 3"));
}

TEST(Config, RefusesACycleLevelVolumeThatItsMemoryChannelsCannotHold) {
  EXPECT_THAT(
      texts(check(with({"fidelity=cycle", "asic.max_volume_voxels=1024", "asic.processors=1"}))),
      testing::ElementsAre("asic.max_volume_voxels: expected a volume whose share of one RDRAM channel fits its 32 "
                           "devices, got 1024, which takes 180"));
  EXPECT_THAT(texts(check(with({"fidelity=cycle", "asic.max_volume_voxels=1024", "asic.processors=16"}))), IsEmpty());
  EXPECT_THAT(texts(check(with({"asic.max_volume_voxels=1024", "asic.processors=1"}))), IsEmpty());
  EXPECT_THAT(texts(check(with({"rdram.refresh_interval=63"}))),
              testing::ElementsAre("rdram.refresh_interval: expected 0 or at least 64 tCYCLE, got 63"));
}

TEST(Config, HasTwoLevelsAndTakesTheApproximateOneOfZeroTwoForCycle) {
  EXPECT_THAT(texts(check(with({"fidelity=cycle"}))), IsEmpty());
  EXPECT_THAT(texts(check(with({"fidelity=approximate"}))), IsEmpty());
  EXPECT_EQ(config_text(with({"fidelity=approximate"})), config_text(with({"fidelity=cycle"})));
  EXPECT_EQ(config_hash(with({"fidelity=approximate"})), config_hash(with({"fidelity=cycle"})));
  EXPECT_THAT(texts(check(with({"fidelity=FIDELITY_UNSPECIFIED", "bus.model=BUS_UNSPECIFIED"}))), testing::SizeIs(2));
}

TEST(Config, AnOverrideSetsOneField) {
  v1::BoardConfig config = with({"asic.processors=8", "bus.model=agp2x", "threads=3"});
  EXPECT_EQ(config.asic().processors(), 8u);
  EXPECT_EQ(config.bus().model(), v1::agp2x);
  EXPECT_EQ(config.threads(), 3u);
  EXPECT_FALSE(config.asic().has_queue_rays());
}

TEST(Config, AFaultyOverrideChangesNothingAndListsWhatIsKnown) {
  v1::BoardConfig config = with({"asic.processors=8"});
  const std::string before = config_text(config);
  EXPECT_THAT(texts(apply_override(config, "asic.procesors=4")),
              testing::ElementsAre(AllOf(HasSubstr("asic.procesors: expected one of processors, block_voxels, "),
                                         HasSubstr("got \"procesors\""))));
  EXPECT_THAT(texts(apply_override(config, "chip.processors=4")),
              testing::ElementsAre(HasSubstr("expected one of fidelity, asic, dsp, bus, sorter, pipeline, cache, link, "
                                             "memory, rdram, ddr, sdram, ideal, energy, pace, threads, got \"chip\"")));
  for (const char* bad :
       {"asic.processors", "=4", "asic=4", "threads.x=4", "asic.processors=", "asic.processors=4 5",
        "asic.processors=-4", "asic.processors=4294967296", "bus.model=isa", "asic..processors=1", "",
        "asic.processors=4}dsp{clock_khz:5000", "asic{processors:4}dsp.clock_khz=5000", "fidelity=cycle=cycle"}) {
    EXPECT_THAT(apply_override(config, bad), testing::SizeIs(1)) << bad;
  }
  EXPECT_EQ(config_text(config), before);
}

// Walks the messages of a configuration: is every scalar present?
bool is_complete(const google::protobuf::Message& message) {
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const auto* field = message.GetDescriptor()->field(i);
    if (!message.GetReflection()->HasField(message, field)) return false;
    const bool nested = field->message_type() != nullptr;
    if (nested && !is_complete(message.GetReflection()->GetMessage(message, field))) return false;
  }
  return true;
}

TEST(Config, ResolvingSetsEveryFieldAndKeepsWhatWasSet) {
  const v1::BoardConfig resolved = resolve(with({"asic.queue_rays=7"}));
  EXPECT_TRUE(is_complete(resolved));
  EXPECT_EQ(resolved.asic().queue_rays(), 7u);
  EXPECT_EQ(resolved.asic().block_voxels(), 32u);
  EXPECT_EQ(resolved.fidelity(), v1::functional);
}

TEST(Config, TheResolvedTextReadsBackAsTheSameConfiguration) {
  const v1::BoardConfig config = with({"asic.queue_rays=7", "bus.model=agp1x"});
  const ParsedConfig again = parse_config(config_text(config));
  EXPECT_THAT(texts(again.diagnostics), IsEmpty());
  EXPECT_EQ(again.config.SerializeAsString(), resolve(config).SerializeAsString());
}

TEST(Config, TheHashIgnoresOrderOfFieldsSpelledOutDefaultsAndThreads) {
  const ParsedConfig one = parse_config("asic { processors: 8 queue_rays: 64 } bus { model: agp2x }");
  const ParsedConfig two =
      parse_config("threads: 7 bus { model: agp2x } asic { queue_rays: 64 processors: 8 block_voxels: 32 }");
  EXPECT_EQ(config_hash(one.config), config_hash(two.config));
  EXPECT_EQ(config_hash(one.config), config_hash(resolve(one.config)));
  EXPECT_NE(config_hash(one.config), config_hash(v1::BoardConfig()));
}

// The hash stands in result files: it may change only with the schema or its defaults.
// What may be without: what no result and no simulated time depends on, and the level itself.
TEST(Config, EachFieldSaysWhereItsDefaultComesFrom) {
  std::vector<std::string> without;
  std::size_t sourced = 0;
  const auto look = [&](const auto& self, const google::protobuf::Descriptor& type, const std::string& path) -> void {
    for (int i = 0; i < type.field_count(); ++i) {
      const auto& field = *type.field(i);
      const std::string name = path + std::string(field.name());
      if (field.message_type() != nullptr) {
        self(self, *field.message_type(), name + '.');
      } else if (!field.options().HasExtension(v1::source)) {
        without.push_back(name);
      } else {
        ++sourced;
        EXPECT_THAT(field.options().GetExtension(v1::source),
                    testing::AnyOf(testing::StartsWith("paper §"), testing::StartsWith("datasheet "),
                                   testing::StartsWith("derived: "), testing::StartsWith("chosen: ")))
            << name;
      }
    }
  };
  look(look, *v1::BoardConfig::descriptor(), "");
  EXPECT_THAT(without, testing::UnorderedElementsAre("fidelity", "pace", "threads"));
  EXPECT_THAT(explained(with({"asic.processors=8"})),
              AllOf(HasSubstr("not modelled at this level; default 4: paper §4.1"),
                    HasSubstr("modelled at this level; chosen")));
  const std::string text = explained(with({"asic.processors=8", "fidelity=cycle"}));
  EXPECT_THAT(text, testing::Not(HasSubstr("not modelled")));
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(text, '\n')), sourced);
  EXPECT_THAT(
      text,
      HasSubstr("asic.processors                  8              1..16 processors              default 4: paper §4.1"));
  EXPECT_THAT(
      text,
      HasSubstr(
          "rdram.t_ras                      20             1..255 tCYCLE                 datasheet SPD of Samsung"));
}

TEST(Config, TheHashOfTheDesignPointIsStable) { EXPECT_EQ(config_hash_text(v1::BoardConfig()), "e61b93af4efd33d3"); }

TEST(Config, ChoosesTheMemoryByItsStandard) {
  v1::BoardConfig config = with({"memory=ddr", "fidelity=cycle"});
  EXPECT_EQ(config.memory(), v1::ddr);
  EXPECT_THAT(texts(check(config)), IsEmpty());
  EXPECT_EQ(v1::BoardConfig().memory(), v1::rdram);
  EXPECT_THAT(texts(apply_override(config, "memory=sdram")),
              testing::ElementsAre(HasSubstr("expected one of rdram, ddr")));
}

TEST(Config, RefusesWhatADdrChannelCannotHoldOrDo) {
  EXPECT_THAT(texts(check(with({"memory=ddr", "fidelity=cycle", "asic.max_volume_voxels=512"}))), IsEmpty());
  EXPECT_THAT(texts(check(with({"memory=ddr", "fidelity=cycle", "asic.max_volume_voxels=1024"}))),
              testing::ElementsAre(HasSubstr("one DDR channel fits its 4 devices")));
  EXPECT_THAT(texts(check(with({"ddr.refresh_interval=31"}))),
              testing::ElementsAre("ddr.refresh_interval: expected 0 or at least 32 clocks, got 31"));
  EXPECT_THAT(texts(check(with({"ddr.t_cl=0"}))), testing::ElementsAre("ddr.t_cl: expected 1 to 255 clocks, got 0"));
}

}  // namespace
}  // namespace gicube::emu
