// Pictures as the bytes of their files. OpenImageIO would write the files itself, but does not check each of its writes.
#pragma once

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace gicube::scene {

// `format`: OpenImageIO's name of it, as "png". Throws FileError that names the path.
std::vector<std::uint8_t> encoded_picture(const std::filesystem::path& path, const char* format,
                                          const OIIO::ImageSpec& spec, const OIIO::TypeDesc& type, const void* samples);

}  // namespace gicube::scene
