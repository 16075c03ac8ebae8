// The commands of gicube-cone-beam.
#pragma once

#include "cone_beam/program/options.h"

namespace gicube::samples {

// Each throws UsageError, InputError, FileError, and what the driver throws.
void project(const ProjectOptions& options);
void reconstruct(const ReconstructOptions& options);
void compare(const CompareOptions& options);
void import(const ImportOptions& options);

}  // namespace gicube::samples
