// The pages of a TIFF, and the description of those of an OME-TIFF: a TIFF whose first page is described by an XML
// document (docs.openmicroscopy.org, OME-TIFF specification 6), or of ImageJ, which has lines "key=value" there.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gicube/vector.h"

namespace gicube::scene {

// The numbers of a TIFF's pages, but reduced ones and masks (NewSubfileType). Nothing for another file. Each page says
// where the next one is: OpenImageIO takes one that can't be read for the end. Throws FileError if it is not in the
// file, if they lead round, or if a page's samples are single bits.
std::optional<std::vector<int>> tiff_pages(const std::filesystem::path& file);

// Planes along z, of several channels and times; each plane is a page.
struct PageStack {
  int z = 1, channels = 1, times = 1;
  std::array<int, 3> steps{1, 1, 1};  // pages from one to the next along z, channels and times
  Vec3 spacing{1, 1, 1};
};

// `description`: of the first page. Nothing if it is no OME document. Warns of a missing length along z. Throws
// FileError that names the attribute: the image has lengths in different units, or planes in other files or in another
// order than it says.
std::optional<PageStack> ome_pixels(const std::filesystem::path& file, const std::string& description);

// The page stack of ImageJ, whose descriptions begin with "ImageJ=". `edges`: of a pixel, by the file's resolution.
std::optional<PageStack> imagej_stack(const std::filesystem::path& file, const std::string& description, int pages,
                                      const std::array<double, 2>& edges);

// Where the samples of the first page begin, and their order of bytes: of a TIFF that is not compressed. ImageJ writes
// files above 4 GB with one page for all planes, which follow each other.
struct FirstStrip {
  std::uint64_t offset = 0;
  bool big_endian = false;
};
std::optional<FirstStrip> first_strip(const std::filesystem::path& file);

}  // namespace gicube::scene
