#include "firmware/routines/plug_in.h"

#include <algorithm>

namespace gicube::emu {

static_assert(kMaxParameters == wire::kMaterialParameters);

std::optional<std::string> fault(const RoutineDescription& description) {
  const auto expected = [](const std::string& field, const std::string& range, std::uint64_t got) {
    return field + ": expected " + range + ", got " + std::to_string(got);
  };
  if (description.abi != GICUBE_BSDF_ABI) return expected("abi", std::to_string(GICUBE_BSDF_ABI), description.abi);
  if (description.size < sizeof(gicube_bsdf)) {
    return expected("size", "at least " + std::to_string(sizeof(gicube_bsdf)), description.size);
  }
  if (description.name[0] == '\0') return "name: expected a text, got none";
  if (description.has_scatter == 0) return "scatter: expected a function, got null";
  if (description.cycle_budget < 1) return expected("cycle_budget", "at least 1", description.cycle_budget);
  if (description.cycles < 1 || description.cycles > description.cycle_budget) {
    return expected("cycles", "1.." + std::to_string(description.cycle_budget), description.cycles);
  }
  return std::nullopt;
}

std::unique_ptr<PlugIn> PlugIn::load(const std::string& file, bool is_boxed) {
  return std::unique_ptr<PlugIn>(new PlugIn(file, is_boxed));
}

PlugIn::PlugIn(const std::string& file, bool is_boxed)
    : process_(file, is_boxed), name_(printable(process_.description().name, kMaxName)), file_(file) {
  if (const auto what = emu::fault(process_.description())) throw PlugInFault(file + ": " + *what);
}

std::optional<std::string> PlugIn::fault(std::span<const float> parameters) const {
  if (process_.description().has_check == 0) return std::nullopt;
  int verdict = 0;
  std::string text;
  if (auto what = process_.check(parameters, verdict, text)) return what;
  if (verdict == 0) return std::nullopt;
  return text.empty() ? "it refuses its parameters and does not say why" : text;
}

void PlugIn::scatter(std::span<const ScatterEvent> events, std::span<ScatterAnswer> answers) const {
  for (std::size_t first = 0; first < answers.size(); first += kMaxEvents) {
    const std::size_t count = std::min(kMaxEvents, answers.size() - first);
    if (const auto what = process_.scatter(events.subspan(first, count), answers.subspan(first, count))) {
      throw RoutineFault(*what);
    }
  }
  const std::uint32_t budget = process_.description().cycle_budget;
  for (const ScatterAnswer& answer : answers) {
    if (answer.cycles >= 1 && answer.cycles <= budget) continue;
    throw RoutineFault("cycles: expected 1.." + std::to_string(budget) + ", got " + std::to_string(answer.cycles));
  }
}

}  // namespace gicube::emu
