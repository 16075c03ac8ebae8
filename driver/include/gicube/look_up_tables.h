// The tables by which a board classifies, shades and scatters (Board::tables()).
#pragma once

#include <span>

#include "gicube/export.h"
#include "gicube/material.h"
#include "gicube/scattering.h"
#include "gicube/shading.h"
#include "gicube/time.h"
#include "gicube/transfer_function.h"
#include "gicube/vector.h"

namespace gicube {

struct BoardState;

class GICUBE_API LookUpTables {
 public:
  explicit LookUpTables(BoardState& of) : state_(&of) {}

  // Sets colour and opacity of tag `tag` (0..3), a quarter of the segmentation LUT, and finds the empty flags. With a
  // volume the simulated host waits for that; a tag never set is invisible. Throws BadArgument: the board is untouched.
  void set_transfer_function(const TransferFunction& function, int tag = 0);

  // Phong coefficients and light of the next renderings. The reflectance map is made for each view's direction, and
  // sent when it changes. The simulated host waits for what must be sent at once. Throws BadArgument: the board is
  // untouched.
  void set_shading(const Shading& shading);

  // Sets the scattering of tag `tag` (0..3), at first none. Throws BadArgument: the board is untouched.
  void set_material(const Material& material, int tag = 0);

  // Scatters the rays that meet a material with kTrap and kHostRoutine, in light and in pictures with View::scatter.
  // 64 bytes of each come over the bus, 32 go back, and the simulated host works `time_per_ray` on it. The routine may
  // ask its Board for now() and info() only; calls that were started call it on a thread of the driver. Its exceptions
  // propagate out of the call that needed it; an invalid answer throws ScatteringFailed. In both cases rays that
  // had not ended are lost, the irradiance is incomplete, there is no picture, and the board is ready for the next
  // call. An empty routine removes the previous one.
  void set_scattering_routine(ScatteringRoutine routine, Picoseconds time_per_ray = 0);

  // Replaces the gradient codebook: at most 2048 unit directions, code 0 must be the zero vector ("no gradient").
  // The default has 40 latitude rings. Throws BadArgument, and Rejected once a volume is loaded: the board is
  // untouched.
  void set_gradient_codebook(std::span<const Vec3> codebook);

 private:
  BoardState* state_;
};

}  // namespace gicube
