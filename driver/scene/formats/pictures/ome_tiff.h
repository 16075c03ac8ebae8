// The description of a TIFF's pages: an OME-TIFF has an XML document on its first page (docs.openmicroscopy.org,
// OME-TIFF specification 6), and ImageJ writes lines "key=value" there.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "gicube/vector.h"

namespace gicube::scene {

// Planes along z, of several channels and times; each plane is a page.
struct PageStack {
  int z = 1, channels = 1, times = 1;
  std::array<int, 3> steps{1, 1, 1};  // pages per step along z, channels and times
  Vec3 spacing{1, 1, 1};
};

// Reads the description of the first page. Nothing if it is not an OME document. Warns of a missing length along z.
// Throws FileError that names the attribute: lengths in different units, planes in other files or in another order than
// declared.
std::optional<PageStack> ome_pixels(const std::filesystem::path& file, const std::string& description);

// Reads a description of ImageJ, which begins with "ImageJ=". `edges`: of a pixel, from the file's resolution.
std::optional<PageStack> imagej_stack(const std::filesystem::path& file, const std::string& description, int pages,
                                      const std::array<double, 2>& edges);

}  // namespace gicube::scene
