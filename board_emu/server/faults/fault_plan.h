// A board's fault plan: protobuf text in, a complete and checked plan out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "config/textproto_reader.h"
#include "gicube/v1/fault_plan.pb.h"

namespace gicube::emu {

struct ParsedFaultPlan : TextReading {
  v1::FaultPlan plan;  // may be used if there are no diagnostics
};

// Finds every faulty field: unknown, missing, out of its range, without use for its kind; and two faults for one message.
ParsedFaultPlan parse_fault_plan(std::string_view text);

// Memory faults happen on the board, all others on the way to or from it.
bool is_memory_fault(v1::PlannedFault::Kind kind);

// One line of plan text: "fault { direction: down message: 7 kind: corrupt bit: 12 }".
std::string to_text(const v1::PlannedFault& fault);

// What a fault plan does to the messages of a board: a pure function of plan, direction and message number.
class FaultEngine {
 public:
  FaultEngine() = default;  // no faults
  // `plan` must have passed parse_fault_plan().
  explicit FaultEngine(const v1::FaultPlan& plan);

  // Counts a direction's next message, of `frame_bytes` with its header: its fault, with all parameters.
  std::optional<v1::PlannedFault> next(v1::PlannedFault::Direction direction, std::size_t frame_bytes);

  // How far it has come; `hits` of each random part, direction by direction.
  struct Counts {
    std::array<std::uint64_t, 2> messages{};  // by lane()
    std::vector<std::uint64_t> hits;
  };
  Counts counts() const;
  // False, and nothing done, if they are of another plan.
  bool set_counts(const Counts& counts);

  static std::size_t lane(v1::PlannedFault::Direction direction) { return direction == v1::PlannedFault::up ? 1 : 0; }
  // The last message of a direction, 0 before the first.
  std::uint64_t message(v1::PlannedFault::Direction direction) const { return lanes_[lane(direction)].message; }

 private:
  struct Random {
    v1::RandomFaults rule;
    std::uint64_t stream = 0;                   // of random numbers
    std::vector<v1::PlannedFault::Kind> kinds;  // that can hit a message of this direction
    std::uint64_t hits = 0;
  };
  struct Lane {
    std::uint64_t message = 0;
    std::unordered_map<std::uint64_t, v1::PlannedFault> planned;
    std::vector<Random> random;
  };

  static std::optional<v1::PlannedFault> draw(Random& random, v1::PlannedFault::Direction direction,
                                              std::uint64_t message);

  std::array<Lane, 2> lanes_;
};

}  // namespace gicube::emu
