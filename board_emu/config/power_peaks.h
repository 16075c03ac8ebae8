// The highest power of each part of a card, and of the whole card: the mean over a window of two milliseconds of the
// ASIC's work, since the host first read the counters. The host bus is omitted.
//
// Nothing is computed before that read. Afterwards all counters are read once per window.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "config/energy.h"
#include "gicube/archive.h"

namespace gicube::emu {

class PowerPeaks {
 public:
  // Core cycles between two reports of the cycle level's machine. Chosen: some thousand reports per second of the host.
  static constexpr std::uint64_t kReportCycles = 4096;

  PowerPeaks(const EnergyModel& model, std::uint64_t core_khz)
      : model_(model), core_khz_(core_khz), window_(kMilliseconds * core_khz) {}

  // Returns whether see() is to be called. Must be called every kReportCycles cycles of the ASIC.
  bool is_due() { return asked_ && ++reports_ * kReportCycles >= window_; }
  // `counters`: the board's, while a command runs.
  void see(const std::vector<wire::Counter>& counters) {
    if (cycles_of(counters) - since_ >= window_) end_window(counters);
  }
  // To be called when the host reads the counters. Before the end of the first window, the part that has passed counts
  // as a window.
  void ask(const std::vector<wire::Counter>& counters) {
    if (asked_ && peaks_.empty() && cycles_of(counters) > since_) end_window(counters);
    if (!asked_) begin_window(counters);
    asked_ = true;
  }
  // Appends energy.<part>.peak, .peak_low and .peak_high, in microwatts.
  void count(std::vector<wire::Counter>& counters) const {
    if (!asked_) return;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      const PartEnergy peak = peaks_.empty() ? PartEnergy{} : peaks_[i];
      const std::string name = std::string("energy.") + before_[i].part + ".peak";
      counters.push_back({name, "uW", peak.pj});
      counters.push_back({name + "_low", "uW", peak.low_pj});
      counters.push_back({name + "_high", "uW", peak.high_pj});
    }
  }
  void state(Archive& archive) {
    archive.field("asked", [this](Archive::Record& record) { record(asked_, reports_, since_); });
    parts_state(archive, "before", before_);
    parts_state(archive, "peaks", peaks_);
    if (archive.loads() && asked_ && before_.empty()) before_ = parts({});  // saved at the functional level
  }

 private:
  static constexpr std::uint64_t kMilliseconds = 2;  // chosen: a read of all counters takes 1% of a millisecond's time

  static std::uint64_t cycles_of(const std::vector<wire::Counter>& counters) {
    const auto found = std::ranges::find(counters, "asic.cycles", &wire::Counter::name);
    return found == counters.end() ? 0 : found->value;
  }
  void parts_state(Archive& archive, const char* name, std::vector<PartEnergy>& all) const {
    std::vector<std::uint64_t> numbers;
    for (const PartEnergy& each : all) numbers.insert(numbers.end(), {each.pj, each.low_pj, each.high_pj});
    archive.list(name, numbers);
    if (!archive.loads()) return;
    all = parts({});
    if (numbers.size() != 3 * all.size()) all.clear();
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i].pj = numbers[3 * i], all[i].low_pj = numbers[3 * i + 1], all[i].high_pj = numbers[3 * i + 2];
    }
  }
  // Without the host bus; the last part is the sum.
  std::vector<PartEnergy> parts(const std::vector<wire::Counter>& counters) const {
    std::vector<PartEnergy> parts = model_.of_machine(counters);
    if (parts.empty()) return parts;
    PartEnergy total{"total"};
    for (const PartEnergy& each : parts) total += each;
    parts.back() = total;
    return parts;
  }
  void begin_window(const std::vector<wire::Counter>& counters) {
    before_ = parts(counters);
    since_ = cycles_of(counters);
    reports_ = 0;
  }
  void end_window(const std::vector<wire::Counter>& counters) {
    const std::vector<PartEnergy> begin = std::move(before_);
    const std::uint64_t ns = (cycles_of(counters) - since_) * 1'000'000 / core_khz_;
    begin_window(counters);
    if (peaks_.empty()) peaks_.resize(before_.size());
    const auto raise = [ns](std::uint64_t& peak, std::uint64_t from, std::uint64_t to) {
      peak = std::max(peak, (to - std::min(from, to)) * 1000 / std::max<std::uint64_t>(ns, 1));
    };
    for (std::size_t i = 0; i < before_.size(); ++i) {
      raise(peaks_[i].pj, begin[i].pj, before_[i].pj);
      raise(peaks_[i].low_pj, begin[i].low_pj, before_[i].low_pj);
      raise(peaks_[i].high_pj, begin[i].high_pj, before_[i].high_pj);
    }
  }

  const EnergyModel& model_;
  std::uint64_t core_khz_, window_;  // window_: in cycles
  bool asked_ = false;
  std::uint64_t reports_ = 0;       // since the window's begin
  std::uint64_t since_ = 0;         // cycle of the window's begin
  std::vector<PartEnergy> before_;  // at the window's begin; empty at the functional level
  std::vector<PartEnergy> peaks_;   // in microwatts; empty before the first window's end
};

}  // namespace gicube::emu
