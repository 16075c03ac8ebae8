#include "scene/formats/readers.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scene/common/checks.h"
#include "scene/formats/pictures/ome_tiff.h"
#include "scene/formats/pictures/picture_library.h"
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

// From one name to the next in natural order, which differ in a number alone; 0 if they don't.
std::uint64_t step_between(std::string_view a, std::string_view b) {
  const auto differ = std::ranges::mismatch(a, b).in1;
  auto begin = static_cast<std::size_t>(differ - a.begin());
  while (begin > 0 && is_digit(a[begin - 1])) --begin;
  a.remove_prefix(begin);
  b.remove_prefix(begin);
  const auto from = parse_number<std::uint64_t>(take_number(a)), to = parse_number<std::uint64_t>(take_number(b));
  return from && to && a == b && *from < *to ? *to - *from : 0;
}

// Where numbers are missing in a series of names, in steps of its least one.
void warn_of_gaps(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& files) {
  const auto name = [&files](std::size_t i) { return files[i].filename().string(); };
  std::vector<std::uint64_t> steps;
  for (std::size_t i = 1; i < files.size(); ++i) steps.push_back(step_between(name(i - 1), name(i)));
  std::uint64_t missing = 0;
  std::string between;
  for (std::size_t first = 0, end; first < steps.size(); first = end + 1) {
    end = static_cast<std::size_t>(std::find(steps.begin() + static_cast<std::ptrdiff_t>(first), steps.end(), 0u) -
                                   steps.begin());
    if (end == first) continue;
    const std::uint64_t least = std::ranges::min(std::span(steps).subspan(first, end - first));
    for (std::size_t i = first; i < end; ++i) {
      if (missing == 0 && steps[i] >= 2 * least) between = name(i) + " and " + name(i + 1);
      missing += steps[i] / least - 1;
    }
  }
  if (missing > 0) {
    warn(folder, "files", "numbers without gaps", fmt::format("{} missing, the first between {}", missing, between));
  }
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
  StoredType type = StoredType::kUint8;
  std::size_t channels = 1;
  std::vector<std::byte> samples;
  std::vector<std::uint8_t> colours;  // of coloured slices, three bytes a pixel
};

// Whether red, green and blue differ in a pixel.
bool has_colour(std::span<const std::byte> pixels, std::size_t channels, std::size_t sample_bytes) {
  for (std::size_t at = 0; channels >= 3 && at < pixels.size(); at += channels * sample_bytes) {
    const std::byte* pixel = pixels.data() + at;
    if (std::memcmp(pixel, pixel + sample_bytes, sample_bytes) != 0) return true;
    if (std::memcmp(pixel, pixel + 2 * sample_bytes, sample_bytes) != 0) return true;
  }
  return false;
}

// The first of the `channels` samples of each pixel.
std::vector<std::byte> grey(std::vector<std::byte> pixels, std::size_t channels, std::size_t sample_bytes) {
  if (channels == 1) return pixels;
  const std::size_t count = pixels.size() / (channels * sample_bytes);
  for (std::size_t i = 0; i < count; ++i) {
    std::memmove(pixels.data() + i * sample_bytes, pixels.data() + i * channels * sample_bytes, sample_bytes);
  }
  pixels.resize(count * sample_bytes);
  return pixels;
}

void check_page(const std::filesystem::path& file, const PictureReader::Page& page) {
  if (page.width < 1 || page.width > kMaxFileDim || page.height < 1 || page.height > kMaxFileDim || page.depth > 1) {
    throw FileError(file, "size", fmt::format("1..{} pixels a side", kMaxFileDim),
                    fmt::format("{} x {} x {}", page.width, page.height, page.depth));
  }
  if (page.channels < 1 || page.channels > 4) {
    throw FileError(file, "channels", "1 to 4", fmt::format("{}", page.channels));
  }
  if (!page.type) throw FileError(file, "sample type", "8, 16 or 32 bits, float or double", page.type_name);
}

std::unique_ptr<PictureReader> open(const std::filesystem::path& file) {
  std::string error;
  auto reader = picture_library(file).open(file, error);
  if (!reader) throw FileError(file, "image", "an image that OpenImageIO can read", error);
  return reader;
}

// All channels of its pixels.
Slice read_pixels(const std::filesystem::path& file, PictureReader& reader, int number) {
  const PictureReader::Page page = reader.page();
  check_page(file, page);
  Slice slice{page.width, page.height, *page.type, static_cast<std::size_t>(page.channels), {}, {}};
  const std::size_t pixels = static_cast<std::size_t>(page.width) * static_cast<std::size_t>(page.height);
  slice.samples.resize(pixels * slice.channels * bytes_of(slice.type));
  if (!reader.read(number, slice.type, slice.samples)) {
    throw FileError(file, "image", "a whole image", reader.error());
  }
  return slice;
}

