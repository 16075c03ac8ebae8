// What gicube-photon-map is asked for.
#pragma once

#include <iosfwd>
#include <optional>

#include "photon_map/photon_map.h"
#include "scene/program/progress.h"
#include "transport/program/light_options.h"

namespace gicube::samples {

using PhotonOptions = LightOptions<PhotonSettings>;

// Nothing if help or the version was asked for and went to `out`. Throws UsageError with one line.
std::optional<PhotonOptions> parse_photon_options(int argc, const char* const* argv, std::ostream& out);

// Throws UsageError, InputError, FileError, and what Board throws.
void run(const PhotonOptions& options, ProgressLine& progress);

}  // namespace gicube::samples
