// Commands of gicube-cone-beam, and their shared options.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cone_beam/phantom/phantom.h"
#include "cone_beam/scan/scan.h"
#include "gicube/image.h"
#include "gicube/scene/provenance.h"
#include "scene/program/board_options.h"
#include "scene/program/program.h"

namespace gicube::samples {

// Each adds a command to the program. The command throws UsageError, InputError, FileError, and what the driver throws.
void add_project(CLI::App& program);
void add_reconstruct(CLI::App& program);
void add_compare(CLI::App& program);
void add_import(CLI::App& program);

// An object with known values: a built-in phantom, or a volume file.
struct ObjectOptions {
  std::string name;
  double radius = 90;  // of a phantom, in the scan's unit
  double value = 1;    // of the sphere; factor of a head's or discs' values
  bool allow_outside = false;
};
void add_object(CLI::App& app, ObjectOptions& object, const std::string& name, const std::string& what);

bool is_phantom(const ObjectOptions& object);
// Throws InputError if there is none of this name.
Phantom phantom_of(const ObjectOptions& object);

// A scan file, or the numbers of a scan without one.
struct ScanOptions {
  std::filesystem::path input;
  std::vector<std::filesystem::path> projections;   // replace the input's
  std::optional<SampleType> type;                   // of raw projections
  std::optional<std::array<int, 2>> detector_size;  // default without an input: 256 x 256
  std::optional<double> pitch;                      // likewise 1.56
  double source_to_axis = 500, source_to_detector = 1000;
  int views = 180;
  double arc = 360;  // degrees
  std::optional<Dims> size;
  std::optional<Vec3> spacing;
  bool allow_outside = false;

  PixelsGiven pixels() const;
};
void add_input(CLI::App& app, ScanOptions& scan);     // SCAN, and the volume
void add_own_scan(CLI::App& app, ScanOptions& scan);  // --scan or its numbers, and the volume

// The scan of the options, with a complete volume. Throws UsageError, FileError, InputError.
ScanDescription description_of(const ScanOptions& options);

struct GridValues {
  Grid grid;
  std::vector<float> values;
};
// Throws FileError: what read_volume() throws, a value that is not finite.
GridValues read_values(const std::filesystem::path& file, bool allow_outside);
// Writes values centred on `centre`; does nothing for an empty name. Throws FileError.
void write_values(const Grid& grid, Vec3 centre, std::span<const float> values, const Provenance& provenance,
                  const std::filesystem::path& file);
// For provenance.
std::uint64_t hash_of(std::span<const float> values);
// Throws UsageError unless the name is empty or write_values() supports its extension.
void check_volume_name(const char* option, const std::filesystem::path& path);

// Planes of a volume as grey pictures.
struct SliceOptions {
  std::string name;  // NAME_x.png, NAME_y.png, NAME_z.png; empty: none
  std::optional<std::array<double, 2>> grey;
  std::vector<std::pair<int, int>> planes;  // axis and index; empty: the three in the middle

  std::filesystem::path file(int axis, int index) const;  // of a plane
  std::vector<Output> outputs() const;
};
void add_slices(CLI::App& app, SliceOptions& slices, const std::string& what);

// Picture of the plane of voxels `index` along `axis`, black at grey[0] and white at grey[1]. x runs to the right (y if
// the axis is x), and z upwards (y if the axis is z).
Image slice_of(const Grid& grid, std::span<const float> values, int axis, int index, const std::array<double, 2>& grey);
// The range of the values without the least and the greatest 1/1000 of them [C].
std::array<double, 2> grey_range(std::span<const float> values);
// Writes NAME_x.png and so on, or NAME_z75.png for chosen planes. Throws InputError (an index beyond the volume),
// FileError.
void write_slices(const SliceOptions& options, const Grid& grid, std::span<const float> values,
                  const Provenance& provenance);

}  // namespace gicube::samples
