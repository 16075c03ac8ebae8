// Converts lights and materials to the board's records, and chooses the unit of their energy.
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
// The further record of a material, for boards with three irradiance words.
wire::ScatteringColour scattering_colour_record(const Material& material);
// Ks for red, green and blue.
std::array<double, 3> scattering_by_colour(const Material& material);

// A light's largest colour factor, to which its energy is normalised. 1 if the lights are white.
double brightest_of(const Illumination& settings, std::size_t light);
// Shares of red, green and blue in the energy: the register LIGHT_RED and the two after it.
std::array<std::uint32_t, 3> light_colour_words(const Illumination& settings, std::size_t light);

// The volume's box in physical space, from 0 to extent.
struct LitBox {
  Vec3 extent;
  Vec3 spacing;  // relative voxel edges
};

// Upper bounds, in units of a light's power: the energy of one of its rays, and the energy of all its rays that reach
// one voxel of the nearest face.
struct RayEnergy {
  double ray = 0;
  double voxel = 0;
};
RayEnergy max_energy(const Light& light, const Illumination& settings, const LitBox& box);

// Power per unit of area in the middle of the volume if nothing absorbed it.
double flux_in_the_middle(const Light& light, const Illumination& settings, const LitBox& box);

// Power of one unit of the energy words: as small as possible, so that neither the brightest ray overflows its word,
// nor a voxel of the nearest face that absorbs everything exceeds half of an irradiance word.
double energy_unit(std::span<const Light> lights, const Illumination& settings, const LitBox& box, bool wide);

// The lamps of a checked view. `exposure`: brightness of a unit of power per unit of area.
std::vector<wire::Lamp> lamp_records(const View& view, double exposure);

wire::IlluminateCommand light_command(const Light& light, const Illumination& settings, double unit);

}  // namespace gicube
