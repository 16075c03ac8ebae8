#include "scene/pictures/tiff.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <string_view>

namespace gicube::scene {
namespace {

int keep_error(TIFF*, void* text, const char*, const char* format, va_list values) {
  std::array<char, 512> buffer{};
  std::vsnprintf(buffer.data(), buffer.size(), format, values);
  *static_cast<std::string*>(text) = buffer.data();
  return 1;
}
int ignore_warning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

// A field of the page, or TIFF's default for a page without it; `otherwise`: if TIFF has none.
template <typename Number>
Number field(TIFF* file, std::uint32_t tag, Number otherwise = {}) {
  Number value = otherwise;
  TIFFGetFieldDefaulted(file, tag, &value);
  return value;
}

int bits_of(TIFF* file) { return field<std::uint16_t>(file, TIFFTAG_BITSPERSAMPLE); }

bool is_complex(TIFF* file) {
  const auto format = field<std::uint16_t>(file, TIFFTAG_SAMPLEFORMAT);
  return format == SAMPLEFORMAT_COMPLEXINT || format == SAMPLEFORMAT_COMPLEXIEEEFP;
}

// The samples of a row of a strip or tile.
using Convert = void (*)(std::span<const std::byte> from, std::size_t count, std::byte* to);

template <int kWhite>
void to_mask(std::span<const std::byte> from, std::size_t count, std::byte* to) {
  for (std::size_t i = 0; i < count; ++i)
    to[i] = (from[i / 8] >> (7 - i % 8) & std::byte{1}) == std::byte{kWhite} ? std::byte{255} : std::byte{0};
}

template <typename Part, typename Real>
void to_magnitudes(std::span<const std::byte> from, std::size_t count, std::byte* to) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto part = [&](std::size_t k) { return static_cast<double>(sample_at<Part>(from, 2 * i + k)); };
    const Real magnitude = static_cast<Real>(std::hypot(part(0), part(1)));
    std::memcpy(to + i * sizeof magnitude, &magnitude, sizeof magnitude);
  }
}

void copy(std::span<const std::byte> from, std::size_t count, std::byte* to) {
  std::memcpy(to, from.data(), count * sizeof(std::uint64_t));
}

struct Special {
  int bits;
  std::uint16_t format;
  StoredType type;
  Convert convert;
};
constexpr std::array kSpecial{
    Special{64, SAMPLEFORMAT_UINT, StoredType::kUint64, copy},
    Special{64, SAMPLEFORMAT_INT, StoredType::kInt64, copy},
    Special{32, SAMPLEFORMAT_COMPLEXINT, StoredType::kFloat32, to_magnitudes<std::int16_t, float>},
    Special{64, SAMPLEFORMAT_COMPLEXINT, StoredType::kFloat64, to_magnitudes<std::int32_t, double>},
    Special{64, SAMPLEFORMAT_COMPLEXIEEEFP, StoredType::kFloat32, to_magnitudes<float, float>},
    Special{128, SAMPLEFORMAT_COMPLEXIEEEFP, StoredType::kFloat64, to_magnitudes<double, double>}};

// Nothing: a sample of another kind.
std::optional<Special> special_of(TIFF* file) {
  const int bits = bits_of(file);
  const auto format = field<std::uint16_t>(file, TIFFTAG_SAMPLEFORMAT);
  if (bits == 1) {
    const bool inverted =
        field<std::uint16_t>(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK) == PHOTOMETRIC_MINISWHITE;
    return Special{1, format, StoredType::kUint8, inverted ? to_mask<0> : to_mask<1>};
  }
  const auto* const found =
      std::ranges::find_if(kSpecial, [&](const Special& each) { return each.bits == bits && each.format == format; });
  return found != kSpecial.end() ? std::optional(*found) : std::nullopt;
}

}  // namespace

std::unique_ptr<Tiff> Tiff::open(const std::filesystem::path& file) {
  std::unique_ptr<Tiff> tiff(new Tiff());
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(),
                                                                                 &TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_error, tiff->error_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), ignore_warning, nullptr);
  tiff->file_.reset(TIFFOpenExt(file.c_str(), "rm", options.get()));  // m: not mapped, as the file may be cut meanwhile
  return tiff->file_ ? std::move(tiff) : nullptr;
}

bool Tiff::is_special() const {
  const int bits = bits_of(file_.get());
  return bits == 1 || is_complex(file_.get()) ||
         (bits == 64 && field<std::uint16_t>(file_.get(), TIFFTAG_SAMPLEFORMAT) != SAMPLEFORMAT_IEEEFP);
}

