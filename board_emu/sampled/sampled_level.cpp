#include "sampled/sampled_level.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string_view>
#include <unordered_map>

#include "levels/counters.h"

namespace gicube::emu {

namespace {

constexpr std::uint64_t kMaxKinds =
    4096;  // of a checkpoint; by ray type and the binary digits of a count there are fewer

std::uint64_t kind_of(const RaySource& rays, const Frame& frame) {
  return static_cast<std::uint64_t>(frame.type) << 8 | static_cast<std::uint64_t>(std::bit_width(rays.count()));
}

// What the pipelines do for the rays, and the rays themselves.
double work_of(const RunResult& ran) { return static_cast<double>(ran.rays.samples + ran.rays.leaps + ran.made) + 1; }

std::vector<wire::Counter> counters_of(const Level& level) {
  std::vector<wire::Counter> list;
  level.count(list);
  return list;
}

void take_away(const std::vector<wire::Counter>& before, std::vector<wire::Counter>& list) {
  std::unordered_map<std::string_view, std::uint64_t> values;
  for (const wire::Counter& counter : before) values.emplace(counter.name, counter.value);
  for (wire::Counter& counter : list) {
    if (const auto found = values.find(counter.name); found != values.end()) counter.value -= found->second;
  }
}

// 0 for what a broken checkpoint says that is no number.
std::uint64_t whole(double value) {
  return value > 0 ? static_cast<std::uint64_t>(std::llround(std::min(value, 1e18))) : 0;
}

}  // namespace

SampledSeries& SampledLevel::series_of(std::uint64_t rays) {
  const auto found = std::ranges::find(kinds_, rays, &Kind::rays);
  if (found != kinds_.end()) return found->series;
  return kinds_.emplace_back(Kind{rays, {config_.sample_error() / 1000.0, rays}}).series;
}

RunResult SampledLevel::run(RaySource& rays, const Frame& frame, Progress& progress) {
  SampledSeries& series = series_of(kind_of(rays, frame));
  const bool simulates = cycle_.in_run() || series.simulates_next();
  const RunResult ran = simulates ? simulate(series, rays, frame, progress) : estimate(series, rays, frame, progress);
  if (ran.cancelled) return ran;
  ++totals_.commands;
  totals_.estimated += simulates ? 0 : 1;
  return ran;
}

RunResult SampledLevel::simulate(SampledSeries& series, RaySource& rays, const Frame& frame, Progress& progress) {
  if (!cycle_.in_run()) before_ = counters_of(cycle_);
  const RunResult ran = cycle_.run(rays, frame, progress);
  if (ran.cancelled) return ran;
  CommandCost sample{
      .work = work_of(ran), .dsp_cycles = static_cast<double>(ran.dsp_cycles), .counters = counters_of(cycle_)};
  take_away(before_, sample.counters);
  sample.took[kSampledCycles] = static_cast<double>(ran.cycles);
  for (const wire::Counter& counter : sample.counters) {
    const std::string_view name = counter.name;
    const auto value = static_cast<double>(counter.value);
    const bool of_memory = name.starts_with("rdram.") || name.starts_with("ddr.");
    if (of_memory && (name.ends_with(".reads") || name.ends_with(".writes"))) sample.took[kSampledPackets] += value;
    if (name == "processor.cache.missed_voxels") sample.took[kSampledMisses] += value;
  }
  series.simulated(sample);
  return ran;
}

RunResult SampledLevel::estimate(SampledSeries& series, RaySource& rays, const Frame& frame, Progress& progress) {
  RunResult ran = functional_.run(rays, frame, progress);
  if (ran.cancelled) return ran;
  const CommandCost sample = series.estimate(work_of(ran));
  ran.cycles = whole(sample.took[kSampledCycles]);
  ran.asic_ps = cycles_to_ps(ran.cycles, config_.asic().core_khz());
  ran.dsp_cycles = whole(sample.dsp_cycles);
  for (std::size_t q = 0; q < kSampledQuantities; ++q) totals_.took[q] += sample.took[q];
  add_counters(sample.counters, estimated_);
  return ran;
}

void SampledLevel::volume_changed() {
  cycle_.volume_changed();
  functional_.volume_changed();
}

void SampledLevel::reset() {
  totals_.within = within();
  kinds_.clear();
  cycle_.reset();
  functional_.reset();
}

RayCounters SampledLevel::rays() const {
  RayCounters sum = cycle_.rays();
  sum += functional_.rays();
  return sum;
}

SampledQuantities SampledLevel::within() const {
  SampledQuantities sum = totals_.within;
  for (const Kind& kind : kinds_) {
    for (std::size_t q = 0; q < kSampledQuantities; ++q) sum[q] += kind.series.within()[q];
  }
  return sum;
}

void SampledLevel::count(std::vector<wire::Counter>& list) const {
  std::vector<wire::Counter> mine = counters_of(cycle_);
  add_counters(estimated_, mine);
  add_counters(mine, list);
  const SampledQuantities within = this->within();
  list.push_back({"sampled.commands", "command", totals_.commands});
  list.push_back({"sampled.estimated_commands", "command", totals_.estimated});
  list.push_back({"sampled.estimated_cycles", "cycle", whole(totals_.took[kSampledCycles])});
  list.push_back({"sampled.cycles_within", "cycle", whole(std::ceil(within[kSampledCycles]))});
  list.push_back({"sampled.packets_within", "packet", whole(std::ceil(within[kSampledPackets]))});
  list.push_back({"sampled.missed_voxels_within", "voxel", whole(std::ceil(within[kSampledMisses]))});
}

void SampledLevel::state(Archive& archive, const std::array<int, 3>& blocks) {
  archive.within("cycle", [&] { cycle_.state(archive, blocks); });
  archive.within("functional", [&] { functional_.state(archive, blocks); });
  counters_state(archive, "before", before_);
  counters_state(archive, "estimated", estimated_);
  archive("totals", totals_);
  std::vector<std::uint64_t> rays;
  for (const Kind& kind : kinds_) rays.push_back(kind.rays);
  archive.list("kinds", rays, kMaxKinds);
  if (archive.loads()) {
    kinds_.clear();
    for (const std::uint64_t each : rays) series_of(each);
    archive.expect(kinds_.size() == rays.size(), "kinds", "each once", rays.size());
  }
  archive.parts("kind", kinds_);
}

}  // namespace gicube::emu
