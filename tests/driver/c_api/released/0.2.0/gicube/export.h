// Marks what libgicube.so exports; all else in it is hidden. For C and C++.
#pragma once

#if defined(__GNUC__)
#define GICUBE_API __attribute__((visibility("default")))
#define GICUBE_HIDDEN __attribute__((visibility("hidden")))
#else
#define GICUBE_API
#define GICUBE_HIDDEN
#endif
