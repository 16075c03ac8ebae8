#include "levels/counters.h"

#include <string>
#include <unordered_map>

namespace gicube::emu {

void PartCounters::begin(const std::string& kind, std::size_t number) {
  if (kind != kind_) end_kind();
  kind_ = kind;
  prefix_ = kind + std::to_string(number) + '.';
  at_ = 0;
}

void PartCounters::put(const std::string& name, const char* unit, std::uint64_t value) {
  list_.push_back({prefix_ + name, unit, value});
  if (at_ == sums_.size()) sums_.push_back({kind_ + '.' + name, unit, 0});
  sums_[at_++].value += value;
}

void PartCounters::end_kind() {
  list_.insert(list_.end(), sums_.begin(), sums_.end());
  sums_.clear();
}

void add_counters(const std::vector<wire::Counter>& from, std::vector<wire::Counter>& to) {
  std::unordered_map<std::string, std::size_t> place;
  for (std::size_t i = 0; i < to.size(); ++i) place.emplace(to[i].name, i);
  for (const wire::Counter& counter : from) {
    if (const auto [at, is_new] = place.emplace(counter.name, to.size()); is_new) {
      to.push_back(counter);
    } else {
      to[at->second].value += counter.value;
    }
  }
}

void counters_state(Archive& archive, std::string_view name, std::vector<wire::Counter>& list) {
  std::vector<std::string> texts;
  std::vector<std::uint64_t> values;
  for (const wire::Counter& counter : list) {
    texts.push_back(counter.name);
    texts.push_back(counter.unit);
    values.push_back(counter.value);
  }
  archive.texts(std::string(name) + "_names", texts);
  archive.list(name, values);
  if (!archive.loads()) return;
  archive.expect(texts.size() == 2 * values.size(), name, "a value for each name and unit", values.size());
  list.clear();
  for (std::size_t i = 0; i < values.size(); ++i) list.push_back({texts[2 * i], texts[2 * i + 1], values[i]});
}

void add_run(RunResult& to, const RunResult& run, std::uint64_t core_khz) {
  to.cycles += run.cycles;
  to.asic_ps += cycles_to_ps(run.cycles, core_khz);
  to.dsp_cycles += run.dsp_cycles;
  to.made += run.made;
  to.rays += run.rays;
  to.cancelled = run.cancelled;
}

}  // namespace gicube::emu