// The numbers of the pages that are slices.
std::vector<int> full_pages(const std::filesystem::path& file, PictureReader& reader) {
  auto pages = tiff_pages(file);
  if (!pages) {
    pages.emplace();
    for (int page = 0; page <= kMaxFileDim && reader.seek(page); ++page) pages->push_back(page);
  }
  if (pages->size() > kMaxFileDim) throw FileError(file, "image", fmt::format("at most {} pages", kMaxFileDim), "more");
  if (pages->empty()) throw FileError(file, "image", "a page of full resolution", "none");
  return *pages;
}

Slice read_page(const std::filesystem::path& file, PictureReader& reader, int page) {
  if (!reader.seek(page)) throw FileError(file, "image", "a whole image", reader.error());
  return read_pixels(file, reader, page);
}

Slice read_pixels(const std::filesystem::path& file) {
  const auto reader = open(file);
  const std::vector<int> pages = full_pages(file, *reader);
  if (pages.size() > 1) throw FileError(file, "image", "one image a file", "several");
  return read_page(file, *reader, pages.front());
}

bool is_coloured(const Slice& pixels) { return has_colour(pixels.samples, pixels.channels, bytes_of(pixels.type)); }

// Its samples, and if the volume is coloured its colours. `first`: the volume's first slice with its channels.
Slice slice_of(const std::filesystem::path& file, Slice pixels, bool coloured, const Slice& first) {
  if (!coloured) {
    pixels.samples = grey(std::move(pixels.samples), pixels.channels, bytes_of(pixels.type));
    return pixels;
  }
  const bool narrow = pixels.type == StoredType::kUint8;
  if (!narrow && pixels.type != StoredType::kUint16) {
    throw FileError(file, "sample type", "8 or 16 bits, as the volume has colours", "another");
  }
  if (pixels.channels < 3 || pixels.channels != first.channels) {
    throw FileError(file, "channels",
                    fmt::format("{} as in the first slice, as the volume has colours", first.channels),
                    fmt::format("{}", pixels.channels));
  }
  const std::vector<std::byte> all = std::move(pixels.samples);
  take_colours(all, pixels.channels, narrow ? SampleType::kUint8 : SampleType::kUint16, pixels.samples, pixels.colours);
  pixels.type = StoredType::kUint8;
  return pixels;
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
  layout.type = first.type;
  layout.big_endian = std::endian::native == std::endian::big;  // OpenImageIO swaps
  checked_bytes(layout);
  return layout;
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
    if (entry->path().filename().string().starts_with('.')) continue;
    if (entry->is_regular_file(unreadable)) files.push_back(entry->path());
  }
  if (fault) throw FileError(folder, "folder", "a readable folder", fault.message());
  std::ranges::sort(
      files, [](const auto& a, const auto& b) { return natural_less(a.filename().string(), b.filename().string()); });
  warn_of_gaps(folder, files);
  return files;
}

Volume read_slices(const std::filesystem::path& folder) {
  const auto files = slice_files(folder);
  std::vector<Slice> slices;
  bool coloured = false;
  for (const auto& file : files) {
    slices.push_back(read_pixels(file));
    if (slices.size() > 1) check_same(file, slices.back(), slices.front());
    coloured = coloured || is_coloured(slices.back());
  }
  Slice first = slices.front();
  first.samples.clear();
  std::vector<std::byte> samples;
  std::vector<std::uint8_t> colours;
  for (std::size_t z = 0; z < files.size(); ++z) {
    const Slice slice = slice_of(files[z], std::exchange(slices[z], {}), coloured, first);
    samples.insert(samples.end(), slice.samples.begin(), slice.samples.end());
    colours.insert(colours.end(), slice.colours.begin(), slice.colours.end());
  }
  if (coloured) first.type = StoredType::kUint8;
  Volume volume = to_volume(std::move(samples), layout_of(folder, first, files.size()));
  volume.colours = std::move(colours);
  return volume;
}

Volume open_slices(const std::filesystem::path& folder) {
  const auto files = slice_files(folder);
  Slice first = read_pixels(files.front());
  bool coloured = is_coloured(first);
  first.samples.clear();
  for (std::size_t z = 1; z < files.size() && !coloured && first.channels >= 3; ++z) {
    coloured = is_coloured(read_pixels(files[z]));
  }
  Slice stored = first;
  if (coloured) stored.type = StoredType::kUint8;
  const StoredLayout layout = layout_of(folder, stored, files.size());
  Volume volume = to_volume({}, layout);
  // The colours of the planes that were read last, since both readers are asked for the same ones.
  const auto colours = std::make_shared<std::vector<std::uint8_t>>();
  volume.planes = [files, first, coloured, colours, layout](int z, int count, std::span<std::byte> out) {
    colours->clear();
    for (const int end = z + count; z < end; ++z) {
      const auto& file = files.at(static_cast<std::size_t>(z));
      Slice pixels = read_pixels(file);
      check_same(file, pixels, first);
      const Slice slice = slice_of(file, std::move(pixels), coloured, first);
      StoredLayout plane = layout;
      plane.dims[2] = 1;
      const Volume made = to_volume(slice.samples, plane);
      std::ranges::copy(made.samples, out.begin());
      out = out.subspan(made.samples.size());
      colours->insert(colours->end(), slice.colours.begin(), slice.colours.end());
    }
  };
  if (coloured) {
    volume.colour_planes = [colours](int, int, std::span<std::byte> out) {
      std::ranges::copy(std::as_bytes(std::span(*colours)), out.begin());
    };
  }
  return volume;
}

