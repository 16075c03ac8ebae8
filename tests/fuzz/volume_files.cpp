// The volume readers: a file becomes a volume whose samples are all there, or a FileError.
#include <cmath>

#include "memory_file.h"
#include "scene/formats/readers.h"
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

void read(Bytes input, samples::Volume (*reader)(const std::filesystem::path&)) {
  const MemoryFile file(input);
  try {
    const samples::Volume volume = samples::with_spacing(reader(file.path()));
    std::size_t samples = 1;
    for (const int edge : volume.dims) {
      expect(edge >= 1 && edge <= samples::kMaxFileDim, "each edge has 1 to kMaxFileDim voxels");
      samples *= static_cast<std::size_t>(edge);
    }
    expect(volume.samples.size() == samples * sample_bytes(volume.type), "there are as many samples as voxels");
    for (const double edge : {volume.spacing.x, volume.spacing.y, volume.spacing.z}) {
      expect(edge > 0 && std::isfinite(edge), "spacing is positive and finite");
    }
  } catch (const samples::FileError&) {
  }
}

}  // namespace

void nrrd(Bytes input) {
  read(input, [](const std::filesystem::path& file) { return samples::read_nrrd(file); });
}
void nifti(Bytes input) { read(input, samples::read_nifti); }
void meta_image(Bytes input) {
  read(input, [](const std::filesystem::path& file) { return samples::read_meta_image(file); });
}

}  // namespace gicube::fuzz
