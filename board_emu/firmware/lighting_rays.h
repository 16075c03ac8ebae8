// Generation of lighting rays by the DSP: k rays for each cell of the volume's faces, which together carry the energy
// that a light sends into the volume [P §2.2, eq. 1]. docs/reference/hardware.md compares the rules [H901, H902].
//
// A ray starts where its line enters the volume, or on a light inside it, and passes through a point of its cell.
// Positions are in voxels; distances, angles and areas are physical. A light in a face sends half its power into the
// volume, in an edge a quarter, in a corner an eighth.
//
// Energy of a ray, where E is the command's, A the cell's area, theta the angle to the face's normal, psi to the
// light's:
//   directional             E cos(theta) A / k
//   point, conserving       E omega / (4 pi k), omega the cell's exact solid angle
//   point, as printed       E cos(theta) A / (k pi r^2): four times too much; r at least half a cell's longest edge
//   rectangle, sphere       E cos(theta) cos(psi) A / (k pi r^2), each ray from another point of the light;
//                           less than four cell edges away: E cos(psi) omega / (k pi), uniform in solid angle, so
//                           bounded
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "firmware/face_cells.h"
#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "levels/dsp_task.h"
#include "words/words.h"

namespace gicube::emu {

// In words of 32 bits. Two numbers of a scrambled sequence (each 4 products of 32 by 32 bits, 3 multiplications, and 20
// operations); a point of the cell (2 products of 2); the path to it, its length and unit vector (3 squares of 3, root
// as for a viewing ray, 3 products of 2); the cell's solid angle (8 products of 3, an arc tangent by table: 4
// operations, 6 accesses); rounding of the energy (a hash of 4 products, 16 operations). 12 operations assemble the
// packet, 8 accesses send it.
inline constexpr DspLoop kMakeLightingRay{"lighting ray", 2 * 4 * 3 + 2 * 2 + 3 * 3 + 5 + 3 * 2 + 8 * 3 + 4 * 3,
                                          2 * 20 + 4 + 3 + 2 + 7 + 6 + 8 * 2 + 4 + 16 + 12, 2 + 1 + 6 + 8};

class LightingRays {
 public:
  // Returns the error of a command for a volume of `extent` (size - 1, 10.14 voxels), with the field's name, or nothing
  // if it is valid. The constructor requires a valid command.
  static std::optional<std::string> fault(const wire::IlluminateCommand& command, const Point& extent);

  // Like fault(), but only for kind, position, u and v.
  static std::optional<std::string> geometry_fault(const wire::IlluminateCommand& command);

  // `spacing`: voxel edges, 16.16. `energy_bits`: whole bits of the rays' energy words, 1..24.
  LightingRays(const wire::IlluminateCommand& command, const Point& extent, const std::array<std::uint32_t, 3>& spacing,
               unsigned energy_bits, std::uint32_t seed);

  // Maximum number of rays of this command: `command.count` for each face cell.
  std::uint64_t count() const { return cells_.count() * command_.count; }

  // Returns ray i < count(), in any order and from any thread; nothing where the light does not shine or where the
  // energy is rounded to zero. (v, u) is the ray's number in the whole pass, cell * k + first + ... The energy word has
  // 12 fraction bits, all 0. The caller sets lifetime and interaction. The energy is rounded up or down to a whole unit
  // at random, with the correct mean, and clipped at full scale.
  std::optional<wire::Ray> make(std::uint64_t i) const;

  // The energy of ray i before rounding.
  double energy(std::uint64_t i) const { return aim(i).energy; }

 private:
  struct Aim {
    Vector start{}, through{};  // physical
    double energy = 0;          // 0: no such ray
    std::uint32_t number = 0;
  };
  struct Emitter {
    Vector at{}, normal{};  // physical; a point light has no normal
  };

  // Random numbers of a ray, 0..1.
  struct Draws {
    std::uint32_t ray;
    std::uint64_t seed;
    std::array<double, 2> in_cell() const;
    std::array<double, 2> on_emitter() const;
  };

  Aim aim(std::uint64_t i) const;
  Aim aim_directional(const FaceCell& cell, const Draws& draws) const;
  Aim aim_from(const Emitter& emitter, const FaceCell& cell, const Draws& draws) const;
  // Whether the whole cell is behind the emitting rectangle.
  bool is_behind(const FaceCell& cell) const;
  Emitter emitter(const Draws& draws) const;
  bool is_inside(const Vector& physical) const;
  Vector on_cell(const FaceCell& cell, const std::array<double, 2>& across) const;

  wire::IlluminateCommand command_;
  FaceCells cells_;
  Point extent_;
  Vector spacing_{};
  Vector box_{};       // physical
  Vector position_{};  // physical
  Vector normal_{};    // of a rectangle
  double max_energy_;  // full scale of an energy word
  std::uint64_t seed_;
};

}  // namespace gicube::emu
