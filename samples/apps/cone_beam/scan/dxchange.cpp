// The layout: De Carlo and others, "Scientific data exchange: a schema for HDF5-based storage of raw and analyzed
// data", J. Synchrotron Rad. 21 (2014). It is for parallel beams, so a scan file gives the distances.
#include <numbers>

#include "cone_beam/scan/formats.h"

namespace gicube::samples {
namespace {

StackFiles data_set(const std::filesystem::path& file, const std::string& name) {
  return {.files = {file}, .raw = {}, .part = "/exchange/" + name};
}

// Empty if the file has no data set of this name.
Stack stack_of(const StackFiles& data_set) {
  try {
    return read_stack(data_set);
  } catch (const FileError& error) {
    if (error.field() != "part") throw;
    return {};
  }
}

}  // namespace

void take_dxchange(ScanDescription& scan) {
  const std::filesystem::path& file = scan.dxchange;
  scan.geometry.angles.clear();
  for (const float degrees : read_stack(data_set(file, "theta")).values) {
    scan.geometry.angles.push_back(static_cast<double>(degrees) * std::numbers::pi / 180);
  }
  scan.projections = data_set(file, "data");
  const StackFiles white = data_set(file, "data_white"), dark = data_set(file, "data_dark");
  Stack pixels = stack_of(white);
  scan.intensities = pixels.views() > 0;
  if (scan.intensities) {
    scan.flats = white;
    if (stack_of(dark).views() > 0) scan.darks = dark;
  } else {
    pixels = read_stack(scan.projections);
  }
  scan.geometry.detector.columns = pixels.columns;
  scan.geometry.detector.rows = pixels.rows;
}

}  // namespace gicube::samples
