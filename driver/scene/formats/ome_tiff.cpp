#include "scene/formats/ome_tiff.h"

#include <fmt/format.h>

#include <cstring>
#include <pugixml.hpp>
#include <string_view>

#include "gicube/scene/error.h"

namespace gicube::scene {
namespace {

// Elements may have a prefix: "ome:Pixels".
bool is_named(const pugi::xml_node& node, std::string_view name) {
  const std::string_view full = node.name();
  return full == name || (full.ends_with(name) && full[full.size() - name.size() - 1] == ':');
}

void check_planes(const std::filesystem::path& file, const pugi::xml_node& pixels) {
  for (const pugi::xml_node& data : pixels.children()) {
    if (!is_named(data, "TiffData")) continue;
    if (data.first_child()) throw FileError(file, "TiffData", "planes in this file", "a UUID of another");
    const int page = data.attribute("IFD").as_int(0), z = data.attribute("FirstZ").as_int(0);
    if (page != z) throw FileError(file, "TiffData", fmt::format("plane {} in page {}", z, z), fmt::format("{}", page));
  }
}

}  // namespace

std::optional<OmePixels> ome_pixels(const std::filesystem::path& file, const std::string& description) {
  if (description.find("<OME") == std::string::npos && description.find(":OME") == std::string::npos)
    return std::nullopt;
  pugi::xml_document document;
  if (const auto parsed = document.load_string(description.c_str()); !parsed) {
    throw FileError(file, "ImageDescription", "an OME document", parsed.description());
  }
  const pugi::xml_node pixels = document.find_node([](const pugi::xml_node& node) { return is_named(node, "Pixels"); });
  if (!pixels) throw FileError(file, "Pixels", "an element of the OME document", "none");
  for (const char* const name : {"SizeC", "SizeT"}) {
    if (const int size = pixels.attribute(name).as_int(1); size != 1) {
      throw FileError(file, name, "1", fmt::format("{}", size));
    }
  }
  check_planes(file, pixels);
  OmePixels out{.size_z = pixels.attribute("SizeZ").as_int(0)};
  if (out.size_z < 1) throw FileError(file, "SizeZ", "1 or more", pixels.attribute("SizeZ").value());
  const auto unit = [&](const char* name) { return std::string_view(pixels.attribute(name).as_string("\xC2\xB5m")); };
  if (unit("PhysicalSizeXUnit") != unit("PhysicalSizeYUnit") ||
      unit("PhysicalSizeXUnit") != unit("PhysicalSizeZUnit")) {
    throw FileError(file, "PhysicalSizeXUnit", "the same unit along x, y and z", "different ones");
  }
  out.spacing = {pixels.attribute("PhysicalSizeX").as_double(1), pixels.attribute("PhysicalSizeY").as_double(1),
                 pixels.attribute("PhysicalSizeZ").as_double(1)};
  return out;
}

}  // namespace gicube::scene
