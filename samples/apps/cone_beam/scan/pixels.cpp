// Number and size of pixels, for a scan's file that has only views.
#include <fmt/format.h>

#include <regex>

#include "cone_beam/scan/formats.h"
#include "gicube/scene/volume_file.h"
#include "scene/common/checks.h"
#include "scene/formats/data_stream.h"

namespace gicube::samples {
namespace {

// Position of the first pixel by a MetaImage's header, which RTK's projections have.
void read_offset(const std::filesystem::path& file, Pixels& out) {
  static const std::regex kOffset(R"((^|\n)(Offset|Origin|Position) *= *(\S+) +(\S+))");
  const std::string start = file_start(file, 4096);
  std::smatch found;
  if (!std::regex_search(start, found, kOffset)) return;
  const auto u = parse_number<double>(found[3].str()), v = parse_number<double>(found[4].str());
  if (!u || !v) return;
  out.first_u = *u;
  out.first_v = *v;
}

}  // namespace

Pixels pixels_of(const StackFiles& projections, const PixelsGiven& given, const std::filesystem::path& file) {
  Pixels out{given.columns, given.rows, given.pitch, given.pitch};
  const bool none = projections.empty(), raw = projections.raw.has_value();
  expect(!(none || raw) || out.columns > 0, file, "projections",
         "some with a header, or the detector's pixels (--detector)", none ? "none" : "raw ones");
  const std::filesystem::path first = none ? "" : projections.files.front();
  const std::string extension = lower_case(first.extension().string());
  const bool meta = extension == ".mha" || extension == ".mhd";
  if (meta || extension == ".nrrd" || extension == ".nhdr" || extension == ".nii") {
    VolumeSource source;
    source.file = first;
    source.allow_outside = projections.allow_outside;
    const Volume volume = open_volume(source);
    const bool own = given.pitch == 0;
    out = {volume.dims[0], volume.dims[1], own ? volume.spacing.x : given.pitch, own ? volume.spacing.y : given.pitch};
  } else if (!none && !raw) {
    const Stack stack = read_stack({{first}, {}, projections.allow_outside});
    out = {stack.columns, stack.rows, given.pitch, given.pitch};
  }
  out.first_u = -(out.columns - 1) / 2.0 * out.pitch_u;
  out.first_v = -(out.rows - 1) / 2.0 * out.pitch_v;
  if (meta && given.pitch == 0) read_offset(first, out);
  return out;
}

}  // namespace gicube::samples
