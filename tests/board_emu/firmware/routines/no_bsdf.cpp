// Shared objects, but none for the board.
#ifdef BSDF_NULL
extern "C" const void* gicube_bsdf_describe(void) { return nullptr; }
#else
extern "C" int gicube_something_else(void) { return 0; }
#endif
