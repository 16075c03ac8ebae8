#include "scene/formats/readers.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <functional>
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

// Removes the run of digits from the front of `text`; returns it without leading zeros.
std::string_view take_number(std::string_view& text) {
  std::size_t end = 0;
  while (end < text.size() && is_digit(text[end])) ++end;
  std::string_view number = text.substr(0, end);
  text.remove_prefix(end);
  while (number.size() > 1 && number.front() == '0') number.remove_prefix(1);
  return number;
}

// The difference of two names that differ only in a number; 0 if they differ otherwise.
std::uint64_t step_between(std::string_view a, std::string_view b) {
  const auto differ = std::ranges::mismatch(a, b).in1;
  auto begin = static_cast<std::size_t>(differ - a.begin());
  while (begin > 0 && is_digit(a[begin - 1])) --begin;
  a.remove_prefix(begin);
  b.remove_prefix(begin);
  const auto from = parse_number<std::uint64_t>(take_number(a)), to = parse_number<std::uint64_t>(take_number(b));
  return from && to && a == b && *from < *to ? *to - *from : 0;
}

// Warns if numbers are missing in a series of names, whose step is the least difference.
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
  auto files = files_with(folder, kPictures);
  if (files.empty()) throw FileError(folder, "folder", "image slices", "no image file");
  if (files.size() > kMaxFileDim) {
    throw FileError(folder, "folder", fmt::format("at most {} slices", kMaxFileDim), fmt::format("{}", files.size()));
  }
  return files;
}

// All channels of a picture's pixels.
struct Pixels {
  std::filesystem::path file;
  int width = 0, height = 0;
  StoredType type = StoredType::kUint8;
  int channels = 1;
  std::vector<std::byte> samples;
};

// Whether red, green and blue differ in a pixel.
bool is_coloured(const Pixels& pixels) {
  const std::size_t bytes = bytes_of(pixels.type), step = static_cast<std::size_t>(pixels.channels) * bytes;
  for (std::size_t at = 0; pixels.channels >= 3 && at < pixels.samples.size(); at += step) {
    const std::byte* const red = &pixels.samples[at];
    if (std::memcmp(red, red + bytes, bytes) != 0 || std::memcmp(red, red + 2 * bytes, bytes) != 0) return true;
  }
  return false;
}

std::unique_ptr<PictureReader> open(const std::filesystem::path& file) {
  std::string error;
  auto reader = picture_library(file).open(file, error);
  if (!reader) throw FileError(file, "image", "an image that OpenImageIO can read", error);
  return reader;
}

std::vector<int> pages_of(const std::filesystem::path& file, PictureReader& reader) {
  auto pages = reader.pages();
  if (!pages) throw FileError(file, "image", "pages that each lead to the next", reader.error() + " (truncated)");
  if (pages->size() > kMaxFileDim) throw FileError(file, "image", fmt::format("at most {} pages", kMaxFileDim), "more");
  if (pages->empty()) throw FileError(file, "image", "a page of full resolution", "none");
  return *pages;
}

Pixels read_page(const std::filesystem::path& file, PictureReader& reader, int number) {
  if (!reader.seek(number)) throw FileError(file, "image", "a whole image", reader.error());
  const PictureReader::Page page = reader.page();
  if (page.width < 1 || page.width > kMaxFileDim || page.height < 1 || page.height > kMaxFileDim || page.depth > 1) {
    throw FileError(file, "size", fmt::format("1..{} pixels a side", kMaxFileDim),
                    fmt::format("{} x {} x {}", page.width, page.height, page.depth));
  }
  if (page.channels < 1 || page.channels > 4) {
    throw FileError(file, "channels", "1 to 4", fmt::format("{}", page.channels));
  }
  if (!page.type)
    throw FileError(file, "sample type", "integers of 1 to 64 bits, half, float, double or complex", page.type_name);
  Pixels pixels{file, page.width, page.height, *page.type, page.channels, {}};
  pixels.samples.resize(voxels_of({page.width, page.height, page.channels}) * bytes_of(pixels.type));
  if (!reader.read(number, pixels.type, pixels.samples)) {
    throw FileError(file, "image", "a whole image", reader.error());
  }
  return pixels;
}

Pixels read_picture(const std::filesystem::path& file) {
  const auto reader = open(file);
  const std::vector<int> pages = pages_of(file, *reader);
  if (pages.size() > 1) throw FileError(file, "image", "one image a file", "several");
  return read_page(file, *reader, pages.front());
}