namespace {

// Planes of ImageJ, which follow each other behind the one page.
StoredFile planes_behind(const std::filesystem::path& file, const Slice& first, const PageStack& stack,
                         std::size_t chosen) {
  const auto strip = first_strip(file);
  if (!strip || stack.channels > 1 || first.channels > 1) {
    throw FileError(file, "image",
                    fmt::format("{} pages, or grey planes of one channel that are not compressed", stack.z),
                    "one page");
  }
  StoredFile stored{layout_of(file, first, static_cast<std::size_t>(stack.z)), {}, Encoding::kBytes};
  stored.layout.big_endian = strip->big_endian;
  stored.layout.spacing = stack.spacing;
  stored.place.file = file;
  stored.place.offset = strip->offset;
  stored.place.skip = chosen * std::uint64_t{checked_bytes(stored.layout)};
  return stored;
}

}  // namespace

Volume open_pages(const std::filesystem::path& file, const std::string& part) {
  const std::shared_ptr<PictureReader> reader = open(file);
  const std::string description = reader->description();
  std::vector<int> pages = full_pages(file, *reader);
  const auto edge = [&](const char* resolution) {
    const double pixels = reader->number(resolution);
    return pixels > 0 ? 1 / pixels : 1;
  };
  auto stack = ome_pixels(file, description);
  const bool ome = stack.has_value();
  if (!stack)
    stack = imagej_stack(file, description, static_cast<int>(pages.size()), {edge("XResolution"), edge("YResolution")});
  const auto read = [file, reader](int page) {
    Slice pixels = read_page(file, *reader, page);
    if (is_coloured(pixels)) throw FileError(file, "colour", "a grey image", "a coloured one");
    return pixels;
  };
  Slice first = read(pages.front());
  first.samples.clear();
  if (stack) {
    if (stack->z > kMaxFileDim)
      throw FileError(file, "slices", fmt::format("at most {}", kMaxFileDim), fmt::format("{}", stack->z));
    const std::int64_t planes = std::int64_t{stack->z} * stack->channels * stack->times;
    const std::size_t chosen = chosen_part(file,
                                           stack->times > 1 && stack->channels > 1
                                               ? fmt::format("time and channel, of {} channels each", stack->channels)
                                           : stack->times > 1 ? "time"
                                                              : "channel",
                                           std::int64_t{stack->channels} * stack->times, part);
    if (!ome && pages.size() == 1 && planes > 1) return open_stored(planes_behind(file, first, *stack, chosen));
    if (planes != static_cast<std::int64_t>(pages.size())) {
      throw FileError(file, ome ? "SizeZ" : "images", fmt::format("{}, a plane a page", pages.size()),
                      fmt::format("{}", planes));
    }
    const auto channels = static_cast<std::size_t>(stack->channels);
    const std::size_t begin = chosen % channels * static_cast<std::size_t>(stack->steps[1]) +
                              chosen / channels * static_cast<std::size_t>(stack->steps[2]);
    std::vector<int> own;
    for (int z = 0; z < stack->z; ++z) own.push_back(pages.at(begin + static_cast<std::size_t>(z * stack->steps[0])));
    pages = std::move(own);
  } else {
    chosen_part(file, "volume", 1, part);
  }
  const StoredLayout layout = layout_of(file, first, pages.size());
  Volume volume = to_volume({}, layout);
  if (stack) volume.spacing = stack->spacing;
  volume.planes = [file, first, read, pages, layout](int z, int count, std::span<std::byte> out) {
    for (const int end = z + count; z < end; ++z) {
      Slice pixels = read(pages.at(static_cast<std::size_t>(z)));
      check_same(file, pixels, first);
      StoredLayout plane = layout;
      plane.dims[2] = 1;
      const Volume slice = to_volume(slice_of(file, std::move(pixels), false, first).samples, plane);
      std::ranges::copy(slice.samples, out.begin());
      out = out.subspan(slice.samples.size());
    }
  };
  return volume;
}

Volume read_pages(const std::filesystem::path& file, const std::string& part) {
  Volume volume = open_pages(file, part);
  if (volume.planes) take_planes(volume);
  return volume;
}

}  // namespace gicube::scene
