// The SDK's version, for the preprocessor. It is written here alone: the build reads it.
#pragma once

#define GICUBE_VERSION_MAJOR 0
#define GICUBE_VERSION_MINOR 3
#define GICUBE_VERSION_PATCH 0

// 0x00MMmmpp, as gicube_version() of the C interface returns that of the library in use.
#define GICUBE_VERSION_NUMBER ((GICUBE_VERSION_MAJOR << 16) | (GICUBE_VERSION_MINOR << 8) | GICUBE_VERSION_PATCH)
