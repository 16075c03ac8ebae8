// A board's fault plan: protobuf text in, a complete and checked plan out.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/textproto_reader.h"
#include "gicube/v1/fault_plan.pb.h"

namespace gicube::emu {

struct ParsedFaultPlan {
  v1::FaultPlan plan;
  std::vector<Diagnostic> diagnostics;  // what is wrong with the text; the plan may be used if this is empty
  std::vector<std::string> notes;       // for a log
};

// Reads and checks a plan. Every faulty field is found: unknown, missing, out of its range, without use for its kind, and
// two faults for one message.
ParsedFaultPlan parse_fault_plan(std::string_view text);

// Memory faults happen on the board, all others on the way to or from it.
bool is_memory_fault(v1::PlannedFault::Kind kind);

// One line of plan text: "fault { direction: down message: 7 kind: corrupt bit: 12 }".
std::string to_text(const v1::PlannedFault& fault);

}  // namespace gicube::emu
