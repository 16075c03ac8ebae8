// A scattering routine from a shared object (gicube/bsdf.h).
//
// The object's code runs inside the board process with all its rights: whoever starts the board vouches for it. What it
// answers is checked and how long it takes is bounded; what it does to memory is not.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "datapath/scattering.h"
#include "gicube/bsdf.h"

namespace gicube::emu {

// The object can't be used; the text names the file and says why.
struct PlugInFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class PlugIn {
 public:
  // Loads `file` and checks its description. Throws PlugInFault.
  static std::unique_ptr<PlugIn> load(const std::string& file);
  // For a description that is linked in. Throws PlugInFault.
  PlugIn(const gicube_bsdf& description, std::string file);

  const std::string& name() const { return name_; }
  const std::string& file() const { return file_; }
  std::uint32_t cycles() const { return description_.cycles; }
  std::uint32_t cycle_budget() const { return description_.cycle_budget; }

  std::optional<std::string> fault(std::span<const float> parameters) const;
  // Unchecked but for the cycles. Throws RoutineFault.
  ScatterAnswer scatter(const ScatterEvent& event) const;

 private:
  std::string stuck() const;

  gicube_bsdf description_{};
  std::string name_;
  std::string file_;
  mutable std::atomic<bool> stuck_{false};  // it did not return once, and may hold its own locks for ever
};

}  // namespace gicube::emu
