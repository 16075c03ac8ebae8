// The routines of a board by number: 0 .. those that every board has, kFirstUserRoutine .. those of whoever started it.
//
// Set up before the first board has it, then only read: from any number of boards and threads.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "datapath/scattering.h"
#include "firmware/routines/plug_in.h"

namespace gicube::emu {

inline constexpr std::uint8_t kFirstUserRoutine = 8;
inline constexpr std::size_t kMaxUserRoutines = wire::kHostRoutine - kFirstUserRoutine;

struct RoutineInfo {
  std::uint8_t number = 0;
  std::string name;
  std::string file;  // empty: built in
  std::uint32_t cycles = 0;
  std::uint32_t cycle_budget = 0;
};

// What is wrong with an answer, if anything: a direction without a length, a share that is none.
std::optional<std::string> fault(const ScatterAnswer& answer);

class RoutineTable final : public Routines {
 public:
  // Gives the routine the next number. Throws PlugInFault, also when there is none left.
  void add(std::unique_ptr<PlugIn> plug_in);

  std::vector<RoutineInfo> list() const;

  bool has(std::uint8_t number) const override;
  std::optional<std::string> fault(std::uint8_t number, std::span<const float> parameters) const override;
  ScatterAnswer scatter(std::uint8_t number, const ScatterEvent& event) const override;

 private:
  const PlugIn* user(std::uint8_t number) const;
  std::string title(std::uint8_t number) const;

  std::vector<std::unique_ptr<PlugIn>> user_;
};

// A table of built-in routines only.
const RoutineTable& built_in_routines();

}  // namespace gicube::emu
