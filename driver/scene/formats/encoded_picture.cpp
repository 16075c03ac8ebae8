#include "scene/formats/encoded_picture.h"

#include <OpenImageIO/filesystem.h>

#include "gicube/scene/error.h"

namespace gicube::scene {

std::vector<std::uint8_t> encoded_picture(const std::filesystem::path& path, const char* format,
                                          const OIIO::ImageSpec& spec, const OIIO::TypeDesc& type,
                                          const void* samples) {
  std::vector<std::uint8_t> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create(format);
  if (!output || !output->set_ioproxy(&memory)) {
    throw FileError(path, "format", "one that OpenImageIO can write", output ? output->geterror() : OIIO::geterror());
  }
  if (!output->open(path.string(), spec) || !output->write_image(type, samples) || !output->close()) {
    throw FileError(path, "picture", "one that OpenImageIO can write", output->geterror());
  }
  return bytes;
}

}  // namespace gicube::scene
