// Readers of cone-beam scans: a file becomes a description whose numbers are finite, or an error that names the file.
#include <cmath>

#include "cone_beam/scan/description.h"
#include "cone_beam/scan/formats.h"
#include "cone_beam/scan/scan.h"
#include "gicube/scene/error.h"
#include "memory_file.h"

namespace gicube::fuzz {
namespace {

void expect_description(const samples::ScanDescription& scan) {
  expect(scan.geometry.source_to_axis > 0 && scan.geometry.source_to_detector > 0, "distances are positive");
  expect(scan.geometry.detector.columns >= 1 && scan.geometry.detector.rows >= 1, "a detector has pixels");
  for (const double angle : scan.geometry.angles) expect(std::isfinite(angle), "angles are finite");
  const samples::SortedViews views = samples::sorted_views(scan.geometry.angles);
  std::size_t places = 0;
  for (std::size_t i = 0; i < views.angles.size(); ++i) {
    expect(i == 0 || views.angles[i] > views.angles[i - 1], "sorted angles ascend");
    places += views.places[i].size();
  }
  expect(places == scan.geometry.angles.size(), "each view has its angle");
}

}  // namespace

void cone_scan(Bytes input) {
  try {
    expect_description(samples::parse_scan(std::string(text_of(input)), "input", "no/such/folder"));
  } catch (const samples::InputError& error) {
    expect(std::string_view(error.what()).starts_with("input"), "a fault names its file first");
  }
}

void ctsimu(Bytes input) {
  const MemoryFile file(input);
  try {
    expect_description(samples::read_ctsimu(file.path()));
  } catch (const samples::FileError&) {
  }
}

void projection_matrix(Bytes input) {
  const MemoryFile file(input);
  try {
    const samples::ProjectionMatrix matrix = samples::read_projection_matrix(file.path());
    const gicube::ViewPose view = samples::pose_of(matrix, 64, 64, file.path());
    expect(std::isfinite(length(view.source)) && std::isfinite(length(view.centre)), "a view stands somewhere");
    expect(length(cross(view.u, view.v)) > 0, "a detector is flat");
  } catch (const samples::FileError&) {
  }
}

// RTK's geometries, Nikon's files and vectors of ASTRA, whichever the bytes are.
void orbit(Bytes input) {
  const MemoryFile file(input);
  try {
    expect_description(samples::read_description(file.path(), {}, {64, 64, 1}));
  } catch (const samples::InputError&) {
  }
}

void pfm(Bytes input) {
  const MemoryFile file(input);
  try {
    const samples::Stack map = samples::read_pfm(file.path());
    expect(map.columns >= 1 && map.rows >= 1, "a map has pixels");
    expect(map.values.size() == static_cast<std::size_t>(map.columns) * static_cast<std::size_t>(map.rows),
           "there are as many values as pixels");
  } catch (const samples::FileError&) {
  }
}

}  // namespace gicube::fuzz
