#include "studies/results/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

namespace gicube::samples::results {
namespace {

constexpr double kPacketBytes = 16;    // of 9 bits
constexpr double kRayBytes = 32;       // [P §3.6]
constexpr double kClocksPerCycle = 4;  // tCYCLE a core cycle at the design point [P §3.3]
constexpr int kVoxelsASample = 8;      // of a trilinear neighbourhood
constexpr const char* kCauses = "processor.cycles.";

double count(const Measurement& m, const char* name) { return static_cast<double>(m.counters.value(name)); }

double cycles(const Measurement& m) { return count(m, "asic.cycles"); }
double pipeline_cycles(const Measurement& m) { return cycles(m) * m.processors; }
double seconds(const Measurement& m) { return ratio(cycles(m), m.core_hz); }

int memories(const Measurement& m) {
  int number = 0;
  while (m.counters.has("rdram" + std::to_string(number) + ".data_busy")) ++number;
  return number;
}

}  // namespace

double ratio(double part, double whole) { return whole == 0 ? 0 : part / whole; }

double frame_ms(const Measurement& m) { return to_ms(m.time); }
double rate_hz(const Measurement& m) { return ratio(1e3, frame_ms(m)); }
double asic_ms(const Measurement& m) { return 1e3 * seconds(m); }

double samples_per_second(const Measurement& m) { return ratio(count(m, "processor.samples"), seconds(m)); }
double throughput(const Measurement& m) { return ratio(count(m, "processor.samples"), pipeline_cycles(m)); }

double hit_ratio(const Measurement& m) {
  const double checks = count(m, "processor.cache.checks");
  return checks == 0 ? 0 : 1 - misses_a_sample(m) / kVoxelsASample;
}

double misses_a_sample(const Measurement& m) {
  return ratio(count(m, "processor.cache.missed_voxels"), count(m, "processor.cache.checks"));
}

std::vector<double> miss_histogram(const Measurement& m) {
  std::vector<double> shares;
  double all = 0;
  for (int misses = 0; misses <= kVoxelsASample; ++misses) {
    const std::string name = "processor.cache.samples_with_misses." + std::to_string(misses);
    shares.push_back(count(m, name.c_str()));
    all += shares.back();
  }
  for (double& share : shares) share = ratio(share, all);
  return shares;
}

double memory_gb_s(const Measurement& m) {
  const double packets = count(m, "rdram.reads") + count(m, "rdram.writes");
  return ratio(packets * kPacketBytes, seconds(m)) * 1e-9;
}

double memory_use(const Measurement& m) {
  return ratio(count(m, "rdram.data_busy"), cycles(m) * kClocksPerCycle * memories(m));
}

double memory_turnaround(const Measurement& m) {
  return ratio(count(m, "rdram.turnaround"), cycles(m) * kClocksPerCycle * memories(m));
}

double rays_sent(const Measurement& m) { return 100 * ratio(count(m, "link.rays_sent"), pipeline_cycles(m)); }
double links_busy(const Measurement& m) { return 100 * ratio(count(m, "link.busy"), 2 * pipeline_cycles(m)); }
double bisection_mb_s(const Measurement& m) {
  return ratio(count(m, "link.bisection_rays") * kRayBytes, seconds(m)) * 1e-6;
}

double balance_held(const Measurement& m) { return ratio(count(m, "processor.rays_held"), pipeline_cycles(m)); }
double balance_working(const Measurement& m) {
  return ratio(count(m, "processor.cycles.busy") + count(m, "processor.cycles.leap"), pipeline_cycles(m));
}

double work_balance(const Measurement& m) {
  std::vector<double> samples;
  for (int i = 0; i < m.processors; ++i) {
    samples.push_back(count(m, ("processor" + std::to_string(i) + ".samples").c_str()));
  }
  const Spread spread = spread_of(samples);
  return ratio(spread.mean, spread.max);
}

double dsp_use(const Measurement& m) { return ratio(to_ms(m.counters.value("dsp.busy_ps")), asic_ms(m)); }
double overflows_a_ray(const Measurement& m) { return ratio(count(m, "dsp.overflows"), count(m, "dsp.rays_taken")); }

std::vector<std::pair<std::string, double>> cause_shares(const Measurement& m) {
  std::vector<std::pair<std::string, double>> shares;
  double all = 0;
  for (const Counter& counter : m.counters.list()) {
    if (!counter.name.starts_with(kCauses)) continue;
    shares.emplace_back(counter.name.substr(std::string(kCauses).size()), static_cast<double>(counter.value));
    all += shares.back().second;
  }
  for (auto& [name, share] : shares) share = ratio(share, all);
  return shares;
}

Measurement sum_of(const Measurement& a, const Measurement& b) {
  if (a.processors == 0 || b.processors == 0) return {};
  Measurement sum = a;
  std::vector<Counter> list;
  for (const Counter& counter : b.counters.list()) {
    list.push_back({counter.name, counter.unit, counter.value + a.counters.value(counter.name)});
  }
  sum.counters = Counters(std::move(list));
  sum.time += b.time;
  sum.image = {};
  return sum;
}

double deposits_a_sample(const Measurement& m) {
  return ratio(count(m, "processor.splat.deposits"), count(m, "processor.samples"));
}
double tiles_a_deposit(const Measurement& m) {
  return ratio(count(m, "processor.splat.tiles"), count(m, "processor.splat.deposits"));
}
double tiles_combined(const Measurement& m) {
  return ratio(count(m, "processor.splat.tiles_combined"), count(m, "processor.splat.tiles"));
}
double scatterings_a_ray(const Measurement& m) {
  return ratio(count(m, "pipeline.scatterings"), count(m, "dsp.rays_taken"));
}
double memory_use_uncombined(const Measurement& m) {
  const double more =
      2 * count(m, "processor.splat.tiles") - count(m, "rdram.writes") - count(m, "processor.splat.tiles_fetched");
  return memory_use(m) + ratio(more, cycles(m) * memories(m));
}

std::vector<Stay> stays(const Measurement& m) {
  std::vector<Stay> list;
  double activations = 0, issued = 0;
  for (double turns = 1; turns < 1u << 21; turns *= 2) {
    const std::string size = std::to_string(static_cast<unsigned>(turns));
    list.push_back({turns, count(m, ("processor.sorter.activations_of_rays." + size).c_str()),
                    count(m, ("processor.sorter.issued_in_activations_of_rays." + size).c_str())});
    activations += list.back().activations, issued += list.back().issued;
  }
  for (Stay& stay : list)
    stay.activations = ratio(stay.activations, activations), stay.issued = ratio(stay.issued, issued);
  return list;
}

double issued_in_short_stays(const Measurement& m, double turns) {
  double share = 0;
  for (const Stay& stay : stays(m)) share += stay.turns < turns ? stay.issued : 0;
  return share;
}

std::vector<Millisecond> milliseconds(const Measurement& m) {
  std::map<int, Millisecond> by_time;
  const auto put = [&](const Counter& counter, std::string_view prefix, double Millisecond::*field) {
    if (counter.value == 0 || !counter.name.starts_with(prefix)) return;
    int ms = 0;
    std::from_chars(counter.name.data() + prefix.size(), counter.name.data() + counter.name.size(), ms);
    by_time[ms].*field = static_cast<double>(counter.value);
  };
  for (const Counter& counter : m.counters.list()) {
    put(counter, "asic.block_loads.ms", &Millisecond::loads);
    put(counter, "asic.samples.ms", &Millisecond::samples);
  }
  std::vector<Millisecond> list;
  if (by_time.empty()) return list;
  const int first = by_time.begin()->first;
  list.resize(static_cast<std::size_t>(by_time.rbegin()->first - first) + 1);
  for (const auto& [ms, value] : by_time) list[static_cast<std::size_t>(ms - first)] = value;
  return list;
}

std::string Spread::text(double unit, int digits) const {
  return fmt::format("{:.{}f} ({:.{}f} to {:.{}f})", mean / unit, digits, min / unit, digits, max / unit, digits);
}

Spread spread_of(const std::vector<double>& values) {
  if (values.empty()) return {};
  Spread spread{values.front(), 0, values.front()};
  for (const double value : values) {
    spread.min = std::min(spread.min, value);
    spread.max = std::max(spread.max, value);
    spread.mean += value / static_cast<double>(values.size());
  }
  return spread;
}

}  // namespace gicube::samples::results
