// The readers of each volume format. Each finds out by a file's beginning whether it is one, and where its samples lie; all throw FileError. Spacing
// is what the file says, 1 where it says nothing. `allow_outside` is that of a VolumeSource.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <vector>

#include "gicube/scene/volume_file.h"
#include "scene/formats/plane_file.h"

namespace gicube::scene {

// .mhd .mha, MetaImage; known by its contents if its first key is ObjectType or NDims; plain, zlib-compressed or text.
// Lines "Key = Value" up to ElementDataFile, which says where the data are: in this file (LOCAL) or in one other. A
// LIST or numbered series of slice files is refused: give the folder or one file. Keys that say nothing of the samples'
// layout are ignored. MET_LONG has 4 bytes, as in MetaIO. HeaderSize counts from the data file's first byte, also where
// that is this file.
bool is_meta_image(const std::filesystem::path& file);
StoredFile find_meta_image(const std::filesystem::path& file, bool allow_outside = false);

// .nii .nii.gz, NIfTI-1 and NIfTI-2: header and data in one, gzipped or not, of either byte order; libnifti gives the header's layout and byte
// swapping. A scl_slope of 0 or NaN means "not scaled". Refused: a header whose data lie in another file (.hdr and .img), colour and
// complex samples.
bool is_nifti(const std::filesystem::path& file);
StoredFile find_nifti(const std::filesystem::path& file);

// .nrrd .nhdr, NRRD; header attached or detached, encodings raw, gzip, ascii, hex. teem reads the header, from memory and without touching any data; the data are read here, once their size is known to be
// there. Refused, though NRRD knows them: several data files, bzip2 and zrl encodings, block samples, byte skips below -1 (-1 = data
// at the file's end). Axes of one sample may stand beside the three that count, wherever they are.
bool is_nrrd(const std::filesystem::path& file);
StoredFile find_nrrd(const std::filesystem::path& file, bool allow_outside = false);
// Voxels of one sample or, with a first axis of three and three more, of three: those of a row then follow each other, as a
// volume of three times as many voxels along x. `channels`: 1 or 3.
Volume read_nrrd_channels(const std::filesystem::path& file, int& channels);

// With the spacing that is given or, made positive, the file's own. Throws FileError: that has a zero or no number.
Volume with_spacing(Volume volume, const std::optional<Vec3>& given = {});

// Runs of digits count as numbers: "slice-2" before "slice-10". A strict order on names.
bool natural_less(std::string_view a, std::string_view b);
// The folder's files with one of these extensions (lower case; theirs in any), in natural order, but those whose names
// begin with a dot. Warns of numbers that are missing in their names. Throws FileError.
std::vector<std::filesystem::path> files_with(const std::filesystem::path& folder,
                                              std::initializer_list<std::string_view> extensions);

// The folder's .png .tif .tiff .bmp .jpg .jpeg .pgm .exr files (any case) in natural order, the first at z = 0; x and y
// run as in the picture, from its upper left corner. Other files and folders in it are ignored. Samples are 8 or 16
// bits or float32, the same in all slices, and so are width and height; spacing is 1. If no pixel has a colour (red = green = blue),
// samples are grey and alpha is ignored. Else slices are of 8 or 16 bits, voxels have the pixels' colours, and samples are the
// pixels' alpha if the first slice has one, or else their luma (ITU-R BT.709), of 8 bits. Throws FileError naming the slice.
Volume read_slices(const std::filesystem::path& folder);
// The same, each slice when it is asked for.
Volume open_slices(const std::filesystem::path& folder);

// One such file, its pages as slices (TIFF; others have one), with the spacing that an OME-TIFF has. They must be grey.
// Reduced pages (NewSubfileType) are skipped.
Volume open_pages(const std::filesystem::path& file);  // each page when it is asked for
Volume read_pages(const std::filesystem::path& file);

}  // namespace gicube::scene
