// From intensities to line integrals: what a pixel lost of the light that it would have without an object.
#pragma once

#include <cstddef>

#include "cone_beam/scan/stack.h"

namespace gicube::samples {

struct FlatFieldReport {
  std::size_t absorbed = 0;  // values without any light left, taken as half of the smallest that can be measured
  std::size_t dead = 0;      // pixels without light in the flat field; they get the mean of their neighbours in the row
};

// In place: -ln((p - dark) / (flat - dark)), flats and darks averaged. A p - dark below 1/2 where the views are whole numbers,
// below 1e-6 of flat - dark [C] where they are not, is counted as absorbed and taken as that. Empty `flats`: `full` everywhere;
// empty `darks`: 0. Throws InputError that begins with `flats`, `darks` or `full`: another size than the views', no light at all.
FlatFieldReport correct_flat_field(Stack& views, const Stack& flats, const Stack& darks, double full);

}  // namespace gicube::samples
