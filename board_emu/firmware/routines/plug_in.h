// A scattering routine from a shared object (gicube/bsdf.h).
//
// Its code runs in a process of its own (plug_in_process.h), and what it answers is checked.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "datapath/scattering.h"
#include "firmware/routines/plug_in_process.h"

namespace gicube::emu {

// What is wrong with a description, if anything.
std::optional<std::string> fault(const RoutineDescription& description);

class PlugIn {
 public:
  // Loads `file` and checks its description; `is_boxed`: as PlugInProcess's. Throws PlugInFault.
  static std::unique_ptr<PlugIn> load(const std::string& file, bool is_boxed = true);

  const std::string& name() const { return name_; }
  const std::string& file() const { return file_; }
  std::uint32_t cycles() const { return process_.description().cycles; }
  std::uint32_t cycle_budget() const { return process_.description().cycle_budget; }

  std::optional<std::string> fault(std::span<const float> parameters) const;
  // As many events as there are answers. Unchecked but for the cycles. Throws RoutineFault.
  void scatter(std::span<const ScatterEvent> events, std::span<ScatterAnswer> answers) const;

 private:
  PlugIn(const std::string& file, bool is_boxed);

  mutable PlugInProcess process_;
  std::string name_;
  std::string file_;
};

}  // namespace gicube::emu
