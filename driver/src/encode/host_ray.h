// Rays of the host application on their way to the board and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gicube/ray.h"
#include "gicube/vector.h"
#include "gicube/view.h"
#include "gicube/volume.h"
#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"

namespace gicube {

// Properties common to all rays of a batch.
struct RaySetup {
  RayRequest request{};
  Dims dims{};           // of the volume
  double energy_unit{};  // kDeposit, kBackproject: of one unit of the words
  bool wide = false;     // kDeposit: the board's datapath, which bounds a ray's energy
  View sampling{};       // what the batch is sampled by, should it have to be sent again
  Vec3 towards_eye{};
  Vec3 spacing{1, 1, 1};             // of voxels
  ValueRange range{};                // kIntegral
  std::size_t irradiance_words = 1;  // kDeposit
};

// A ray's step, 16.16 voxels, is at most this: the STEP register.
std::uint32_t step_word(const View& view);

// Throw BadArgument naming the field: "rays[7].position.x: expected 0..31, got 32.5".
void check(const RayRequest& request);
void check(const HostRay& ray, std::size_t index, const RaySetup& setup);

// 24 bits, not 0; of one that passed its check.
std::uint32_t opacity_word(double opacity);

wire::TraceHeader trace_header(const RayRequest& request, std::size_t rays);

// Position rounded to 1/16384 voxel; direction of unit length in voxel space, rounded to 1/16384. For a checked ray.
wire::Ray to_wire(const HostRay& ray, const RaySetup& setup);

// kIntegral: what one unit of the densities' sum is worth for this ray.
double integral_unit(const HostRay& ray, const RaySetup& setup);
// kBackproject: the most that a sum can move by a packet (command.h); 0 in other words.
std::uint64_t max_moved(const wire::Ray& packet, const RaySetup& setup);

// The direction as the board holds it: of unit length to its rounding.
TracedRay from_wire(const wire::Ray& ray);
// Converts a kIntegral ray, with its integral_unit().
TracedRay integral_from_wire(const wire::Ray& ray, double unit);

}  // namespace gicube
