// The interface to OpenImageIO. It is in a separate shared object (driver/scene/pictures), which is loaded for the
// first picture that needs it: it depends on some 250 other shared objects, whose loading takes 0.15 s of processor
// time.
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
  const char* format;  // OpenImageIO's name, such as "openexr"
  int width = 0, height = 0, channels = 0;
  const float* samples;  // row by row, the channels of a pixel together
  std::vector<std::pair<std::string, std::string>> attributes;
};

// A file of one or more pictures, its pages. Colours are as stored, not premultiplied.
class PictureReader {
 public:
  struct Page {
    int width = 0, height = 0, depth = 0, channels = 0;
    std::optional<StoredType> type;  // nothing: a type that a volume cannot have
    std::string type_name;           // for messages
  };
  struct Strip {
    std::uint64_t offset = 0;
    bool big_endian = false;
  };

  virtual ~PictureReader() = default;
  // The numbers of all pages except a TIFF's reduced pages and masks (NewSubfileType). Nothing: a page is truncated, or
  // a TIFF's pages form a loop; error() has the reason.
  virtual std::optional<std::vector<int>> pages() = 0;
  virtual bool seek(int page) = 0;  // false: there is no such page
  virtual Page page() const = 0;    // the first page before any call of seek()
  // Reads all channels of the page as samples of this type, in the host's byte order. False: they are incomplete;
  // error() has the reason.
  virtual bool read(int page, StoredType type, std::span<std::byte> out) = 0;
  virtual std::string description() const = 0;             // the page's ImageDescription (TIFF)
  virtual double number(const char* attribute) const = 0;  // XResolution or YResolution; 0: none
  // The beginning of the first page's samples, if they are uncompressed and in one piece of a TIFF.
  virtual std::optional<Strip> only_strip() = 0;
  virtual std::string error() = 0;
};

class PictureLibrary {
 public:
  virtual ~PictureLibrary() = default;
  // Null: `error` has the reason.
  virtual std::unique_ptr<PictureReader> open(const std::filesystem::path& file, std::string& error) const = 0;
  // The bytes of a file. Empty: `error` has the reason. OpenImageIO itself does not check each of its writes.
  virtual std::vector<std::uint8_t> encode(const std::filesystem::path& file, const PictureToWrite& picture,
                                           std::string& error) const = 0;
};

// The result of gicube_NAME() of libgicube-NAME.so. Throws FileError for `file` if there is none.
const void* plug_in(const std::filesystem::path& file, const std::string& name);

// Loads the library at the first call. Throws FileError for `file` if that fails.
const PictureLibrary& picture_library(const std::filesystem::path& file);

// The bytes of a file. Throws FileError that names the path.
std::vector<std::uint8_t> encoded_picture(const std::filesystem::path& file, const PictureToWrite& picture);

}  // namespace gicube::scene
