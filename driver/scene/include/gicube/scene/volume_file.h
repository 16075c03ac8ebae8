// Volumes in files (docs/guide/formats.md lists the formats), or raw samples, also gzipped (.gz), if a RawLayout says
// how they lie. The end of a file's name says its format, or else its contents do.
//
// If a file says how its axes lie in a world, samples are permuted and flipped on loading so that the volume's x, y and
// z run along the nearest axes of that world: to the left, to the back (posterior) and upwards (superior) of a patient,
// as in DICOM; along x, y and z otherwise. Volume::placement has what is left. Where the file says nothing, or with
// VolumeSource::as_stored, voxel (x, y, z) is the x-th sample of the y-th row of the z-th slice. Spacing is the voxel's
// edge on each axis; without any it is 1, a negative one counts as its absolute value.
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

constexpr int kMaxFileDim = 4096;  // chosen: voxels an axis, far above what a board holds
constexpr std::uint64_t kMaxVolumeBytes = std::uint64_t{8} << 30;  // chosen: of the samples, stored or converted

constexpr std::size_t voxels_of(const Dims& dims) {
  return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(dims[2]);
}

enum class WorldAxes {
  kNone,     // the file says nothing of its axes
  kWorld,    // x, y, z of some space, with no patient in it
  kPatient,  // x to the patient's left, y to the back, z to the head (LPS)
};

// Where a volume lies in the world of its file: voxel p is at origin + the sum of p[i] * spacing[i] * directions[i].
struct WorldPlacement {
  WorldAxes axes = WorldAxes::kNone;
  std::array<Vec3, 3> directions{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // of the volume's x, y, z in the world; unit vectors
  Vec3 origin;                             // the first voxel's centre in the world, in the file's unit of length
  std::array<int, 3> stored{1, 2,
                            3};  // the file's axis, from 1, along the volume's x, y, z; negative: it runs the other way
};

// How far the volume's axes are from those of the world, in degrees: the largest of the three angles.
GICUBE_API double oblique_degrees(const WorldPlacement& placement);

struct Volume {
  std::vector<std::byte>
      samples;         // dims[0] * dims[1] * dims[2], x fastest, the machine's byte order; none if there are:
  PlaneReader planes;  // of open_volume(): to be called as VolumeStream::read is; throws FileError
  std::vector<std::uint8_t> colours;  // of coloured slices: three bytes a voxel, as VolumeView::colours
  PlaneReader colour_planes;          // and of open_volume(): to be called after `planes`, for the same planes
  SampleType type = SampleType::kUint8;
  Dims dims{};                      // voxels, 1..kMaxFileDim
  Vec3 spacing{1, 1, 1};            // the file's unit of length
  std::optional<ValueRange> range;  // unset: the driver's default for the type
  std::string source;               // the file or folder, for messages
  WorldPlacement placement;

  // Points into this Volume. view(): of one with samples; stream(): with planes.
  VolumeView view() const { return {samples, type, dims, spacing, range, {}, {}, colours}; }
  VolumeStream stream() const { return {planes, type, dims, spacing, range, true, colour_planes}; }
};

// How the samples of a file without a header lie.
struct RawLayout {
  Dims dims{};
  SampleType type = SampleType::kUint8;  // kUint12: 0..4095 in 16 bits
  Vec3 spacing{1, 1, 1};
  bool big_endian = false;
  std::uint64_t skip_bytes = 0;  // before the first sample

