#include <fmt/format.h>
#include <teem/nrrd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "scene/formats/file_error.h"
#include "scene/formats/readers.h"
#include "scene/formats/whole_file.h"
#include "scene/light_field.h"

namespace gicube::samples {
namespace {

std::string teem_error() {
  const std::unique_ptr<char, decltype(&std::free)> text(biffGetDone(NRRD), &std::free);
  return text ? text.get() : "an error of teem";
}

void describe(Nrrd* nrrd, const LightField& field, Vec3 spacing) {
  const bool coloured = field.channels == 3;
  std::size_t sizes[4] = {3};
  double spacings[4] = {std::nan("")};
  const unsigned first = coloured ? 1 : 0;
  const double edges[3] = {spacing.x, spacing.y, spacing.z};
  for (unsigned axis = 0; axis < 3; ++axis) {
    sizes[first + axis] = static_cast<std::size_t>(field.dims[axis]);
    spacings[first + axis] = edges[axis];
  }
  auto* values = const_cast<float*>(field.values.data());  // NOLINT(*-const-cast): teem only reads it
  if (nrrdWrap_nva(nrrd, values, nrrdTypeFloat, first + 3, sizes) != 0) return;
  nrrdAxisInfoSet_nva(nrrd, nrrdAxisInfoSpacing, spacings);
  if (coloured) nrrd->axis[0].kind = nrrdKindRGBColor;
}

}  // namespace

void write_light_field(const LightField& field, Vec3 spacing, const std::filesystem::path& path) {
  const std::unique_ptr<Nrrd, decltype(&nrrdNix)> nrrd(nrrdNew(), &nrrdNix);  // nix: the values stay ours
  const std::unique_ptr<NrrdIoState, decltype(&nrrdIoStateNix)> io(nrrdIoStateNew(), &nrrdIoStateNix);
  describe(nrrd.get(), field, spacing);
  io->format = nrrdFormatNRRD;
  io->encoding = nrrdEncodingGzip->available() != 0 ? nrrdEncodingGzip : nrrdEncodingRaw;
  const WholeFile file(path);
  if (nrrdSave(file.path().string().c_str(), nrrd.get(), io.get()) != 0) {
    throw FileError(path, "file", "a place to write to", teem_error());
  }
  file.rename();
}

LightField read_light_field(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path) || !is_nrrd(path)) {
    throw FileError(path, "file", "an NRRD file", "another or none");
  }
  LightField field;
  const Volume volume = read_nrrd_channels(path, field.channels);
  if (volume.type != SampleType::kFloat32) throw FileError(path, "type", "float", "integers");
  field.dims = volume.dims;
  field.dims[0] /= field.channels;
  field.values.resize(volume.samples.size() / sizeof(float));
  std::memcpy(field.values.data(), volume.samples.data(), volume.samples.size());
  for (const float value : field.values) {
    if (!(value >= 0 && std::isfinite(value))) {
      throw FileError(path, "values", "finite numbers, 0 or more", fmt::format("{}", value));
    }
  }
  return field;
}

}  // namespace gicube::samples
