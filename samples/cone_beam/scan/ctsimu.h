// Scans in the JSON files of CTSimU (BAM): a scenario says where source, stage and detector stand and how the stage turns, metadata
// which raw files hold what and which volume is wanted, and where the scenario is. Format versions up to 1.2. Lengths become
// millimetres; the volume's coordinates are the stage's at the first angle.
#pragma once

#include <filesystem>

#include "cone_beam/scan/description.h"

namespace gicube::samples {

// Either file; a scenario has no projections and no volume. Throws FileError naming the key: one that is missing or of another type,
// an unknown unit, deviations or drifts, a parallel beam, a stage or detector that is tilted, a stage beside the ray that meets the
// detector squarely, an angle that is no number.
ScanDescription read_ctsimu(const std::filesystem::path& file);

}  // namespace gicube::samples