  friend bool operator==(const RawLayout&, const RawLayout&) = default;
};

constexpr std::uint64_t kMaxWholeBytes = std::uint64_t{256}
                                         << 20;  // chosen: the driver takes some three times as much besides

constexpr int kMinBuckyballSize = 16, kMaxBuckyballSize = 1024;  // voxels an edge

// Where a volume comes from.
struct VolumeSource {
  std::string builtin{};           // "buckyball", or empty
  std::filesystem::path file{};    // a file or a folder of slices
  int size = 256;                  // voxels an edge, builtin only
  std::optional<RawLayout> raw{};  // headerless files only
  std::optional<Vec3> spacing{};   // in place of the file's
  bool allow_outside = false;      // a header may name a data file outside of its folder and those below
  bool as_stored = false;          // axes stay as the file has them, whatever it says of their directions
  // Which volume, if the file or folder has several: its name or number, as the error says that lists them.
  std::string part{};
  std::optional<double> nan{};  // replaces samples that are no finite numbers
  // For set_up(): a file with more than kMaxWholeBytes of samples is read in planes while load() sends it, and
  // SceneSetup has no samples.
  bool in_planes = false;

  friend bool operator==(const VolumeSource&, const VolumeSource&) = default;
};

// Types int8, int32, uint32, int64, uint64 and float64 become float32, and so does every NIfTI volume with a slope and
// intercept other than 1 and 0: its values are the scaled ones. float32 samples are taken as they are, NaNs included.
//
// Memory is taken only as far as the file's real size can back it. A file may be longer than its header says (the rest
// is ignored, with a warning if it is a file of data alone); a raw file may not, since a wrong layout shows just there.
//
// Throws FileError: the file can't be read, is truncated or damaged, has a field of no or impossible meaning (as a
// spacing of 0, where none is given in its place), names a data file outside, or exceeds kMaxFileDim or
// kMaxVolumeBytes. A layout for a file that has a header of its own is refused too.
// Not to be called from two threads at once: teem keeps its error texts in one place.
GICUBE_API Volume read_volume(const std::filesystem::path& path, const std::optional<RawLayout>& layout = std::nullopt);
// Reads a source's file.
GICUBE_API Volume read_volume(const VolumeSource& source);

// Opens a source's file, but reads samples when Volume::planes is called, from the start of the file on, so that the
// volume need not fit into memory: NRRD, MetaImage, NIfTI and raw samples, also compressed, and folders of slices.
// Samples in text are read at once.
GICUBE_API Volume open_volume(const VolumeSource& source);

// The samples as numbers. Of a volume with samples.
GICUBE_API std::vector<float> values_of(const Volume& volume);

// The volume's own range, or else the driver's default for its type (VolumeView::range). Not-a-numbers are left out.
GICUBE_API ValueRange value_range_of(const Volume& volume);

// A type's name in files and options, "uint8" to "float32". Throws InputError that names `field`.
GICUBE_API SampleType sample_type_named(const std::string& name, const std::string& field);

struct FloatVolume {
  Dims dims{};
  Vec3 spacing{1, 1, 1};          // voxel edges, > 0
  Vec3 origin;                    // of the first voxel's centre, in the world
  std::span<const float> values;  // x fastest
  int channels = 1;               // or 3, a voxel's side by side: of light fields only
  // The axes, like WorldPlacement's. Without a patient, NIfTI and MetaImage, whose world is always one, take x, y, z
  // for left, back and up, like ITK.
  WorldAxes axes = WorldAxes::kWorld;
  std::array<Vec3, 3> directions{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

// Whether write_volume() knows the extension.
GICUBE_API bool is_volume_output(const std::filesystem::path& path);
// By the extension: .nrrd, .mhd (samples in a .raw beside it), .mha, .nii, .nii.gz, .vti, .vdb. Values, spacing, origin
// and directions come back as they are, in NIfTI all but the values as 32-bit floats; NIfTI says that they are
// millimetres in the scanner's space (qform and sform of code 1). MetaImage, VTI and VDB have no place for the
// provenance. A VDB has a
// grid "density" whose background is the first value. A file that was there stays until the new one is whole.
// Throws FileError: another extension, a wrong number of values, a place that can't be written to.
GICUBE_API void write_volume(const FloatVolume& volume, const std::filesystem::path& path,
                             const Provenance& provenance = {});

}  // namespace gicube::scene
