// Ends the compilation of C++ that is older than the C++ interface, with one message. The C interface (gicube/c_api.h) needs none of it.
#pragma once

#if __cplusplus < 202002L
#error "gicube needs C++20: compile with -std=c++20, or use the C interface, gicube/c_api.h"
#define GICUBE_NEEDS_CXX20 "gicube needs C++20"
#include GICUBE_NEEDS_CXX20  // a file that is not there: no errors follow
#endif
