// The readers of each volume format. Each finds out by a file's beginning whether it is one, and where its samples lie;
// all throw FileError. Spacing is what the file says, 1 where it says nothing. `allow_outside` is that of a
// VolumeSource.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/scene/volume_file.h"
#include "scene/formats/plane_file.h"

namespace gicube::scene {

// .mhd .mha, MetaImage; known by its contents if its first key is ObjectType or NDims; plain, zlib-compressed or text.
// Lines "Key = Value" up to ElementDataFile, which says where the data are: in this file (LOCAL), in one other, or in
// one for each slice, LIST or a numbered name. Keys that say nothing of the samples' layout are ignored. MET_LONG has 4
// bytes, as in MetaIO. HeaderSize counts from the data file's first byte, also where that is this file. TransformMatrix
// says where the axes run, in the patient's world as ITK has it. Three or four channels of bytes are colours, others
// need `part`, their number from 1, as do volumes along a fourth axis.
bool is_meta_image(const std::filesystem::path& file);
StoredFile find_meta_image(const std::filesystem::path& file, bool allow_outside = false, const std::string& part = {});

// .nii .nii.gz, NIfTI-1 and NIfTI-2, and .hdr with .img, which Analyze 7.5 has too; gzipped or not, of either byte
// order; libnifti gives the header's layout and byte swapping. A scl_slope of 0 or NaN means "not scaled". sform says
// where the axes run, or else qform; Analyze says nothing of them. `part`: which of several volumes (times), from 1.
// Refused: complex samples.
bool is_nifti(const std::filesystem::path& file);
StoredFile find_nifti(const std::filesystem::path& file, const std::string& part = {});

// .nrrd .nhdr, NRRD; header attached or detached, encodings raw, gzip, bzip2, ascii, hex; data in one file or in one
// for each slice (LIST or a numbered name). teem reads the header, from memory and without touching any data; the data
// are read here, once their size is known to be there. One axis may be beside the three of space, told by its kind:
// colours, or `part` is a number on it, from 1. Refused, though NRRD knows them: zrl encodings, block samples, byte
// skips below -1 (-1 = data at the file's end).
bool is_nrrd(const std::filesystem::path& file);
StoredFile find_nrrd(const std::filesystem::path& file, bool allow_outside = false, const std::string& part = {});
// Voxels of one sample or, with a first axis of three and three more, of three: those of a row then follow each other,
// as a volume of three times as many voxels along x. `channels`: 1 or 3.
Volume read_nrrd_channels(const std::filesystem::path& file, int& channels);

// .npy, and .npz, whose array `part` names if there are several: bools and numbers of at least three axes, the last
// running fastest, or the first of Fortran's order. Of an array of more axes `part` is a number, from 1, over those
// before the three.
bool is_numpy(const std::filesystem::path& file);
StoredFile find_numpy(const std::filesystem::path& file, const std::string& part = {});
StoredFile find_numpy_archive(const std::filesystem::path& file, const std::string& part = {});

// .vti, VTK's image data of one piece: ascii, raw or base64, zlib-compressed; `part`: an array's name. And legacy .vtk
// of structured points, in text or big-endian: its first scalars. A volume's voxels are VTK's points, or else its
// cells.
bool is_vti(const std::filesystem::path& file);
Volume read_vti(const std::filesystem::path& file, const std::string& part = {});
bool is_legacy_vtk(const std::filesystem::path& file);
StoredFile find_legacy_vtk(const std::filesystem::path& file);

// With the spacing that is given or, made positive, the file's own. Throws FileError: that has a zero or no number.
Volume with_spacing(Volume volume, const std::optional<Vec3>& given = {});

// A strict order of names in which runs of digits count as numbers: "slice-2" before "slice-10".
bool natural_less(std::string_view a, std::string_view b);
// The folder's files with one of these extensions (lower case; theirs in any case), in natural order, without those
// whose names begin with a dot. Warns of numbers that are missing in their names. Throws FileError.
std::vector<std::filesystem::path> files_with(const std::filesystem::path& folder,
                                              std::initializer_list<std::string_view> extensions);

// The extensions of slices in a folder.
inline const std::initializer_list<std::string_view> kPictures{".png", ".tif",  ".tiff", ".bmp",
                                                               ".jpg", ".jpeg", ".pgm",  ".exr"};
// The folder's pictures in natural order, the first at z = 0; x and y run as in the picture, from its upper left
// corner. Other files, and folders in it, are ignored. Samples are integers of 1 to 64 bits, half, float, double, or
// magnitudes of complex numbers, the same type in all slices; width and height are the same too. Spacing is 1. If no
// pixel has a colour (red = green = blue), samples are grey and alpha is ignored. Otherwise slices have 8 or 16 bits,
// voxels have the pixels' colours, and samples are the pixels' alpha if the first slice has one, or their luma (ITU-R
// BT.709), in 8 bits. Each slice is read by Volume::planes. Throws FileError naming the slice.
Volume open_slices(const std::filesystem::path& folder);

// One picture file, its pages as slices (TIFF; other formats have one page), with the spacing that an OME-TIFF or
// ImageJ gives. They must be grey. Reduced pages (NewSubfileType) are skipped. `part`: which of several channels and
// times, from 1: all channels of the first time, then of the next.
Volume open_pages(const std::filesystem::path& file, const std::string& part = {});
// Reads the samples too.
Volume read_pages(const std::filesystem::path& file);

}  // namespace gicube::scene
