#include "scene/formats/readers.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "scene/common/checks.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {
namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// Cuts the run of digits off the front of `text`, without its leading zeros.
std::string_view take_number(std::string_view& text) {
  std::size_t end = 0;
  while (end < text.size() && is_digit(text[end])) ++end;
  std::string_view number = text.substr(0, end);
  text.remove_prefix(end);
  while (number.size() > 1 && number.front() == '0') number.remove_prefix(1);
  return number;
}

std::vector<std::filesystem::path> slice_files(const std::filesystem::path& folder) {
  auto files = files_with(folder, {".png", ".tif", ".tiff", ".bmp", ".jpg", ".jpeg", ".pgm", ".exr"});
  if (files.empty()) throw FileError(folder, "folder", "image slices", "no image file");
  if (files.size() > kMaxFileDim) {
    throw FileError(folder, "folder", fmt::format("at most {} slices", kMaxFileDim), fmt::format("{}", files.size()));
  }
  return files;
}

struct Slice {
  int width = 0, height = 0;
  SampleType type = SampleType::kUint8;
  std::vector<std::byte> samples;
};

SampleType type_of(const std::filesystem::path& file, const OIIO::TypeDesc& format) {
  if (format == OIIO::TypeDesc::UINT8) return SampleType::kUint8;
  if (format == OIIO::TypeDesc::UINT16) return SampleType::kUint16;
  if (format == OIIO::TypeDesc::INT16) return SampleType::kInt16;
  if (format == OIIO::TypeDesc::FLOAT || format == OIIO::TypeDesc::HALF) return SampleType::kFloat32;
  throw FileError(file, "sample type", "8 or 16 bits or float", format.c_str());
}

OIIO::TypeDesc read_as(SampleType type) {
  switch (type) {
    case SampleType::kUint8: return OIIO::TypeDesc::UINT8;
    case SampleType::kInt16: return OIIO::TypeDesc::INT16;
    case SampleType::kFloat32: return OIIO::TypeDesc::FLOAT;
    default: return OIIO::TypeDesc::UINT16;
  }
}

// One sample a pixel from `channels`: grey, grey alpha, RGB or RGBA.
std::vector<std::byte> grey(const std::filesystem::path& file, std::vector<std::byte> pixels, std::size_t channels,
                            std::size_t sample_bytes) {
  if (channels == 1) return pixels;
  const std::size_t count = pixels.size() / (channels * sample_bytes);
  for (std::size_t i = 0; i < count; ++i) {
    const std::byte* pixel = pixels.data() + i * channels * sample_bytes;
    const bool colourless = channels == 2 || (std::memcmp(pixel, pixel + sample_bytes, sample_bytes) == 0 &&
                                              std::memcmp(pixel, pixel + 2 * sample_bytes, sample_bytes) == 0);
    if (!colourless) throw FileError(file, "colour", "a grey image", fmt::format("a coloured pixel (number {})", i));
    std::memmove(pixels.data() + i * sample_bytes, pixel, sample_bytes);
  }
  pixels.resize(count * sample_bytes);
  return pixels;
}

void check_size(const std::filesystem::path& file, const OIIO::ImageSpec& spec) {
  if (spec.width < 1 || spec.width > kMaxFileDim || spec.height < 1 || spec.height > kMaxFileDim || spec.depth > 1) {
    throw FileError(file, "size", fmt::format("1..{} pixels a side", kMaxFileDim),
                    fmt::format("{} x {} x {}", spec.width, spec.height, spec.depth));
  }
  if (spec.nchannels < 1 || spec.nchannels > 4) {
    throw FileError(file, "channels", "1 to 4", fmt::format("{}", spec.nchannels));
  }
}

std::unique_ptr<OIIO::ImageInput> open(const std::filesystem::path& file) {
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;  // the colours as stored, not premultiplied
  auto input = OIIO::ImageInput::open(file.string(), &config);
  if (!input) throw FileError(file, "image", "an image that OpenImageIO can read", OIIO::geterror());
  return input;
}

Slice read_page(const std::filesystem::path& file, OIIO::ImageInput& input, int page) {
  const OIIO::ImageSpec spec = input.spec();
  check_size(file, spec);
  Slice slice{spec.width, spec.height, type_of(file, spec.format), {}};
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  const std::size_t sample_bytes = bytes_per_sample(slice.type);
  const std::size_t pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  slice.samples.resize(pixels * channels * sample_bytes);
  if (!input.read_image(page, 0, 0, spec.nchannels, read_as(slice.type), slice.samples.data())) {
    throw FileError(file, "image", "a whole image", input.geterror());
  }
  slice.samples = grey(file, std::move(slice.samples), channels, sample_bytes);
  return slice;
}

