// Converged shares of collimated light, falling straight on an isotropically scattering, index-matched slab, that come
// back and that pass (scattered or not), to 1e-4; and of half spaces, to 1e-5.
#pragma once

#include <array>

namespace gicube::reference {

struct SlabRow {
  double optical_thickness, albedo;
  double reflected, transmitted;
};

// clang-format off
inline constexpr std::array<SlabRow, 12> kSlabTable{{
    {.5, .5, .0729, .6743}, {.5, .9, .1691, .7653}, {.5, 1, .2025, .7975},
    {1, .5, .0991, .4462},  {1, .9, .2674, .5916},  {1, 1, .3413, .6587},
    {2, .5, .1129, .1893},  {2, .9, .3617, .3565},  {2, 1, .5174, .4826},
    {8, .5, .1153, .0008},  {8, .9, .4148, .0160},  {8, 1, .8218, .1782},
}};
// clang-format on

struct HalfSpaceRow {
  double albedo, reflected;
};

inline constexpr std::array<HalfSpaceRow, 4> kHalfSpaceTable{{{.5, .11523}, {.8, .28525}, {.9, .41495}, {.99, .75272}}};

}  // namespace gicube::reference
