// Scattering by routines on the DSP, beyond the pipeline's scattering unit [P §2.2, §3.4] [H950-H953].
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "gicube/wire/material.h"
#include "gicube/wire/trap.h"

namespace gicube::emu {

// Input of a routine for a ray that waits for it. Directions are physical unit vectors.
struct ScatterEvent {
  std::array<double, 3> position{};   // voxels
  std::array<double, 3> direction{};  // direction of the ray
  std::array<double, 3> normal{};     // against the gradient; zero if that is zero
  double opacity = 0;                 // per voxel length
  double density = 0;                 // 0..4095
  unsigned tag = 0;
  bool lighting = false;
  unsigned generation = 0;
  std::array<double, 4> random{};  // [0, 1), for this event only
  std::span<const float> parameters;
};

struct ScatterAnswer {
  std::array<double, 3> direction{};  // physical, of a length from 1e-6 to 1e6
  double passes = 1;                  // fraction of the ray's energy that continues, 0..1
  std::uint32_t cycles = 0;           // DSP cycles
};

// A routine broke its contract. The command that needed it fails with this text; the board continues.
struct RoutineFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Routines {
 public:
  virtual ~Routines() = default;
  virtual bool has(std::uint8_t number) const = 0;
  // Describes an error in these parameters for routine `number`, or in the routine itself, if there is any. Called
  // before a command's first ray. Requires has(number).
  virtual std::optional<std::string> fault(std::uint8_t number, std::span<const float> parameters) const = 0;
  // Pure: the same event gives the same answer. May be called from several threads. Throws RoutineFault.
  virtual ScatterAnswer scatter(std::uint8_t number, const ScatterEvent& event) const = 0;
  // scatter() for as many events as there are answers: a routine in another process gets one request for many.
  virtual void scatter_all(std::uint8_t number, std::span<const ScatterEvent> events,
                           std::span<ScatterAnswer> answers) const {
    for (std::size_t i = 0; i < answers.size(); ++i) answers[i] = scatter(number, events[i]);
  }
};

}  // namespace gicube::emu
