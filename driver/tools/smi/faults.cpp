#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include <fstream>
#include <iostream>
#include <iterator>

#include "commands.h"
#include "json.h"

namespace gicube::smi {
namespace {

std::string read_plan(const std::string& path) {
  if (path == "-") return {std::istreambuf_iterator<char>(std::cin), {}};
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw UsageError(fmt::format("faults set: expected a readable file, got {}", path));
  return text;
}

void print_plan(const v1::FaultPlanInfo& plan) {
  if (plan.plan_text().empty()) {
    fmt::print("board {}: no fault plan\n", plan.board());
    return;
  }
  fmt::print("board {}: {} faults so far, in {} messages down and {} up, by this plan:\n{}{}", plan.board(),
             plan.faults(), plan.messages_down(), plan.messages_up(), plan.plan_text(),
             plan.plan_text().ends_with('\n') ? "" : "\n");
}

// The log as a plan: a fault a line.
void print_log(const v1::FaultLog& log) {
  google::protobuf::TextFormat::Printer printer;
  printer.SetSingleLineMode(true);
  for (const v1::PlannedFault& fault : log.faults()) {
    std::string text;
    printer.PrintToString(fault, &text);
    fmt::print("fault {{ {}}}\n", text);
  }
}

}  // namespace

int faults(const Options& options) {
  Client client(options);
  if (options.fault_action == FaultAction::kLog) {
    const v1::FaultLog log = client.fault_log(options.clear_log);
    if (options.json) {
      print(to_json(log));
    } else if (log.faults().empty()) {
      fmt::print("# board {}: no fault has happened\n", log.board());
    } else {
      print_log(log);
    }
    return 0;
  }
  const v1::FaultPlanInfo plan = options.fault_action == FaultAction::kShow ? client.fault_plan()
                                 : options.fault_action == FaultAction::kSet
                                     ? client.set_fault_plan(read_plan(options.plan_file))
                                     : client.set_fault_plan("");
  if (options.json) {
    print(to_json(plan));
  } else {
    print_plan(plan);
  }
  return 0;
}

}  // namespace gicube::smi
