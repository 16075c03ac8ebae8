// Lights as the DSP's commands, and the unit in which the board counts their energy.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gicube/illumination.h"
#include "gicube/material.h"
#include "gicube/view.h"
#include "gicube/wire/command.h"
#include "gicube/wire/material.h"

namespace gicube {

// Throw BadArgument naming the field.
void check(const Material& material);
void check(const Light& light, const std::string& name);  // "lights[2]"
// `lights`: how many there are. `irradiance_words`: 1 or 3.
void check(const Illumination& settings, std::size_t lights, int irradiance_words);

wire::Material material_record(const Material& material);
// With three irradiance words: what goes with it.
wire::ScatteringColour scattering_colour_record(const Material& material);
// Ks for red, green and blue.
std::array<double, 3> scattering_by_colour(const Material& material);

// A light's factor that is greatest; its power is that of this colour. 1 if lights have none.
double brightest_of(const Illumination& settings, std::size_t light);
// The parts of the energy of red, green and blue: the LIGHT_RED register and the two behind it.
std::array<std::uint32_t, 3> light_colour_words(const Illumination& settings, std::size_t light);

// The box of the volume as lights see it: physical, from 0 to extent.
struct LitBox {
  Vec3 extent;
  Vec3 spacing;  // relative voxel edges
};

// The most that a ray of a light carries, and that all bring to a voxel of the nearest face, in units of its power.
struct RayEnergy {
  double ray = 0;
  double voxel = 0;
};
RayEnergy max_energy(const Light& light, const Illumination& settings, const LitBox& box);

// Power that passes a voxel's face in the middle of the volume, were nothing in its way.
double flux_in_the_middle(const Light& light, const Illumination& settings, const LitBox& box);

// Power for one unit of the energy words: small enough that the brightest ray fills its word, and large enough that a
// voxel of the nearest face, absorbing all, stays at half of a saturated irradiance word.
double energy_unit(std::span<const Light> lights, const Illumination& settings, const LitBox& box, bool wide);

// The view's lamps; `exposure`: brightness of a unit of power on a unit of area. For a view that passed check().
std::vector<wire::Lamp> lamp_records(const View& view, double exposure);

wire::IlluminateCommand light_command(const Light& light, const Illumination& settings, double unit);

}  // namespace gicube
