// What an OME-TIFF says of its pages: a TIFF whose first page is described by an XML document (docs.openmicroscopy.org, OME-TIFF
// specification 6).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "gicube/vector.h"

namespace gicube::scene {

struct OmePixels {
  int size_z = 0;  // planes, each a page
  Vec3 spacing{1, 1, 1};
};

// `description`: of the first page. Nothing if it is no OME document. Throws FileError that names the attribute: the image has several
// channels or times, lengths in different units, or planes in other files or in another order than that of z.
std::optional<OmePixels> ome_pixels(const std::filesystem::path& file, const std::string& description);

}  // namespace gicube::scene
