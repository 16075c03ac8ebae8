// Converts rays of the host application to packets and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

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
  double energy_unit{};  // kDeposit, kBackproject: value of one unit of the words
  bool wide = false;     // kDeposit: the board's datapath, which limits a ray's energy
  View sampling{};       // to send the batch again, to a new board
  Vec3 towards_eye{};
  Vec3 spacing{1, 1, 1};                // of voxels
  ValueRange range{};                   // kIntegral
  std::size_t irradiance_words = 1;     // kDeposit
  std::vector<std::string> warnings{};  // kDeposit: for the report
};

// The STEP register: the longest step of a ray, 16.16 voxels.
std::uint32_t step_word(const View& view);

// Throw BadArgument naming the field: "rays[7].position.x: expected 0..31, got 32.5".
void check(const RayRequest& request);
void check(const HostRay& ray, std::size_t index, const RaySetup& setup);

// A checked opacity in 24 bits, not 0.
std::uint32_t opacity_word(double opacity);

wire::TraceHeader trace_header(const RayRequest& request, std::size_t rays);

// Position rounded to 1/16384 voxel; direction of unit length in voxel space, rounded to 1/16384. For a checked ray.
wire::Ray to_wire(const HostRay& ray, const RaySetup& setup);

// kIntegral: value of one unit of this ray's sum of densities.
double integral_unit(const HostRay& ray, const RaySetup& setup);
// kBackproject into sums: the most that a packet can change a sum (command.h). Otherwise 0.
std::uint64_t max_moved(const wire::Ray& packet, const RaySetup& setup);

// Converts a returned packet. The direction has unit length up to the board's rounding.
TracedRay from_wire(const wire::Ray& ray);
// Converts a kIntegral ray, with its integral_unit().
TracedRay integral_from_wire(const wire::Ray& ray, double unit);

}  // namespace gicube
