// Volumes in files (docs/guide/formats.md lists the formats), or raw samples with a RawLayout, also gzipped (.gz). The
// ending of a file's name gives its format, or its contents do.
//
// If a file gives the directions of its axes in a world, samples are permuted and flipped on loading so that the
// volume's x, y and z run along the nearest axes of that world: to a patient's left, back (posterior) and head
// (superior), as in DICOM; along x, y and z otherwise. Volume::placement has the remaining rotation. If the file gives
// no directions, or with VolumeSource::as_stored, voxel (x, y, z) is the x-th sample of the y-th row of the z-th slice.
// Spacing is the voxel's edge on each axis: 1 if the file gives none, and the absolute value of a negative one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gicube/scene/error.h"
#include "gicube/scene/provenance.h"
#include "gicube/volume.h"

namespace gicube::scene {

constexpr int kMaxFileDim = 4096;  // chosen: voxels per axis, far more than a board holds
constexpr std::uint64_t kMaxVolumeBytes = std::uint64_t{8} << 30;  // chosen: of the samples, stored or converted

constexpr std::size_t voxels_of(const Dims& dims) {
  return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(dims[2]);
}

enum class WorldAxes {
  kNone,     // the file gives no directions of its axes
  kWorld,    // x, y, z of some space, with no patient in it
  kPatient,  // x to the patient's left, y to the back, z to the head (LPS)
};

// Where a volume lies in the world of its file: voxel p is at origin + the sum of p[i] * spacing[i] * directions[i].
struct WorldPlacement {
  WorldAxes axes = WorldAxes::kNone;
  std::array<Vec3, 3> directions{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // unit vectors of the volume's x, y, z in the world
  Vec3 origin;                             // the first voxel's centre in the world, in the file's unit of length
  std::array<int, 3> stored{1, 2,
                            3};  // the file's axis, from 1, along the volume's x, y, z; negative: it runs the other way
};

// The largest of the three angles between the volume's axes and those of the world, in degrees.
GICUBE_API double oblique_degrees(const WorldPlacement& placement);

struct Volume {
  // dims[0] * dims[1] * dims[2], x fastest, in the machine's byte order. Empty if there are `planes`.
  std::vector<std::byte> samples;
  PlaneReader planes;  // set by open_volume(): reads samples, called like VolumeStream::read; throws FileError
  std::vector<std::uint8_t> colours;  // three bytes per voxel, like VolumeView::colours; empty without colours
  PlaneReader colour_planes;          // set by open_volume(): to be called after `planes`, for the same planes
  SampleType type = SampleType::kUint8;
  Dims dims{};                      // voxels, 1..kMaxFileDim
  Vec3 spacing{1, 1, 1};            // the file's unit of length
  std::optional<ValueRange> range;  // unset: the driver's default for the type
  std::string source;               // the file or folder, for messages
  WorldPlacement placement;

  // Both point into this Volume. view() needs samples, stream() needs planes.
  VolumeView view() const { return {samples, type, dims, spacing, range, {}, {}, colours}; }
  VolumeStream stream() const { return {planes, type, dims, spacing, range, true, colour_planes}; }
};

// The layout of a file without a header.
struct RawLayout {
  Dims dims{};
  SampleType type = SampleType::kUint8;  // kUint12: 0..4095 in 16 bits
  Vec3 spacing{1, 1, 1};
  bool big_endian = false;
  std::uint64_t skip_bytes = 0;  // before the first sample

