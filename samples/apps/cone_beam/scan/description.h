// A scan's description before its projections are read: positions, files and their roles, and the stacks of views in
// them.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "cone_beam/geometry.h"
#include "gicube/scene/provenance.h"
#include "gicube/scene/volume_file.h"
#include "scene/names.h"

namespace gicube::samples {

// Throws FileError that names the field unless `good`.
inline void expect(bool good, const std::filesystem::path& file, const std::string& field, const std::string& expected,
                   const std::string& got) {
  if (!good) throw FileError(file, field, expected, got);
}

// Views in one or more files, in the order of the scan's angles: .nrrd .mhd .mha .nii volumes whose slices are views,
// .pfm and .tif images, folders of images, or raw samples. Rows as the files store them.
struct StackFiles {
  std::vector<std::filesystem::path> files;
  std::optional<RawLayout> raw;  // of files without a header; dims: columns, rows, and 0 for the views
  bool allow_outside = false;    // as that of VolumeSource
  std::string part{};            // of files of HDF5: the data set

  bool empty() const { return files.empty(); }
};

struct Stack {
  int columns = 0, rows = 0;
  std::vector<float> values;  // view by view, row by row as the files store them
  bool counts = false;        // they were whole numbers in the files

  std::size_t view_size() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  std::size_t views() const { return view_size() == 0 ? 0 : values.size() / view_size(); }
};

// All files' views, those of one file behind those of the one before. A raw file's views are as many as its bytes hold.
// Throws FileError: a file that can't be read, no whole number of views, views of different sizes, values that are not
// finite.
Stack read_stack(const StackFiles& files);

// By the extension: .nrrd, .mhd (with a .raw beside it), .mha or .raw (float32, little-endian) one file for all; .pfm,
// .tif or .tiff a file a view, NAME_0000.EXT beside `path`. The files that a StackFiles names to read so many views
// again.
std::vector<std::filesystem::path> stack_files(const std::filesystem::path& path, std::size_t views);
// Writes those, and returns them; pfm is little-endian, of scale 1. Throws FileError; no file is there then that was
// not before.
std::vector<std::filesystem::path> write_stack(const Stack& stack, const std::filesystem::path& path,
                                               const Provenance& provenance = {});

// Portable float maps of one channel: "Pf", width and height, a scale whose sign says the byte order (below 0:
// little-endian) and whose size is ignored. Rows stay in the file's order, which the format's own description lets run
// upwards and writers of projections downwards. Throws FileError: no such file, no header of one channel, too few or
// too many bytes.
Stack read_pfm(const std::filesystem::path& file);
struct ScanDescription {
  ScanDescription() { geometry.volume.spacing = {0, 0, 0}; }

  std::filesystem::path file;  // where it came from, for messages
  // Its angles or poses are those of the files' views: in any order, over any number of turns. What the scan leaves
  // open of the volume is 0.
  ConeGeometry geometry;
  Vec3 centre;                    // of the volume, in the scan's own coordinates; the geometry's origin
  bool columns_reversed = false;  // the files' first column is that of the greatest u
  bool rows_reversed = false;     // the files' first row is that of the greatest v, as where rows run downwards
  StackFiles projections;
  bool intensities = false;        // of the projections: else they are line integrals
  StackFiles flats, darks;         // averaged; only with intensities
  StackFiles dead;                 // one picture, whose pixels are not 0 where they are dead
  double full = 0;                 // the intensity of a ray that met nothing, where there is no flat
  std::filesystem::path dxchange;  // take_dxchange(): or empty

  std::vector<std::filesystem::path> inputs() const;  // the files that it was read from, and those that it names
};

}  // namespace gicube::samples