// A plane of the volume: the first channel, or the colours.
Volume plane_of(Pixels pixels, const Pixels& first, bool coloured) {
  const std::filesystem::path& file = pixels.file;
  if (pixels.width != first.width || pixels.height != first.height) {
    throw FileError(file, "size", fmt::format("{} x {} as in the first slice", first.width, first.height),
                    fmt::format("{} x {}", pixels.width, pixels.height));
  }
  if (pixels.type != first.type) throw FileError(file, "sample type", "that of the first slice", "another");
  if (coloured && pixels.channels != first.channels) {
    throw FileError(file, "channels",
                    fmt::format("{} as in the first slice, as the volume has colours", first.channels),
                    fmt::format("{}", pixels.channels));
  }
  if (!coloured && is_coloured(pixels)) throw FileError(file, "colour", "a grey image", "a coloured one");
  StoredLayout layout;
  layout.file = file;
  layout.dims = {pixels.width, pixels.height, 1};
  layout.type = pixels.type;
  layout.big_endian = std::endian::native == std::endian::big;  // the picture library swaps
  layout.channels = pixels.channels;
  layout.channel = coloured ? -1 : 0;
  return to_volume(std::move(pixels.samples), layout);
}

StoredLayout layout_of(const std::filesystem::path& source, const Pixels& first, std::size_t count) {
  StoredLayout layout;
  layout.file = source;
  layout.dims = {first.width, first.height, static_cast<int>(count)};
  layout.type = first.type;
  checked_bytes(layout);
  return layout;
}

// A volume in planes, which read(z) returns.
Volume stack_of(const StoredLayout& layout, const Pixels& first, bool coloured, std::function<Pixels(int)> read) {
  Volume volume = to_volume({}, layout);
  // The colours of the planes read last: both readers are called for the same planes.
  const auto colours = std::make_shared<std::vector<std::uint8_t>>();
  volume.planes = [=, read = std::move(read)](int z, int count, std::span<std::byte> out) {
    colours->clear();
    for (const int end = z + count; z < end; ++z) {
      const Volume plane = plane_of(read(z), first, coloured);
      std::ranges::copy(plane.samples, out.begin());
      out = out.subspan(plane.samples.size());
      colours->insert(colours->end(), plane.colours.begin(), plane.colours.end());
    }
  };
  if (!coloured) return volume;
  volume.colour_planes = [colours](int, int, std::span<std::byte> out) {
    std::ranges::copy(std::as_bytes(std::span(*colours)), out.begin());
  };
  return volume;
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

Volume open_slices(const std::filesystem::path& folder) {
  const auto files = slice_files(folder);
  Pixels first = read_picture(files.front());
  bool coloured = is_coloured(first);
  for (std::size_t z = 1; z < files.size() && !coloured && first.channels >= 3; ++z) {
    coloured = is_coloured(read_picture(files[z]));
  }
  first.samples.clear();
  StoredLayout layout = layout_of(folder, first, files.size());
  if (coloured) layout.type = StoredType::kUint8;
  return stack_of(layout, first, coloured,
                  [files](int z) { return read_picture(files.at(static_cast<std::size_t>(z))); });
}

namespace {

// Planes of ImageJ that follow each other after the only page.
StoredFile planes_behind(PictureReader& reader, const Pixels& first, const PageStack& stack, std::size_t chosen) {
  const auto strip = reader.only_strip();
  if (!strip || stack.channels > 1 || first.channels > 1) {
    throw FileError(first.file, "image",
                    fmt::format("{} pages, or grey planes of one channel that are not compressed", stack.z),
                    "one page");
  }
  StoredFile stored{layout_of(first.file, first, static_cast<std::size_t>(stack.z)), {}, Encoding::kBytes};
  stored.layout.big_endian = strip->big_endian;
  stored.layout.spacing = stack.spacing;
  stored.place.file = first.file;
  stored.place.offset = strip->offset;
  stored.place.skip = chosen * std::uint64_t{checked_bytes(stored.layout)};
  return stored;
}

}  // namespace

Volume open_pages(const std::filesystem::path& file, const std::string& part) {
  const std::shared_ptr<PictureReader> reader = open(file);
  const std::string description = reader->description();
  const auto edge = [&](const char* resolution) {
    const double pixels = reader->number(resolution);
    return pixels > 0 ? 1 / pixels : 1;
  };
  const std::array edges{edge("XResolution"), edge("YResolution")};
  std::vector<int> pages = pages_of(file, *reader);
  auto stack = ome_pixels(file, description);
  const bool ome = stack.has_value();
  if (!stack) stack = imagej_stack(file, description, static_cast<int>(pages.size()), edges);
  Pixels first = read_page(file, *reader, pages.front());
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
    if (!ome && pages.size() == 1 && planes > 1) return open_stored(planes_behind(*reader, first, *stack, chosen));
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
  StoredLayout layout = layout_of(file, first, pages.size());
  if (stack) layout.spacing = stack->spacing;
  return stack_of(layout, first, false, [file, reader, pages](int z) {
    return read_page(file, *reader, pages.at(static_cast<std::size_t>(z)));
  });
}

Volume read_pages(const std::filesystem::path& file) {
  Volume volume = open_pages(file);
  take_planes(volume);
  return volume;
}

}  // namespace gicube::scene
