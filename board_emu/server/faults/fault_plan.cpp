#include "fault_plan.h"

#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include <initializer_list>
#include <set>
#include <utility>

#include "gicube/wire/mix64.h"

namespace gicube::emu {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using v1::PlannedFault;
using v1::RandomFaults;

// A field that is used by some kinds of faults. They require it, unless `may_be_left_out`.
struct Parameter {
  const char* field;
  bool may_be_left_out;
  std::initializer_list<PlannedFault::Kind> kinds;
};
constexpr Parameter kParameters[] = {
    {"delay_ms", false, {PlannedFault::delay}},
    {"max_delay_ms", false, {PlannedFault::delay}},
    {"bit", true, {PlannedFault::corrupt, PlannedFault::memory_detected, PlannedFault::memory_silent}},
    {"block", true, {PlannedFault::memory_detected, PlannedFault::memory_silent}},
    {"bytes_per_second", false, {PlannedFault::slow}},
    {"messages", false, {PlannedFault::slow}},
    {"slow_messages", false, {PlannedFault::slow}}};

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

  // Returns false, and reports it, if the field is missing or its value is invalid.
  bool need(const std::string& where, const Message& message, const char* name) {
    const FieldDescriptor& field = *message.GetDescriptor()->FindFieldByName(name);
    if (message.GetReflection()->HasField(message, &field)) return in_range(where, message, name);
    report(where, name, expected_value(field), "nothing");
    return false;
  }

  bool in_range(const std::string& where, const Message& message, const char* name) {
    auto what = fault_of(message, *message.GetDescriptor()->FindFieldByName(name));
    if (what) report(where, name, std::move(what->expected), std::move(what->got));
    return !what;
  }

  // Requires the parameters of `kinds` and no others.
  void need_parameters(const std::string& where, const Message& message, const std::set<PlannedFault::Kind>& kinds) {
    for (const Parameter& parameter : kParameters) {
      const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(parameter.field);
      if (field == nullptr) continue;
      std::string users;
      bool used = false;
      for (const PlannedFault::Kind kind : parameter.kinds) {
        users += (users.empty() ? "" : ", ") + PlannedFault::Kind_Name(kind);
        used = used || kinds.contains(kind);
      }
      if (used) {
        if (!parameter.may_be_left_out) need(where, message, parameter.field);
      } else if (message.GetReflection()->HasField(message, field)) {
        report(where, parameter.field, "it only for " + users, "it for another kind");
      }
    }
  }

 private:
  const FieldLines& lines_;
  std::vector<Diagnostic> found_;
};

void check_planned(const std::string& where, const PlannedFault& fault, Check& check) {
  check.need(where, fault, "direction");
  check.need(where, fault, "message");
  if (!check.need(where, fault, "kind")) return;
  if (is_memory_fault(fault.kind()) && fault.direction() == PlannedFault::up) {
    check.report(where, "direction", "down for " + PlannedFault::Kind_Name(fault.kind()), "up");
  }
  check.need_parameters(where, fault, {fault.kind()});
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
  check.need(where, random, "mean_messages");
  check.in_range(where, random, "first_message");
  check.need_parameters(where, random, kinds);
}

// Random decisions for a message. Whether it is affected, the kind and the parameters are independent.
enum class Purpose : std::uint64_t { kHit, kKind, kFirst, kSecond };

std::uint64_t chance(std::uint64_t stream, std::uint64_t message, Purpose purpose) {
  return wire::split_mix64(wire::split_mix64(stream ^ message) ^ static_cast<std::uint64_t>(purpose));
}

}  // namespace

bool is_memory_fault(PlannedFault::Kind kind) {
  return kind == PlannedFault::memory_detected || kind == PlannedFault::memory_silent;
}