Slice read_slice(const std::filesystem::path& file) {
  const auto input = open(file);
  Slice slice = read_page(file, *input, 0);
  if (input->seek_subimage(1, 0)) throw FileError(file, "image", "one image a file", "several");
  return slice;
}

void check_same(const std::filesystem::path& file, const Slice& slice, const Slice& first) {
  if (slice.width != first.width || slice.height != first.height) {
    throw FileError(file, "size", fmt::format("{} x {} as in the first slice", first.width, first.height),
                    fmt::format("{} x {}", slice.width, slice.height));
  }
  if (slice.type != first.type) throw FileError(file, "sample type", "that of the first slice", "another");
}

StoredLayout layout_of(const std::filesystem::path& source, const Slice& first, std::size_t count) {
  StoredLayout layout;
  layout.file = source;
  layout.dims = {first.width, first.height, static_cast<int>(count)};
  layout.type = stored_type(first.type);
  layout.big_endian = std::endian::native == std::endian::big;  // OpenImageIO swaps
  checked_bytes(layout);
  return layout;
}

// A volume of `count` slices; read(z) gives the file and the slice.
template <typename Read>
Volume pile(const std::filesystem::path& source, std::size_t count, const Read& read) {
  StoredLayout layout;
  Slice first;
  std::vector<std::byte> samples;
  for (std::size_t z = 0; z < count; ++z) {
    auto [file, slice] = read(z);
    samples.insert(samples.end(), slice.samples.begin(), slice.samples.end());
    if (z > 0) {
      check_same(file, slice, first);
      continue;
    }
    layout = layout_of(source, slice, count);
    first = std::move(slice);
  }
  return to_volume(std::move(samples), layout);
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a, whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view x = take_number(a), y = take_number(b);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else if (a.front() != b.front()) {
      return a.front() < b.front();
    } else {
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;  // "1" and "01"
}

std::vector<std::filesystem::path> files_with(const std::filesystem::path& folder,
                                              std::initializer_list<std::string_view> extensions) {
  std::vector<std::filesystem::path> files;
  std::error_code fault;
  for (std::filesystem::directory_iterator entry(folder, fault), end; !fault && entry != end; entry.increment(fault)) {
    const std::string extension = lower_case(entry->path().extension().string());
    std::error_code unreadable;
    if (std::ranges::find(extensions, extension) == extensions.end()) continue;
    if (entry->is_regular_file(unreadable)) files.push_back(entry->path());
  }
  if (fault) throw FileError(folder, "folder", "a readable folder", fault.message());
  std::ranges::sort(
      files, [](const auto& a, const auto& b) { return natural_less(a.filename().string(), b.filename().string()); });
  return files;
}

Volume read_slices(const std::filesystem::path& folder) {
  const auto files = slice_files(folder);
  return pile(folder, files.size(), [&](std::size_t z) { return std::pair(files[z], read_slice(files[z])); });
}

Volume open_slices(const std::filesystem::path& folder) {
  const auto files = slice_files(folder);
  Slice first = read_slice(files.front());
  Volume volume = to_volume({}, layout_of(folder, first, files.size()));
  first.samples.clear();
  volume.planes = [files, first](int z, int count, std::span<std::byte> out) {
    for (const int end = z + count; z < end; ++z) {
      const auto& file = files.at(static_cast<std::size_t>(z));
      const Slice slice = read_slice(file);
      check_same(file, slice, first);
      std::ranges::copy(slice.samples, out.begin());
      out = out.subspan(slice.samples.size());
    }
  };
  return volume;
}

Volume read_pages(const std::filesystem::path& file) {
  const auto input = open(file);
  int pages = 1;
  while (pages <= kMaxFileDim && input->seek_subimage(pages, 0)) ++pages;
  if (pages > kMaxFileDim) throw FileError(file, "image", fmt::format("at most {} pages", kMaxFileDim), "more");
  return pile(file, static_cast<std::size_t>(pages), [&](std::size_t z) {
    const int page = static_cast<int>(z);
    if (!input->seek_subimage(page, 0)) throw FileError(file, "image", "a whole image", input->geterror());
    return std::pair(file, read_page(file, *input, page));
  });
}

}  // namespace gicube::scene
