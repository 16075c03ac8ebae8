// OpenImageIO, as this library knows it: in a shared object of its own (driver/scene/pictures), which is loaded when a
// picture is first asked for that only OpenImageIO can read or write. It brings some 250 other shared objects, and
// loading them takes 0.15 s of a program's processor time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gicube/scene/volume_file.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {

struct PictureToWrite {
  const char* format;  // OpenImageIO's name of it, as "openexr"
  int width = 0, height = 0, channels = 0;
  const float* samples;  // row by row, the channels of a pixel together
  std::vector<std::pair<std::string, std::string>> attributes;
};

// A file of one picture or more, which are its pages. Colours are as they are stored, not premultiplied.
class PictureReader {
 public:
  struct Page {
    int width = 0, height = 0, depth = 0, channels = 0;
    std::optional<StoredType> type;  // nothing: one that a volume can't have
    std::string type_name;           // OpenImageIO's
  };

  virtual ~PictureReader() = default;
  virtual bool seek(int page) = 0;  // false: there is no such page
  virtual Page page() const = 0;    // at first page 0
  // All channels of the page as samples of this type, in the host's byte order. False: they are not whole, and error()
  // says why.
  virtual bool read(int page, StoredType type, std::span<std::byte> out) = 0;
  virtual std::string description() const = 0;             // TIFF's ImageDescription
  virtual double number(const char* attribute) const = 0;  // of OpenImageIO, 0 if there is none
  virtual std::string error() = 0;
};

class PictureLibrary {
 public:
  virtual ~PictureLibrary() = default;
  // Null: `error` says why.
  virtual std::unique_ptr<PictureReader> open(const std::filesystem::path& file, std::string& error) const = 0;
  // The bytes of a file. Empty: `error` says why. OpenImageIO would write the file itself, but does not check each of
  // its writes.
  virtual std::vector<std::uint8_t> encode(const std::filesystem::path& file, const PictureToWrite& picture,
                                           std::string& error) const = 0;
};

// Loads it at the first call. Throws FileError for `file` if that fails.
const PictureLibrary& picture_library(const std::filesystem::path& file);

// The bytes of a file. Throws FileError that names the path.
std::vector<std::uint8_t> encoded_picture(const std::filesystem::path& file, const PictureToWrite& picture);

}  // namespace gicube::scene
