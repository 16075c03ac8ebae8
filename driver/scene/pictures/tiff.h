// TIFF by libtiff: which pages a file has, and samples that OpenImageIO 2.4 does not read.
#pragma once

#include <tiffio.h>

#include <memory>
#include <string>

#include "scene/formats/pictures/picture_library.h"

namespace gicube::scene {

class Tiff final : public PictureReader {
 public:
  // Null: the file is no TIFF.
  static std::unique_ptr<Tiff> open(const std::filesystem::path& file);

  // Whether OpenImageIO refuses or misreads the first page: single bits, 64-bit integers, complex numbers.
  bool is_special() const;

  std::optional<std::vector<int>> pages() override;
  bool seek(int page) override { return TIFFSetDirectory(file_.get(), static_cast<tdir_t>(page)) != 0; }
  Page page() const override;
  // Single bits become 0 and 255, as OpenImageIO has them, and complex numbers their magnitudes.
  bool read(int page, StoredType type, std::span<std::byte> out) override;
  std::string description() const override;
  double number(const char* attribute) const override;
  std::optional<Strip> only_strip() override;
  std::string error() override { return *error_; }

 private:
  struct Close {
    void operator()(TIFF* file) const { TIFFClose(file); }
  };

  Tiff() = default;

  std::unique_ptr<std::string> error_ = std::make_unique<std::string>();  // libtiff's last one, which it writes to
  std::unique_ptr<TIFF, Close> file_;
};

}  // namespace gicube::scene
