// Light in a board's volume: the irradiance words, and the sums of backprojection (Board::light()).
#pragma once

#include <span>
#include <vector>

#include "gicube/export.h"
#include "gicube/illumination.h"
#include "gicube/pending.h"
#include "gicube/volume.h"

namespace gicube {

struct BoardState;

class GICUBE_API Illuminator {
 public:
  explicit Illuminator(BoardState& of) : state_(&of) {}

  // Clears the irradiance and distributes the lights' energy by lighting rays; the simulated host waits. The irradiance
  // remains until the next illuminate(), loading or reset, for any number of renderings with View::irradiance.
  // Throws BadArgument (a light's index and field, settings), Rejected (no volume, no routine), Unsupported (the
  // application's scattering routine in a volume that the card does not store whole): the irradiance is incomplete.
  LightingReport illuminate(std::span<const Light> lights, const Illumination& settings, const Progress& progress = {});
  Pending<LightingReport> start(std::span<const Light> lights, const Illumination& settings);

  // One value per voxel of a box, or of the whole volume, x fastest, in units of the lights' power; with three
  // irradiance words a voxel's red, green and blue side by side. The simulated host waits for the transfer. Throws
  // Rejected before the first illuminate() or clear(), BadArgument (box).
  std::vector<float> read();
  std::vector<float> read(const VoxelBox& box);
  // Reads into the caller's memory. Throws BadArgument, too, if it has another size.
  void read(const VoxelBox& box, std::span<float> values);
  // Overwrites it, with as many values: words are rounded to the unit in force and saturate. Throws as read(), and
  // BadArgument (a value's index): the irradiance is unchanged. The simulated host waits for the transfer.
  void write(const VoxelBox& box, std::span<const float> values);
  // Sets the irradiance to zero, and one unit of its words to `unit` of the lights' power: for kDeposit rays and
  // write(). Words saturate at 2047, on the wide datapath at 2^32 - 1. Throws BadArgument, Rejected (no volume).
  void clear(double unit);

  // Sets the sums of kBackproject rays to zero, and one unit of them to `unit`, an energy times a length.
  // They are kept in addition to the volume until the next loading or reset. Throws BadArgument, Rejected (no volume).
  void clear_sums(double unit);
  // One sum per voxel, x fastest, of a box of the volume. Sums are clipped at 2^34 units; DepositReport counts them.
  // The simulated host waits for the transfer. Throws Rejected before the first clear_sums(), BadArgument (box).
  std::vector<float> read_sums(const VoxelBox& box);
  // Reads into the caller's memory. Throws BadArgument, too, if it has another size.
  void read_sums(const VoxelBox& box, std::span<float> values);

 private:
  BoardState* state_;
};

}  // namespace gicube
