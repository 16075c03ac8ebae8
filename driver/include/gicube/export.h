// Marks what libgicube.so shows to applications; everything else in it is hidden.
#pragma once

#if defined(__GNUC__)
#define GICUBE_API __attribute__((visibility("default")))
#else
#define GICUBE_API
#endif
