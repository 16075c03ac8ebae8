// Description of a scan before its projections are read: positions, files, and the stacks of views in them.
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

// Throws FileError with the field's name unless `good`.
inline void expect(bool good, const std::filesystem::path& file, const std::string& field, const std::string& expected,
                   const std::string& got) {
  if (!good) throw FileError(file, field, expected, got);
}

// Views in one or more files, in the order of the scan's angles: .nrrd .mhd .mha .nii volumes whose slices are views,
// .pfm and .tif images, folders of images, or raw samples. Rows are in the files' order.
struct StackFiles {
  std::vector<std::filesystem::path> files;
  std::optional<RawLayout> raw;  // for files without a header; dims: columns, rows, and 0 for the views
  bool allow_outside = false;    // see VolumeSource
  std::string part{};            // data set in HDF5 files

  bool empty() const { return files.empty(); }
};

struct Stack {
  int columns = 0, rows = 0;
  std::vector<float> values;  // by views, then rows in the files' order
  bool counts = false;        // the files have integers

  std::size_t view_size() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  std::size_t views() const { return view_size() == 0 ? 0 : values.size() / view_size(); }
};

// Reads the views of all files, in the order of the files. The size of a raw file gives its number of views. Throws
// FileError: a file that can't be read, a fractional number of views, views of different sizes, values that are not
// finite.
Stack read_stack(const StackFiles& files);

// Names of the files that write_stack() writes. The extension selects the format: .nrrd, .mhd (with a .raw beside it),
// .mha or .raw (float32, little-endian) for one file with all views; .pfm, .tif or .tiff for a file per view,
// NAME_0000.EXT beside `path`.
std::vector<std::filesystem::path> stack_files(const std::filesystem::path& path, std::size_t views);
// Writes these files and returns their names; pfm is little-endian with scale 1. Throws FileError, and then leaves no
// new file.
std::vector<std::filesystem::path> write_stack(const Stack& stack, const std::filesystem::path& path,
                                               const Provenance& provenance = {});

// Reads a portable float map of one channel: "Pf", width and height, and a scale. The scale's sign gives the byte order
// (below 0: little-endian); its size is ignored. Rows stay in the file's order: upwards by the format's description,
// downwards in files of projections. Throws FileError: no such file, no header of one channel, a wrong number of bytes.
Stack read_pfm(const std::filesystem::path& file);
struct ScanDescription {
  ScanDescription() { geometry.volume.spacing = {0, 0, 0}; }

  std::filesystem::path file;  // source, for messages
  // Angles or poses are in the order of the files' views, over any number of turns. Fields of the volume that the scan
  // does not give are 0.
  ConeGeometry geometry;
  Vec3 centre;                    // of the volume, the geometry's origin, in the scan's own coordinates
  bool columns_reversed = false;  // the files' first column has the greatest u
  bool rows_reversed = false;     // the files' first row has the greatest v, as in rows that run downwards
  StackFiles projections;
  bool intensities = false;        // the projections are intensities; else line integrals
  StackFiles flats, darks;         // averaged; only with intensities
  StackFiles dead;                 // one picture; its pixels are not 0 where they are dead
  double full = 0;                 // intensity without an object, if there is no flat
  std::filesystem::path dxchange;  // file for take_dxchange(), or empty

  std::vector<std::filesystem::path> inputs() const;  // its own files, and those that it names
};

}  // namespace gicube::samples