ParsedFaultPlan parse_fault_plan(std::string_view text) {
  ParsedFaultPlan parsed;
  static_cast<TextReading&>(parsed) = read_text(text, parsed.plan);
  if (!parsed.diagnostics.empty()) return parsed;  // unreadable fields would also be reported as missing
  Check check(parsed.lines);
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

FaultEngine::FaultEngine(const v1::FaultPlan& plan) {
  for (const PlannedFault& fault : plan.fault()) {
    lanes_[lane(fault.direction())].planned.emplace(fault.message(), fault);
  }
  for (std::uint64_t part = 0; const v1::RandomFaults& rule : plan.random()) {
    ++part;
    for (const PlannedFault::Direction direction : {PlannedFault::down, PlannedFault::up}) {
      if (rule.has_direction() && rule.direction() != direction) continue;
      // Rules with the same seed, and both directions of a rule, are independent.
      const std::uint64_t of_part = wire::split_mix64(wire::split_mix64(rule.seed()) ^ part);
      const std::uint64_t stream = wire::split_mix64(of_part ^ static_cast<std::uint64_t>(direction));
      Random random{rule, stream, {}};
      for (int i = 0; i < rule.kinds_size(); ++i) {
        if (direction == PlannedFault::down || !is_memory_fault(rule.kinds(i))) random.kinds.push_back(rule.kinds(i));
      }
      if (!random.kinds.empty()) lanes_[lane(direction)].random.push_back(std::move(random));
    }
  }
}

FaultEngine::Counts FaultEngine::counts() const {
  Counts counts;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    counts.messages[i] = lanes_[i].message;
    for (const Random& random : lanes_[i].random) counts.hits.push_back(random.hits);
  }
  return counts;
}

bool FaultEngine::set_counts(const Counts& counts) {
  if (counts.hits.size() != lanes_[0].random.size() + lanes_[1].random.size()) return false;
  std::size_t at = 0;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    lanes_[i].message = counts.messages[i];
    for (Random& random : lanes_[i].random) random.hits = counts.hits[at++];
  }
  return true;
}

std::optional<PlannedFault> FaultEngine::next(PlannedFault::Direction direction, std::size_t frame_bytes) {
  Lane& lane = lanes_[this->lane(direction)];
  const std::uint64_t message = ++lane.message;
  std::optional<PlannedFault> hit;
  // All rules draw for each message, so that a planned fault or another rule does not change later draws.
  for (Random& random : lane.random) {
    auto drawn = draw(random, direction, message);
    if (drawn && !hit) hit = std::move(drawn);
  }
  const auto planned = lane.planned.find(message);
  if (planned != lane.planned.end()) hit = planned->second;
  if (hit && hit->kind() == PlannedFault::corrupt) {
    hit->set_bit(static_cast<std::uint32_t>(hit->bit() % (frame_bytes * 8)));
  }
  return hit;
}

std::optional<PlannedFault> FaultEngine::draw(Random& random, PlannedFault::Direction direction,
                                              std::uint64_t message) {
  const v1::RandomFaults& rule = random.rule;
  const auto drawn = [&](Purpose purpose) { return chance(random.stream, message, purpose); };
  if (message < rule.first_message() || (rule.has_max_faults() && random.hits >= rule.max_faults())) return {};
  if (drawn(Purpose::kHit) % rule.mean_messages() != 0) return {};
  ++random.hits;
  PlannedFault fault;
  fault.set_direction(direction);
  fault.set_message(message);
  fault.set_kind(random.kinds[drawn(Purpose::kKind) % random.kinds.size()]);
  const std::uint64_t first = drawn(Purpose::kFirst), second = drawn(Purpose::kSecond);
  switch (fault.kind()) {
    case PlannedFault::delay: fault.set_delay_ms(static_cast<std::uint32_t>(1 + first % rule.max_delay_ms())); break;
    case PlannedFault::corrupt: fault.set_bit(static_cast<std::uint32_t>(first)); break;
    case PlannedFault::slow:
      fault.set_bytes_per_second(rule.bytes_per_second());
      fault.set_messages(rule.slow_messages());
      break;
    case PlannedFault::memory_detected:
    case PlannedFault::memory_silent:
      fault.set_block(static_cast<std::uint32_t>(first));
      fault.set_bit(static_cast<std::uint32_t>(second));
      break;
    default: break;
  }
  return fault;
}

}  // namespace gicube::emu