std::optional<std::vector<int>> Tiff::pages() {
  std::vector<int> pages;
  error_->clear();
  if (!seek(0)) return std::nullopt;
  for (int page = 0;; ++page) {
    if ((field<std::uint32_t>(file_.get(), TIFFTAG_SUBFILETYPE) & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0)
      pages.push_back(page);
    if (TIFFLastDirectory(file_.get()) != 0) return pages;
    if (TIFFReadDirectory(file_.get()) == 0) return std::nullopt;
  }
}

PictureReader::Page Tiff::page() const {
  TIFF* const file = file_.get();
  const auto whole = [file](std::uint32_t tag) {
    return static_cast<int>(std::min<std::uint32_t>(field<std::uint32_t>(file, tag), kMaxFileDim + 1));
  };
  Page page{whole(TIFFTAG_IMAGEWIDTH),
            whole(TIFFTAG_IMAGELENGTH),
            1,
            field<std::uint16_t>(file, TIFFTAG_SAMPLESPERPIXEL),
            std::nullopt,
            {}};
  if (const auto special = special_of(file)) page.type = special->type;
  page.type_name = std::to_string(bits_of(file)) + " bits" + (is_complex(file) ? ", complex" : "");
  return page;
}

bool Tiff::read(int number, StoredType type, std::span<std::byte> out) {
  TIFF* const file = file_.get();
  error_->clear();
  if (!seek(number)) return false;
  const auto special = special_of(file);
  const Page shape = page();
  const bool tiled = TIFFIsTiled(file) != 0;
  const auto width = static_cast<std::uint32_t>(shape.width), height = static_cast<std::uint32_t>(shape.height);
  const auto across = tiled ? field<std::uint32_t>(file, TIFFTAG_TILEWIDTH) : width;
  const auto down = tiled ? field<std::uint32_t>(file, TIFFTAG_TILELENGTH)
                          : std::min(field<std::uint32_t>(file, TIFFTAG_ROWSPERSTRIP), height);
  const bool apart = shape.channels > 1 && field<std::uint16_t>(file, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_SEPARATE;
  constexpr std::uint32_t kTile = 1024;  // chosen: tiles may be larger than a small page
  if (!special || apart || across < 1 || across > std::max(width, kTile) || down < 1 ||
      down > std::max(height, kTile)) {
    *error_ = "samples of another kind, separate planes of channels, or tiles larger than the page";
    return false;
  }
  const auto channels = static_cast<std::size_t>(shape.channels), sample = bytes_of(type);
  const auto row_bytes = static_cast<std::size_t>(tiled ? TIFFTileRowSize(file) : TIFFScanlineSize(file));
  std::vector<std::byte> part(static_cast<std::size_t>(tiled ? TIFFTileSize(file) : TIFFStripSize(file)));
  const auto part_bytes = static_cast<tmsize_t>(part.size());
  for (std::uint32_t y = 0; y < height; y += down) {
    for (std::uint32_t x = 0; x < width; x += across) {
      const std::uint32_t rows = std::min(down, height - y), columns = std::min(across, width - x);
      const tmsize_t came = tiled
                                ? TIFFReadEncodedTile(file, TIFFComputeTile(file, x, y, 0, 0), part.data(), part_bytes)
                                : TIFFReadEncodedStrip(file, TIFFComputeStrip(file, y, 0), part.data(), part_bytes);
      if (came < static_cast<tmsize_t>(rows * row_bytes)) {
        if (error_->empty()) *error_ = "too few samples";
        return false;
      }
      for (std::uint32_t row = 0; row < rows; ++row) {
        const std::size_t pixel = std::size_t{y + row} * width + x;
        special->convert(std::span(part).subspan(row * row_bytes, row_bytes), columns * channels,
                         out.data() + pixel * channels * sample);
      }
    }
  }
  return true;
}

std::string Tiff::description() const {
  const char* const text = field<const char*>(file_.get(), TIFFTAG_IMAGEDESCRIPTION);
  return text != nullptr ? text : "";
}

double Tiff::number(const char* attribute) const {
  const bool is_x = std::string_view(attribute) == "XResolution";
  return static_cast<double>(field<float>(file_.get(), is_x ? TIFFTAG_XRESOLUTION : TIFFTAG_YRESOLUTION));
}

std::optional<PictureReader::Strip> Tiff::only_strip() {
  TIFF* const file = file_.get();
  if (!seek(0)) return std::nullopt;
  const auto* const offsets = field<const std::uint64_t*>(file, TIFFTAG_STRIPOFFSETS);
  if (TIFFIsTiled(file) != 0 || TIFFNumberOfStrips(file) != 1 || offsets == nullptr ||
      field<std::uint16_t>(file, TIFFTAG_COMPRESSION) != COMPRESSION_NONE)
    return std::nullopt;
  const bool own_order = TIFFIsByteSwapped(file) == 0;
  return Strip{offsets[0], own_order == (std::endian::native == std::endian::big)};
}

}  // namespace gicube::scene
