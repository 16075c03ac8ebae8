#include "fault_plan.h"

#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include <array>
#include <cstdint>
#include <set>
#include <utility>

#include "config/text_schema.h"

namespace gicube::emu {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using v1::PlannedFault;
using v1::RandomFaults;

struct Range {
  std::uint64_t low, high;
  const char* unit;
};

constexpr Range kDelay{1, 60'000, "ms"};
constexpr Range kRate{1'000, 1'000'000'000, "bytes a second"};
constexpr Range kSlowMessages{1, 1'000'000, "messages"};
constexpr Range kMean{1, std::uint64_t{1} << 32, "messages"};
constexpr Range kMessage{1, ~std::uint64_t{0}, "(messages are counted from 1)"};

// Names that a plan of an earlier release may have.
constexpr std::array kRenamed{RenamedField{"most_faults", "max_faults"}, RenamedField{"most_delay_ms", "max_delay_ms"}};

// A field that some kinds use, and must have unless `may_be_left_out`.
struct Parameter {
  const char* field;
  Range range;
  bool may_be_left_out;
  std::vector<PlannedFault::Kind> kinds;
};

const std::vector<Parameter>& planned_parameters() {
  constexpr Range kAny{0, ~std::uint32_t{0}, ""};
  static const std::vector<Parameter> table{
      {"delay_ms", kDelay, false, {PlannedFault::delay}},
      {"bit", kAny, true, {PlannedFault::corrupt, PlannedFault::memory_detected, PlannedFault::memory_silent}},
      {"block", kAny, true, {PlannedFault::memory_detected, PlannedFault::memory_silent}},
      {"bytes_per_second", kRate, false, {PlannedFault::slow}},
      {"messages", kSlowMessages, false, {PlannedFault::slow}},
  };
  return table;
}

const std::vector<Parameter>& random_parameters() {
  static const std::vector<Parameter> table{
      {"max_delay_ms", kDelay, false, {PlannedFault::delay}},
      {"bytes_per_second", kRate, false, {PlannedFault::slow}},
      {"slow_messages", kSlowMessages, false, {PlannedFault::slow}},
  };
  return table;
}

class Check {
 public:
  explicit Check(const FieldLines& lines) : lines_(lines) {}

  std::vector<Diagnostic> take() { return std::move(found_); }

  void report(const std::string& where, const std::string& field, std::string expected, std::string got) {
    auto line = lines_.find(where + "." + field);
    if (line == lines_.end()) line = lines_.find(where);
    found_.push_back(
        {where + "." + field, std::move(expected), std::move(got), line == lines_.end() ? 0 : line->second});
  }

  // False, and reported, if the field is missing or holds no value of its kind.
  bool need(const std::string& where, const Message& message, const char* name) {
    const FieldDescriptor& field = *message.GetDescriptor()->FindFieldByName(name);
    const auto& reflection = *message.GetReflection();
    const bool is_set = reflection.HasField(message, &field);
    const bool is_enum = field.enum_type() != nullptr;
    if (is_set && (!is_enum || reflection.GetEnumValue(message, &field) != 0)) return true;
    report(where, name, expected_value(field), is_set ? reflection.GetEnum(message, &field)->name() : "nothing");
    return false;
  }

  void range(const std::string& where, const Message& message, const char* name, const Range& range) {
    const FieldDescriptor& field = *message.GetDescriptor()->FindFieldByName(name);
    const auto& reflection = *message.GetReflection();
    if (!reflection.HasField(message, &field)) return;
    const std::uint64_t value = field.cpp_type() == FieldDescriptor::CPPTYPE_UINT64
                                    ? reflection.GetUInt64(message, &field)
                                    : reflection.GetUInt32(message, &field);
    if (value >= range.low && value <= range.high) return;
    const std::string expected = range.high == ~std::uint64_t{0}
                                     ? fmt::format("at least {} {}", range.low, range.unit)
                                     : fmt::format("{} to {} {}", range.low, range.high, range.unit);
    report(where, name, expected, std::to_string(value));
  }

  // Every parameter that `kinds` use must be there, and no other.
  void parameters(const std::string& where, const Message& message, const std::vector<Parameter>& table,
                  const std::set<PlannedFault::Kind>& kinds) {
    for (const Parameter& parameter : table) {
      std::string users;
      bool used = false;
      for (const PlannedFault::Kind kind : parameter.kinds) {
        users += (users.empty() ? "" : ", ") + PlannedFault::Kind_Name(kind);
        used = used || kinds.contains(kind);
      }
      const FieldDescriptor& field = *message.GetDescriptor()->FindFieldByName(parameter.field);
      if (used) {
        if (!parameter.may_be_left_out) need(where, message, parameter.field);
        range(where, message, parameter.field, parameter.range);
      } else if (message.GetReflection()->HasField(message, &field)) {
        report(where, parameter.field, "it for no other kind than " + users, "it without use");
      }
    }
  }

 private:
  const FieldLines& lines_;
  std::vector<Diagnostic> found_;
};

void check_planned(const std::string& where, const PlannedFault& fault, Check& check) {
  check.need(where, fault, "direction");
  if (check.need(where, fault, "message")) check.range(where, fault, "message", kMessage);
  if (!check.need(where, fault, "kind")) return;
  if (is_memory_fault(fault.kind()) && fault.direction() == PlannedFault::up) {
    check.report(where, "direction", "down for " + PlannedFault::Kind_Name(fault.kind()), "up");
  }
  check.parameters(where, fault, planned_parameters(), {fault.kind()});
}

void check_random(const std::string& where, const RandomFaults& random, Check& check) {
  std::set<PlannedFault::Kind> kinds;
  bool only_memory = true;
  for (int i = 0; i < random.kinds_size(); ++i) {
    const PlannedFault::Kind kind = random.kinds(i);
    const std::string field = fmt::format("kinds[{}]", i);
    if (kind == PlannedFault::kind_unspecified) {
      check.report(where, field, expected_value(*PlannedFault::descriptor()->FindFieldByName("kind")),
                   PlannedFault::Kind_Name(kind));
    } else if (!kinds.insert(kind).second) {
      check.report(where, field, "each kind once", PlannedFault::Kind_Name(kind) + " a second time");
    }
    only_memory = only_memory && is_memory_fault(kind);
  }
  if (random.kinds().empty()) check.report(where, "kinds", "at least one kind of fault", "none");
  if (random.has_direction() && check.need(where, random, "direction") && !kinds.empty() && only_memory &&
      random.direction() == PlannedFault::up) {
    check.report(where, "direction", "down, since all its kinds are memory faults", "up");
  }
  if (check.need(where, random, "mean_messages")) check.range(where, random, "mean_messages", kMean);
  check.range(where, random, "first_message", kMessage);
  check.parameters(where, random, random_parameters(), kinds);
}

}  // namespace

bool is_memory_fault(PlannedFault::Kind kind) {
  return kind == PlannedFault::memory_detected || kind == PlannedFault::memory_silent;
}

ParsedFaultPlan parse_fault_plan(std::string_view text) {
  ParsedFaultPlan parsed;
  TextReading reading = read_text(text, parsed.plan, kRenamed);
  parsed.notes = std::move(reading.notes);
  parsed.diagnostics = std::move(reading.diagnostics);
  if (!parsed.diagnostics.empty()) return parsed;  // what could not be read would be missed once more
  Check check(reading.lines);
  std::set<std::pair<int, std::uint64_t>> taken;
  for (int i = 0; i < parsed.plan.fault_size(); ++i) {
    const PlannedFault& fault = parsed.plan.fault(i);
    const std::string where = fmt::format("fault[{}]", i);
    check_planned(where, fault, check);
    if (!fault.has_message() || taken.emplace(fault.direction(), fault.message()).second) continue;
    check.report(
        where, "message", "one fault for each message",
        fmt::format("a second one for {} {}", PlannedFault::Direction_Name(fault.direction()), fault.message()));
  }
  for (int i = 0; i < parsed.plan.random_size(); ++i) {
    check_random(fmt::format("random[{}]", i), parsed.plan.random(i), check);
  }
  parsed.diagnostics = check.take();
  return parsed;
}

std::string to_text(const PlannedFault& fault) {
  google::protobuf::TextFormat::Printer printer;
  printer.SetSingleLineMode(true);
  std::string text;
  printer.PrintToString(fault, &text);
  while (text.ends_with(' ')) text.pop_back();
  return "fault { " + text + " }";
}

}  // namespace gicube::emu
