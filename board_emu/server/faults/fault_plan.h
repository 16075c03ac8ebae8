// A board's fault plan: reads protobuf text, returns a complete and checked plan.
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
  v1::FaultPlan plan;  // valid only if there are no diagnostics
};

// Finds all faulty fields: unknown, missing, out of range, or unused for their kind; also two faults for one message.
ParsedFaultPlan parse_fault_plan(std::string_view text);

// Memory faults occur on the board, all others on the connection.
bool is_memory_fault(v1::PlannedFault::Kind kind);

// One line of plan text: "fault { direction: down message: 7 kind: corrupt bit: 12 }".
std::string to_text(const v1::PlannedFault& fault);

// Applies a fault plan to the messages of a board. The result depends only on plan, direction and message number.
class FaultEngine {
 public:
  FaultEngine() = default;  // without faults
  // `plan` must have passed parse_fault_plan().
  explicit FaultEngine(const v1::FaultPlan& plan);

  // Counts the next message of a direction, with `frame_bytes` including the header. Returns its fault with all
  // parameters.
  std::optional<v1::PlannedFault> next(v1::PlannedFault::Direction direction, std::size_t frame_bytes);

  // Progress; `hits` of each random rule, direction by direction.
  struct Counts {
    std::array<std::uint64_t, 2> messages{};  // indexed by lane()
    std::vector<std::uint64_t> hits;
  };
  Counts counts() const;
  // Returns false, and changes nothing, if the counts belong to another plan.
  bool set_counts(const Counts& counts);

  static std::size_t lane(v1::PlannedFault::Direction direction) { return direction == v1::PlannedFault::up ? 1 : 0; }
  // The last message of a direction; 0 before the first.
  std::uint64_t message(v1::PlannedFault::Direction direction) const { return lanes_[lane(direction)].message; }

 private:
  struct Random {
    v1::RandomFaults rule;
    std::uint64_t stream = 0;                   // start value of the random numbers
    std::vector<v1::PlannedFault::Kind> kinds;  // kinds that can affect a message of this direction
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