  friend bool operator==(const RawLayout&, const RawLayout&) = default;
};

constexpr std::uint64_t kMaxWholeBytes = std::uint64_t{256}
                                         << 20;  // chosen: the driver needs about three times as much in addition

constexpr int kMinBuckyballSize = 16, kMaxBuckyballSize = 1024;  // voxels along each edge

// Where a volume comes from.
struct VolumeSource {
  std::string builtin{};           // "buckyball", or empty
  std::filesystem::path file{};    // a file or a folder of slices
  int size = 256;                  // voxels along each edge, builtin only
  std::optional<RawLayout> raw{};  // headerless files only
  std::optional<Vec3> spacing{};   // in place of the file's
  bool allow_outside = false;      // a header may name a data file outside of its folder and those below
  bool as_stored = false;          // axes stay as stored; directions in the file are ignored
  // The name or number of a volume, if the file or folder has several; the error or warning without it lists them.
  std::string part{};
  std::optional<double> nan{};  // replaces samples that are no finite numbers
  // For set_up(): if the file has more than kMaxWholeBytes of samples, load() reads it in planes while sending it, and
  // SceneSetup has no samples.
  bool in_planes = false;

  friend bool operator==(const VolumeSource&, const VolumeSource&) = default;
};

// Types int8, int32, uint32, int64, uint64 and float64 become float32, and so do samples with a slope and intercept
// other than 1 and 0, which are applied. float32 samples stay as they are, NaNs included.
//
// Memory is allocated only if the file is large enough for its header. A file may be longer than its header says: the
// rest is ignored, with a warning if the file has data alone. A raw file must not be longer, because this reveals a
// wrong layout.
//
// Throws FileError: the file cannot be read, is truncated or damaged, has an unknown or impossible field (such as a
// spacing of 0, unless another is given), names a data file outside its folder, or exceeds kMaxFileDim or
// kMaxVolumeBytes; or a layout is given for a file that has a header.
// Not to be called from two threads at the same time: teem keeps its error texts in one place.
GICUBE_API Volume read_volume(const std::filesystem::path& path, const std::optional<RawLayout>& layout = std::nullopt);
// Reads a source's file.
GICUBE_API Volume read_volume(const VolumeSource& source);

// Opens a source's file. Volume::planes then reads the samples from the start of the file, so that the volume need not
// fit into memory: NRRD, MetaImage, NIfTI, numpy, TIFF, binary legacy VTK and raw samples, also compressed, and folders
// of slices. Samples of other formats, in text, in several files, or whose z axis changes place are read at once.
GICUBE_API Volume open_volume(const VolumeSource& source);

// The samples as numbers. The volume must have samples.
GICUBE_API std::vector<float> values_of(const Volume& volume);

// The volume's own range, or the driver's default for its type (VolumeView::range). NaNs are ignored.
GICUBE_API ValueRange value_range_of(const Volume& volume);

// A type's name in files and options, "uint8" to "float32". Throws InputError that names `field`.
GICUBE_API SampleType sample_type_named(const std::string& name, const std::string& field);

struct FloatVolume {
  Dims dims{};
  Vec3 spacing{1, 1, 1};          // voxel edges, > 0
  Vec3 origin;                    // of the first voxel's centre, in the world
  std::span<const float> values;  // x fastest
  int channels = 1;               // or 3, side by side for each voxel: light fields only
  // The axes, like WorldPlacement's. The world of NIfTI and MetaImage is always a patient: with other axes, x, y and z
  // are written as left, back and up, like ITK does.
  WorldAxes axes = WorldAxes::kWorld;
  std::array<Vec3, 3> directions{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

// Whether write_volume() knows the extension.
GICUBE_API bool is_volume_output(const std::filesystem::path& path);
// The extension gives the format: .nrrd, .mhd (samples in a .raw beside it), .mha, .nii, .nii.gz, .vti or .vdb. Reading
// returns the same values, spacing, origin and directions; NIfTI keeps all but the values as 32-bit floats, and
// declares millimetres in the scanner's space (qform and sform of code 1). MetaImage, VTI and VDB have no place for the
// provenance. A VDB has a grid "density" whose background is the first value. An existing file stays until the new one
// is complete. Throws FileError: another extension, a wrong number of values, a place that cannot be written to.
GICUBE_API void write_volume(const FloatVolume& volume, const std::filesystem::path& path,
                             const Provenance& provenance = {});

}  // namespace gicube::scene
