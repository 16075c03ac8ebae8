// A scattering routine from a shared object (gicube/bsdf.h).
//
// Its code runs in its own process (plug_ins/plug_in_process.h), which has a copy for each simultaneous call. Answers
// are checked. Whatever the code does, the board gets an answer or a fault.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "datapath/scattering.h"
#include "plug_ins/plug_in_process.h"

namespace gicube::emu {

// Returns the fault of a description, if it has one.
std::optional<std::string> fault(const RoutineDescription& description);

class PlugIn {
 public:
  // Loads `file` and checks its description; `is_boxed`: calls are made in a box (box/box.h). Throws PlugInFault.
  static std::unique_ptr<PlugIn> load(const std::string& file, bool is_boxed = true);

  const std::string& name() const { return name_; }
  const std::string& file() const { return file_; }
  std::uint32_t cycles() const { return description_.cycles; }
  std::uint32_t cycle_budget() const { return description_.cycle_budget; }

  // Returns the fault of these parameters, if there is one. Thread-safe, like scatter(). If the copy of the process for
  // a call ends or must be killed, the next call starts a new one.
  std::optional<std::string> fault(std::span<const float> parameters) const;
  // `events` and `answers` must have the same length, and an event at most kMaxParameters parameters. Only the cycles
  // of an answer are checked. Throws RoutineFault.
  void scatter(std::span<const ScatterEvent> events, std::span<ScatterAnswer> answers) const;

 private:
  class Claim;

  PlugIn(const std::string& file, bool is_boxed);

  bool order(SlotOrder::Kind kind, std::size_t slot) const;
  // Returns the fault of the call, if it had one.
  std::optional<std::string> call(Claim& claim, CallKind kind, std::uint32_t count) const;

  const PlugInProcess process_;
  const RoutineDescription description_;
  const std::string name_;
  const std::string file_;

  mutable std::atomic<unsigned> at_once_{0};  // maximum number of simultaneous calls so far

  struct alignas(64) SlotState {
    std::atomic<bool> is_taken{false};
    Patience patience{};
  };
  const std::unique_ptr<SlotState[]> slot_states_ = std::make_unique<SlotState[]>(kMaxCalls);
};

}  // namespace gicube::emu
