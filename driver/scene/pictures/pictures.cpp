// libgicube-pictures.so: pictures by OpenImageIO. Nothing of it is thrown to the library that loads it.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <array>
#include <utility>

#include "scene/formats/pictures/picture_library.h"

namespace gicube::scene {
namespace {

constexpr std::array kTypes = {
    std::pair{StoredType::kInt8, OIIO::TypeDesc::INT8},     std::pair{StoredType::kUint8, OIIO::TypeDesc::UINT8},
    std::pair{StoredType::kInt16, OIIO::TypeDesc::INT16},   std::pair{StoredType::kUint16, OIIO::TypeDesc::UINT16},
    std::pair{StoredType::kInt32, OIIO::TypeDesc::INT32},   std::pair{StoredType::kUint32, OIIO::TypeDesc::UINT32},
    std::pair{StoredType::kFloat32, OIIO::TypeDesc::FLOAT}, std::pair{StoredType::kFloat64, OIIO::TypeDesc::DOUBLE},
    std::pair{StoredType::kFloat32, OIIO::TypeDesc::HALF}};

OIIO::TypeDesc type_of(StoredType type) {
  for (const auto& [stored, made] : kTypes) {
    if (stored == type) return made;
  }
  return OIIO::TypeDesc::UINT16;
}

std::optional<StoredType> type_of(const OIIO::TypeDesc& format) {
  for (const auto& [stored, made] : kTypes) {
    if (format == made) return stored;
  }
  return std::nullopt;
}

class Reader final : public PictureReader {
 public:
  explicit Reader(std::unique_ptr<OIIO::ImageInput> input) : input_(std::move(input)) {}

  bool seek(int page) override { return input_->seek_subimage(page, 0); }
  Page page() const override {
    const OIIO::ImageSpec& spec = input_->spec();
    return {spec.width, spec.height, spec.depth, spec.nchannels, type_of(spec.format), spec.format.c_str()};
  }
  bool read(int page, StoredType type, std::span<std::byte> out) override {
    input_->geterror();  // of a search for pages
    // Rows that a TIFF or JPEG does not have are zero or grey, and only this error tells.
    return input_->read_image(page, 0, 0, input_->spec().nchannels, type_of(type), out.data()) && !input_->has_error();
  }
  std::string description() const override { return input_->spec().get_string_attribute("ImageDescription"); }
  double number(const char* attribute) const override {
    return static_cast<double>(input_->spec().get_float_attribute(attribute));
  }
  std::string error() override { return input_->geterror(); }

 private:
  std::unique_ptr<OIIO::ImageInput> input_;
};

class Library final : public PictureLibrary {
 public:
  std::unique_ptr<PictureReader> open(const std::filesystem::path& file, std::string& error) const override {
    OIIO::ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1;  // the colours as stored, not premultiplied
    auto input = OIIO::ImageInput::open(file.string(), &config);
    if (!input) {
      error = OIIO::geterror();
      return nullptr;
    }
    return std::make_unique<Reader>(std::move(input));
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
