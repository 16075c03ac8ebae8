// Marks what libgicube.so exports; all else in it is hidden. For C and C++. The headers of the C++ interface end an
// older C++ here, with one message; those of the C interface define GICUBE_C_INTERFACE around it.
#if defined(__cplusplus) && __cplusplus < 202002L && !defined(GICUBE_C_INTERFACE)
#error "gicube needs C++20: compile with -std=c++20, or use the C interface, gicube/c_api.h"
#define GICUBE_NEEDS_CXX20 "gicube needs C++20"
#include GICUBE_NEEDS_CXX20  // a file that is not there: no errors follow
#endif

#ifndef GICUBE_API
#if defined(__GNUC__)
#define GICUBE_API __attribute__((visibility("default")))
#define GICUBE_HIDDEN __attribute__((visibility("hidden")))
#else
#define GICUBE_API
#define GICUBE_HIDDEN
#endif
#endif
