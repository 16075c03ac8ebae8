// Shared objects, but none for the board.
#include "gicube/bsdf.h"

#ifdef BSDF_NULL
extern "C" const gicube_bsdf* gicube_bsdf_describe(void) { return nullptr; }
#else
extern "C" int gicube_something_else(void) { return 0; }
#endif
