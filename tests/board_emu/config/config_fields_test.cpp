// Nothing is ignored: for every field of the board's configuration a table says what each level makes of it, and each
// claim is tried on a board. A field that is not in the table fails the test.
#include <google/protobuf/descriptor.h>

#include <ostream>

#include "bare_board.h"
#include "config/config.h"
#include "gicube/fidelity_levels.h"
#include "machine_rig.h"
#include "test.h"

namespace gicube::emu {
namespace {

enum class Treatment {
  kTime,     // honoured: another value gives another simulated time
  kNoTime,   // this level has no such part, or no result depends on it: neither times nor values change
  kValues,   // honoured: another value gives other pixels
  kRefused,  // the configuration is refused, with the field's name
  kLimit,    // honoured: what does not fit is refused when it comes
};
using enum Treatment;

// The part of the scenario whose time a field changes.
enum Part : std::size_t { kTransfer, kRays, kLight, kContention, kParts };

struct Field {
  const char* name;
  const char* value;  // not the default
  Part part;
  Treatment functional, cycle;
  std::vector<std::string> with{};  // what else the board needs for the field to matter
};

void PrintTo(const Field& field, std::ostream* out) { *out << field.name << '=' << field.value; }

// Parts of the ASIC have no time at the functional level.
Field asic(const char* name, const char* value, std::vector<std::string> with = {}) {
  return {name, value, kRays, kNoTime, kTime, std::move(with)};
}
Field light(const char* name, const char* value, std::vector<std::string> with = {}) {
  return {name, value, kLight, kNoTime, kTime, std::move(with)};
}
Field everywhere(const char* name, const char* value, Part part, std::vector<std::string> with = {}) {
  return {name, value, part, kTime, kTime, std::move(with)};
}

const std::string kDdr = "memory=ddr", kSkewed = "asic.partition=skewed_block";

const std::vector<Field> kFields{
    asic("asic.processors", "3"),
    everywhere("asic.block_voxels", "16", kTransfer),  // whole blocks come over the bus
    // Eight blocks; the volume has twelve.
    {"asic.max_volume_voxels", "32", kRays, kLimit, kLimit, {"asic.block_voxels=16"}},
    asic("asic.queue_rays", "1"),
    asic("asic.core_khz", "50000"),
    asic("asic.partition", "skewed_block"),
    asic("asic.skew_x", "2", {kSkewed}),
    asic("asic.skew_y", "2", {kSkewed}),
    asic("asic.skew_z", "2", {kSkewed}),
    asic("asic.voxel_format", "rgb"),
    everywhere("asic.irradiance_words", "3", kLight),  // a ledger of each comes over the bus
    {"asic.datapath", "wide", kRays, kValues, kValues},
    everywhere("dsp.clock_khz", "100000", kRays),
    {"dsp.run_rays", "8", kRays, kValues, kValues},
    {"dsp.run_error", "16384", kRays, kValues, kValues, {"dsp.run_rays=8"}},
    asic("dsp.overflow_rays", "3"),
    {"dsp.framebuffer_mb", "1", kRays, kLimit, kLimit},
    everywhere("bus.model", "agp4x", kTransfer),
    everywhere("bus.max_burst_dwords", "4", kTransfer),
    everywhere("bus.latency_timer_clocks", "8", kContention),
    everywhere("bus.read_latency_clocks", "60", kTransfer),
    asic("sorter.queues", "single"),
    asic("sorter.policy", "most_contribution"),
    asic("pipeline.prefetch_stages", "3"),
    asic("pipeline.compute_stages", "3"),
    asic("cache.ways", "4"),
    asic("cache.miss_packets", "8"),
    light("cache.write_packets", "64"),
    light("cache.splat_rule", "all_samples"),
    light("cache.write_policy", "write_back"),
    light("cache.irradiance", "in_cells"),
    asic("cache.tags", "of_voxels"),
    asic("cache.ports", "2"),
    asic("link.bits", "1"),
    asic("link.rays", "2", {"link.bits=1"}),
    asic("memory", "ddr"),
    asic("rdram.processors_per_rdram", "2"),
    {"rdram.device_mbit", "144", kRays, kNoTime, kTime},
    asic("rdram.clock_khz", "200000"),
    asic("rdram.t_ras", "100"),
    asic("rdram.t_rp", "100"),
    asic("rdram.t_rr", "100"),
    asic("rdram.t_pp", "200"),
    asic("rdram.t_rcd", "100"),
    asic("rdram.t_cac", "100"),
    light("rdram.t_cwd", "200"),
    light("rdram.t_rtr", "200"),
    asic("rdram.t_offp", "200"),
    asic("rdram.refresh_interval", "64"),
    asic("rdram.rac_latency", "100"),
    asic("ddr.processors_per_channel", "2", {kDdr}),
    asic("ddr.clock_khz", "400000", {kDdr}),
    asic("ddr.t_ras", "100", {kDdr}),
    asic("ddr.t_rc", "100", {kDdr}),
    asic("ddr.t_rp", "100", {kDdr}),
    asic("ddr.t_rrd", "100", {kDdr}),
    asic("ddr.t_rcd", "100", {kDdr}),
    asic("ddr.t_cl", "100", {kDdr}),
    light("ddr.t_wr", "200", {kDdr}),
    light("ddr.t_wtr", "200", {kDdr}),
    asic("ddr.t_rfc", "100", {kDdr, "ddr.refresh_interval=200"}),
    asic("ddr.refresh_interval", "64", {kDdr}),
    asic("ddr.controller_latency", "100", {kDdr}),
    {"sdram.ranks", "7", kRays, kRefused, kRefused},
    asic("sdram.clock_khz", "25000"),
    asic("sdram.t_ras", "255", {"sdram.refresh_interval=200"}),
    asic("sdram.t_rc", "255", {"sdram.refresh_interval=200"}),
    asic("sdram.t_rp", "100"),
    asic("sdram.t_rrd", "100", {"asic.queue_rays=1"}),
    asic("sdram.t_rcd", "100"),
    asic("sdram.t_cl", "100"),
    asic("sdram.t_wr", "200", {"asic.queue_rays=1"}),
    asic("sdram.t_rfc", "100", {"sdram.refresh_interval=200"}),
    asic("sdram.refresh_interval", "64"),
    asic("sdram.controller_latency", "100"),
    asic("ideal.memory", "1"),
    asic("ideal.queues", "1", {"asic.queue_rays=1"}),
    asic("ideal.sorter", "1"),
    everywhere("ideal.dsp", "1", kRays),
    {"pace", "realtime", kRays, kNoTime, kNoTime},
    {"threads", "3", kRays, kNoTime, kNoTime},
};

std::vector<std::string> joined(std::vector<std::string> first, const std::vector<std::string>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

// A DSP that is fast enough for the ASIC to matter, and a volume of many blocks.
std::vector<std::string> board(const char* fidelity, const std::vector<std::string>& with) {
  return joined({std::string("fidelity=") + fidelity, "asic.block_voxels=8", "asic.max_volume_voxels=64",
                 "asic.processors=2", "dsp.clock_khz=1000000", "sdram.clock_khz=500000"},
                with);
}

struct Outcome {
  std::array<Picoseconds, kParts> time{};
  std::vector<wire::Pixel> image;
};

constexpr std::array<int, 3> kSize{40, 24, 24};

std::vector<wire::Ray> some_rays(int count) {
  std::vector<wire::Ray> rays;
  for (int i = 0; i < count; ++i) {
    rays.push_back(host_ray(static_cast<std::uint32_t>(i), {1 + i % 7 * 5.0, 2 + i % 5 * 4.0, 3 + i % 3 * 6.0},
                            {0.4 + i % 4, 0.3 + i % 3, 0.2 + i % 2}));
  }
  return rays;
}

Outcome carry_out(const v1::BoardConfig& config, int image_size = 28) {
  Outcome out;
  BareBoard board(config);
  std::uint64_t since = 0;
  const auto lap = [&](Part part) {
    out.time[part] = board.now_ps - since;
    since = board.now_ps;
  };
  board.load_volume(kSize, [](int x, int y, int z) {
    return wire::Voxel{static_cast<std::uint16_t>(90 * x + 7 * y + 3 * z), static_cast<std::uint16_t>(x * 7 % 2048), 0,
                       0};
  });
  const auto write_table = [&board] {
    board.write_segmentation([](unsigned, unsigned density) {
      return wire::SegmentationEntry{{4000, 3000, 2000}, static_cast<std::uint16_t>(density / 3), 40, 128, 128, 0};
    });
  };
  write_table();
  if (board.read_register(wire::reg::kStatus) != 0) throw std::runtime_error("the card does not take the volume");
  lap(kTransfer);
  out.image = board.render(corner_view(kSize, image_size));
  board.trace(some_rays(60));
  lap(kRays);
  wire::IlluminateCommand command;
  command.energy = 30'000;
  command.position = {19, 12, 13};
  command.rays_per_voxel = command.count = 1;
  const auto payload = wire::encoded(command);
  const Completion lit = board.wait(board.command(payload)).completions.at(0);
  EXPECT_EQ(lit.error, wire::ErrorCode::kNone) << std::string(lit.payload.begin(), lit.payload.end());
  lap(kLight);
  // Rays come back over the bus while the host writes.
  const std::uint32_t ticket = board.command(BareBoard::trace_payload(some_rays(2000)));
  for (int i = 0; i < 4; ++i) write_table();
  board.wait(ticket);
  board.read_register(wire::reg::kStep);
  lap(kContention);
  return out;
}

// Each board is tried once.
const Outcome& outcome(const std::vector<std::string>& assignments) {
  static std::map<std::vector<std::string>, Outcome> known;
  const auto found = known.find(assignments);
  return found != known.end() ? found->second : known[assignments] = carry_out(config_with(assignments));
}

void leaves(const google::protobuf::Descriptor& message, const std::string& prefix, std::set<std::string>& names) {
  for (int i = 0; i < message.field_count(); ++i) {
    const google::protobuf::FieldDescriptor& field = *message.field(i);
    const std::string name = prefix + field.name();
    if (field.cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) {
      leaves(*field.message_type(), name + '.', names);
    } else {
      names.insert(name);
    }
  }
}

TEST(ConfigFields, AreAllInTheTable) {
  std::set<std::string> in_schema, in_table{"fidelity"};  // whose values are the columns
  leaves(*v1::BoardConfig::descriptor(), "", in_schema);
  std::erase_if(in_schema, [](const std::string& name) { return name.starts_with("energy."); });  // energy_test.cpp
  for (const Field& field : kFields) EXPECT_TRUE(in_table.insert(field.name).second) << field.name << " stands twice";
  EXPECT_EQ(in_schema, in_table);
}

TEST(ConfigFields, OfFidelityGiveEachLevelItsOwnTimeAndTheSameValues) {
  const Outcome &functional = outcome(board("functional", {})), &cycle = outcome(board("cycle", {}));
  EXPECT_NE(functional.time[kRays], cycle.time[kRays]);
  EXPECT_EQ(functional.image, cycle.image);
}

// The list by which programs warn is what this table was tried for. Left out: fields of the host, and one that matters
// to coloured volumes.
TEST(ConfigFields, AreNotModelledWhereTheyChangeNothing) {
  const std::set<std::string> others{"pace", "threads", "asic.voxel_format"};
  for (const Field& field : kFields) {
    if (others.contains(field.name)) continue;
    EXPECT_EQ(is_modelled(kAtFunctional, field.name), field.functional != kNoTime) << field.name;
    EXPECT_EQ(is_modelled(kAtCycle, field.name), field.cycle != kNoTime) << field.name;
  }
}

class ConfigField : public testing::TestWithParam<Field> {};

bool names(const std::vector<Diagnostic>& faults, const std::string& field) {
  return std::any_of(faults.begin(), faults.end(),
                     [&](const Diagnostic& fault) { return to_string(fault).find(field) != std::string::npos; });
}

void expect(Treatment treatment, const char* fidelity, const Field& field) {
  SCOPED_TRACE(std::string(fidelity) + ": " + field.name + '=' + field.value);
  const std::string assignment = std::string(field.name) + '=' + field.value;
  const std::vector<std::string> usual = board(fidelity, field.with), changed = joined(usual, {assignment});
  switch (treatment) {
    case kTime: EXPECT_NE(outcome(changed).time[field.part], outcome(usual).time[field.part]); return;
    case kNoTime:
      EXPECT_EQ(outcome(changed).time, outcome(usual).time);
      EXPECT_EQ(outcome(changed).image, outcome(usual).image);
      return;
    case kValues: EXPECT_NE(outcome(changed).image, outcome(usual).image); return;
    case kRefused: {
      v1::BoardConfig config;
      for (const std::string& each : changed) ASSERT_TRUE(apply_override(config, each).empty()) << each;
      EXPECT_TRUE(names(check(config), field.name));
      return;
    }
    case kLimit:
      // A large image, which fits the usual sums' memory; its rays would take too long for the test.
      EXPECT_THROW(carry_out(config_with(changed), 1000), std::runtime_error);
      return;
  }
}

TEST_P(ConfigField, IsTreatedAsTheTableSays) {
  const Field& field = GetParam();
  expect(field.functional, "functional", field);
  expect(field.cycle, "cycle", field);
}

INSTANTIATE_TEST_SUITE_P(Of, ConfigField, testing::ValuesIn(kFields), [](const auto& test) {
  std::string name = test.param.name;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(ConfigFieldsOfLimits, LetAnImageThroughThatFits) {
  EXPECT_NO_THROW(carry_out(config_with(board("functional", {})), 1000));
}

}  // namespace
}  // namespace gicube::emu
