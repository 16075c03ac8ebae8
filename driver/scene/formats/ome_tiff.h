// The pages of a TIFF, and the description of those of an OME-TIFF: a TIFF whose first page is described by an XML
// document (docs.openmicroscopy.org, OME-TIFF specification 6).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gicube/vector.h"

namespace gicube::scene {

// The numbers of a TIFF's pages, but reduced ones and masks (NewSubfileType). Nothing for another file. Each page says
// where the next one is: OpenImageIO takes one that can't be read for the end. Throws FileError if it is not in the
// file, or if they lead round.
std::optional<std::vector<int>> tiff_pages(const std::filesystem::path& file);

struct OmePixels {
  int size_z = 0;  // planes, each a page
  Vec3 spacing{1, 1, 1};
};

// `description`: of the first page. Nothing if it is no OME document. Throws FileError that names the attribute: the image has several
// channels or times, lengths in different units, or planes in other files or in another order than that of z.
std::optional<OmePixels> ome_pixels(const std::filesystem::path& file, const std::string& description);

}  // namespace gicube::scene
