// The volume readers: a file becomes a volume whose samples are all there, or a FileError.
#include <cmath>

#include "memory_file.h"
#include "scene/formats/readers.h"
#include "scene/formats/volume_library.h"
#include "scene/names.h"

namespace gicube::fuzz {
namespace {

std::size_t sample_bytes(SampleType type) {
  switch (type) {
    case SampleType::kUint8: return 1;
    case SampleType::kFloat32: return 4;
    default: return 2;
  }
}

using Find = samples::StoredFile (*)(const std::filesystem::path&);

void expect_whole(const samples::Volume& volume) {
  std::size_t samples = 1;
  for (const int edge : volume.dims) {
    expect(edge >= 1 && edge <= samples::kMaxFileDim, "each edge has 1 to kMaxFileDim voxels");
    samples *= static_cast<std::size_t>(edge);
  }
  expect(volume.samples.size() == samples * sample_bytes(volume.type), "there are as many samples as voxels");
  for (const double edge : {volume.spacing.x, volume.spacing.y, volume.spacing.z}) {
    expect(edge > 0 && std::isfinite(edge), "spacing is positive and finite");
  }
}

void read(Bytes input, Find find) {
  const MemoryFile file(input);
  try {
    const samples::StoredFile found = find(file.path());
    const samples::Volume volume = samples::with_spacing(samples::read_stored(found));
    expect_whole(volume);
    const samples::Volume opened = samples::open_stored(found);
    if (!opened.planes) return;
    std::vector<std::byte> samples_in_planes(volume.samples.size());
    opened.planes(0, volume.dims[2], samples_in_planes);
    expect(samples_in_planes == volume.samples, "a file read in planes has the same samples");
  } catch (const samples::FileError&) {
  }
}

// A file whose reader returns the volume itself.
template <typename Read>
void read_whole(Bytes input, const Read& reader) {
  const MemoryFile file(input);
  try {
    expect_whole(samples::with_spacing(reader(file.path())));
  } catch (const samples::FileError&) {
  }
}

void read_with(Bytes input, const char* library) {
  read_whole(input, [library](const std::filesystem::path& file) { return samples::read_by(library, file, ""); });
}

}  // namespace

void dicom(Bytes input) { read_with(input, "dicom"); }
void hdf5(Bytes input) { read_with(input, "hdf5"); }
void openvdb(Bytes input) { read_with(input, "openvdb"); }
void vti(Bytes input) {
  read_whole(input, [](const std::filesystem::path& file) { return samples::read_vti(file); });
}
void nrrd(Bytes input) {
  read(input, [](const std::filesystem::path& file) { return samples::find_nrrd(file); });
}
void nifti(Bytes input) {
  read(input, [](const std::filesystem::path& file) { return samples::find_nifti(file); });
}
void numpy(Bytes input) {
  read(input, [](const std::filesystem::path& file) { return samples::find_numpy(file); });
}
void legacy_vtk(Bytes input) { read(input, samples::find_legacy_vtk); }
void meta_image(Bytes input) {
  read(input, [](const std::filesystem::path& file) { return samples::find_meta_image(file); });
}

}  // namespace gicube::fuzz
