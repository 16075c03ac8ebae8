// libgicube-pictures.so: pictures by OpenImageIO and libtiff. Errors are returned as texts, not thrown.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <string>
#include <utility>

#include "scene/formats/pictures/picture_library.h"
#include "scene/pictures/tiff.h"

namespace gicube::scene {
namespace {

// Nothing: a volume has no samples of that type.
std::optional<StoredType> type_of(const OIIO::TypeDesc& format) {
  if (format == OIIO::TypeDesc::HALF) return StoredType::kFloat32;
  const char* const kind = format.is_floating_point() ? "float" : format.is_signed() ? "int" : "uint";
  return type_named(kind + std::to_string(8 * format.basesize()));
}

class Reader final : public PictureReader {
 public:
  Reader(std::unique_ptr<OIIO::ImageInput> input, std::unique_ptr<Tiff> tiff)
      : input_(std::move(input)), tiff_(std::move(tiff)) {}

  std::optional<std::vector<int>> pages() override {
    if (tiff_) return tiff_->pages();
    std::vector<int> pages;
    for (int page = 0; page <= kMaxFileDim && seek(page); ++page) pages.push_back(page);
    return pages;
  }
  bool seek(int page) override { return input_->seek_subimage(page, 0); }
  Page page() const override {
    const OIIO::ImageSpec& spec = input_->spec();
    return {spec.width, spec.height, spec.depth, spec.nchannels, type_of(spec.format), spec.format.c_str()};
  }
  bool read(int page, StoredType type, std::span<std::byte> out) override {
    input_->geterror();  // of a search for pages
    // Rows that a TIFF or JPEG does not have are zero or grey, and only this error tells.
    const OIIO::TypeDesc made = type == StoredType::kFloat32 ? OIIO::TypeDesc::FLOAT : input_->spec().format;
    return input_->read_image(page, 0, 0, input_->spec().nchannels, made, out.data()) && !input_->has_error();
  }
  std::string description() const override { return input_->spec().get_string_attribute("ImageDescription"); }
  double number(const char* attribute) const override {
    return static_cast<double>(input_->spec().get_float_attribute(attribute));
  }
  std::optional<Strip> only_strip() override { return tiff_ ? tiff_->only_strip() : std::nullopt; }
  std::string error() override {
    const std::string error = tiff_ ? tiff_->error() : std::string();
    return error.empty() ? input_->geterror() : error;
  }

 private:
  std::unique_ptr<OIIO::ImageInput> input_;
  std::unique_ptr<Tiff> tiff_;  // null: another format
};

class Library final : public PictureLibrary {
 public:
  std::unique_ptr<PictureReader> open(const std::filesystem::path& file, std::string& error) const override {
    auto tiff = Tiff::open(file);
    if (tiff && tiff->is_special()) return tiff;
    OIIO::ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1;  // the colours as stored, not premultiplied
    auto input = OIIO::ImageInput::open(file.string(), &config);
    if (!input) {
      error = OIIO::geterror();
      return nullptr;
    }
    return std::make_unique<Reader>(std::move(input), std::move(tiff));
  }

  std::vector<std::uint8_t> encode(const std::filesystem::path& file, const PictureToWrite& picture,
                                   std::string& error) const override {
    OIIO::ImageSpec spec(picture.width, picture.height, picture.channels, OIIO::TypeDesc::FLOAT);
    for (const auto& [name, value] : picture.attributes) spec[name] = value;
    std::vector<std::uint8_t> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    const auto output = OIIO::ImageOutput::create(picture.format);
    if (!output) {
      error = OIIO::geterror();
      return {};
    }
    if (!output->set_ioproxy(&memory) || !output->open(file.string(), spec) ||
        !output->write_image(OIIO::TypeDesc::FLOAT, picture.samples) || !output->close()) {
      error = output->geterror();
      return {};
    }
    return bytes;
  }
};

}  // namespace
}  // namespace gicube::scene

extern "C" __attribute__((visibility("default"))) const gicube::scene::PictureLibrary* gicube_pictures() {
  static const gicube::scene::Library library;
  return &library;
}
