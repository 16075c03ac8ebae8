// What scatters rays of materials that the pipeline's scattering unit can't compute: routines on the DSP, and the host
// [P §2.2, §3.4].
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

// What a routine is told of a ray that waits for it. Directions are physical unit vectors.
struct ScatterEvent {
  std::array<double, 3> position{};   // voxels
  std::array<double, 3> direction{};  // of the ray
  std::array<double, 3> normal{};     // against the gradient; zero where there is none
  double opacity = 0;                 // of one voxel length there
  double density = 0;                 // 0..4095
  unsigned tag = 0;
  bool lighting = false;
  unsigned generation = 0;
  std::array<double, 4> random{};  // [0, 1), of this event alone
  std::span<const float> parameters;
};

struct ScatterAnswer {
  std::array<double, 3> direction{};  // physical, of a length from 1e-6 to 1e6
  double passes = 1;                  // share of the ray's energy that goes on, 0..1
  std::uint32_t cycles = 0;           // of the DSP
};

// A routine did what it must not; the command that needed it fails with this text, and the board goes on.
struct RoutineFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Routines {
 public:
  virtual ~Routines() = default;
  virtual bool has(std::uint8_t number) const = 0;
  // What is wrong with these parameters for routine `number`, or with the routine itself, if anything; asked before a
  // command's first ray. `number` must be one that has() names.
  virtual std::optional<std::string> fault(std::uint8_t number, std::span<const float> parameters) const = 0;
  // Pure: the same event gets the same answer. From several threads. Throws RoutineFault.
  virtual ScatterAnswer scatter(std::uint8_t number, const ScatterEvent& event) const = 0;
  // The same for as many events as there are answers: a routine in another process is asked once for many.
  virtual void scatter_all(std::uint8_t number, std::span<const ScatterEvent> events,
                           std::span<ScatterAnswer> answers) const {
    for (std::size_t i = 0; i < answers.size(); ++i) answers[i] = scatter(number, events[i]);
  }
};

// Where rays wait that the host must scatter.
class HostTrapQueue {
 public:
  virtual ~HostTrapQueue() = default;
  // From several threads. Throws RoutineFault if there are too many.
  virtual void add(const wire::TrappedRay& ray) = 0;
};

}  // namespace gicube::emu
