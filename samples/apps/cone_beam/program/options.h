// The commands of gicube-cone-beam, and what they share.
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

// Each adds a command to the program. It throws UsageError, InputError, FileError, and what the driver throws.
void add_project(CLI::App& program);
void add_reconstruct(CLI::App& program);
void add_compare(CLI::App& program);
void add_import(CLI::App& program);

// Something whose values are known: a built-in phantom, or a volume file.
struct ObjectOptions {
  std::string name;
  double radius = 90;  // of a phantom, in the scan's unit
  double value = 1;    // of the sphere, and times a head's or discs' values
  bool allow_outside = false;
};
void add_object(CLI::App& app, ObjectOptions& object, const std::string& name, const std::string& what);

bool is_phantom(const ObjectOptions& object);
// Throws InputError if there is none of this name.
Phantom phantom_of(const ObjectOptions& object);

// A scan file or, without one, a scan that these numbers describe.
struct ScanOptions {
  std::filesystem::path input;
  std::vector<std::filesystem::path> projections;   // in place of the input's
  std::optional<SampleType> type;                   // of them, where they are raw
  std::optional<std::array<int, 2>> detector_size;  // of a scan of these numbers 256 x 256
  std::optional<double> pitch;                      // 1.56
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

// The scan that the options describe, its volume complete. Throws UsageError, FileError, InputError.
ScanDescription description_of(const ScanOptions& options);

struct GridValues {
  Grid grid;
  std::vector<float> values;
};
// Throws FileError: what read_volume() throws, a value that is not finite.
GridValues read_values(const std::filesystem::path& file, bool allow_outside);
// Centred on `centre`; nothing for an empty name. Throws FileError.
void write_values(const Grid& grid, Vec3 centre, std::span<const float> values, const Provenance& provenance,
                  const std::filesystem::path& file);
// For provenance.
std::uint64_t hash_of(std::span<const float> values);
// Throws UsageError unless the name is empty or write_values() knows its extension.
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

// The plane of voxels `index` along `axis`, black at grey[0] and white at grey[1]. Across runs x (y where the axis is
// x) to the right, up runs z (y where the axis is z).
Image slice_of(const Grid& grid, std::span<const float> values, int axis, int index, const std::array<double, 2>& grey);
// From the thousandth part of the values that is the least to the one that is the greatest [C].
std::array<double, 2> grey_range(std::span<const float> values);
// Writes NAME_x.png and so on, or NAME_z75.png for planes that were asked for. Throws InputError (an index beyond the
// volume), FileError.
void write_slices(const SliceOptions& options, const Grid& grid, std::span<const float> values,
                  const Provenance& provenance);

}  // namespace gicube::samples
