#include "scene/formats/pictures/ome_tiff.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <pugixml.hpp>
#include <string_view>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {
namespace {

// Elements may have a prefix: "ome:Pixels".
bool is_named(const pugi::xml_node& node, std::string_view name) {
  const std::string_view full = node.name();
  return full == name || (full.ends_with(name) && full[full.size() - name.size() - 1] == ':');
}

void check_planes(const std::filesystem::path& file, const pugi::xml_node& pixels, const PageStack& stack) {
  for (const pugi::xml_node& data : pixels.children()) {
    if (!is_named(data, "TiffData")) continue;
    if (data.first_child()) throw FileError(file, "TiffData", "planes in this file", "a UUID of another");
    const int page = data.attribute("IFD").as_int(0), z = data.attribute("FirstZ").as_int(0);
    const int channel = data.attribute("FirstC").as_int(0), time = data.attribute("FirstT").as_int(0);
    const std::int64_t expected =
        std::int64_t{z} * stack.steps[0] + std::int64_t{channel} * stack.steps[1] + std::int64_t{time} * stack.steps[2];
    if (page != expected)
      throw FileError(file, "TiffData", fmt::format("plane {} in page {}", z, expected), fmt::format("{}", page));
  }
}

// pugixml would read it as the locale writes numbers.
double length_of(const std::filesystem::path& file, const pugi::xml_node& pixels, const char* name) {
  const pugi::xml_attribute length = pixels.attribute(name);
  if (!length) return 1;
  const auto value = parse_number<double>(trimmed(length.value()));
  if (!value) throw FileError(file, name, "a number", in_quotes(length.value()));
  return *value;
}

// Reads whole numbers of a TIFF, in its order of bytes.
class TiffNumbers {
 public:
  explicit TiffNumbers(const std::filesystem::path& file) : input_(file, std::ios::binary) {
    std::array<char, 2> order{};
    input_.read(order.data(), 2);
    is_big_ = order[0] == 'M';
    is_known_ = order[0] == order[1] && (is_big_ || order[0] == 'I');
  }
  bool is_known() const { return is_known_; }
  bool is_big() const { return is_big_; }
  void seek(std::uint64_t at) { input_.seekg(static_cast<std::streamoff>(at)); }
  // Nothing behind the file's end.
  std::optional<std::uint64_t> next(std::size_t bytes) {
    std::array<unsigned char, 8> read{};
    if (!input_.read(reinterpret_cast<char*>(read.data()), static_cast<std::streamsize>(bytes))) return std::nullopt;
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | read[is_big_ ? i : bytes - 1 - i];
    return value;
  }

 private:
  std::ifstream input_;
  bool is_big_ = false, is_known_ = false;
};

}  // namespace

std::optional<std::vector<int>> tiff_pages(const std::filesystem::path& file) {
  constexpr std::uint64_t kMaxEntries = std::uint64_t{1} << 20;  // chosen: a page has some 20, and there may be loops
  constexpr int kClassic = 42, kBig = 43, kNewSubfileType = 254, kBits = 258, kLong = 4, kReduced = 1, kMask = 4;
  TiffNumbers numbers(file);
  const auto version = numbers.is_known() ? numbers.next(2) : std::nullopt;
  if (version != kClassic && version != kBig) return std::nullopt;
  const bool big = version == kBig;
  const std::size_t offset_bytes = big ? 8 : 4, count_bytes = big ? 8 : 2;
  if (big) numbers.seek(8);
  std::vector<int> pages;
  std::uint64_t at = numbers.next(offset_bytes).value_or(0);
  std::uint64_t all = 0;
  for (int page = 0; at != 0; ++page) {
    numbers.seek(at);
    const std::uint64_t entries = numbers.next(count_bytes).value_or(0);
    all += std::min(entries, kMaxEntries) + 1;
    if (all > kMaxEntries)
      throw FileError(file, "image", fmt::format("at most {} entries of pages", kMaxEntries), "more");
    bool is_full = true, has_bits = false;
    for (std::uint64_t i = 0; i < entries; ++i) {
      const auto tag = numbers.next(2), type = numbers.next(2), count = numbers.next(offset_bytes);
      const auto value = numbers.next(4);  // a LONG's; in BigTIFF four bytes more belong to it
      if (big) numbers.next(4);
      has_bits = has_bits || tag == kBits;
      if (tag == kNewSubfileType && type == kLong && count == 1)
        is_full = (value.value_or(0) & (kReduced | kMask)) == 0;
    }
    const auto next = numbers.next(offset_bytes);
    if (!next) {
      throw FileError(file, "image", fmt::format("page {} at byte {}", page, at), "the file's end (truncated)");
    }
    // OpenImageIO takes the packed bits of such a page for bytes.
    if (is_full && !has_bits) throw FileError(file, "BitsPerSample", "8, 16 or 32", "none, which means 1");
    if (is_full) pages.push_back(page);
    at = *next;
  }
  return pages;
}

std::optional<PageStack> ome_pixels(const std::filesystem::path& file, const std::string& description) {
  if (description.find("<OME") == std::string::npos && description.find(":OME") == std::string::npos)
    return std::nullopt;
  pugi::xml_document document;
  if (const auto parsed = document.load_string(description.c_str()); !parsed) {
    throw FileError(file, "ImageDescription", "an OME document", parsed.description());
  }
  const pugi::xml_node pixels = document.find_node([](const pugi::xml_node& node) { return is_named(node, "Pixels"); });
  if (!pixels) throw FileError(file, "Pixels", "an element of the OME document", "none");
  const auto size = [&](const char* name) {
    const int count = pixels.attribute(name).as_int(1);
    if (count < 1 || count > kMaxParts)
      throw FileError(file, name, fmt::format("1..{}", kMaxParts), pixels.attribute(name).value());
    return count;
  };
  PageStack out{size("SizeZ"), size("SizeC"), size("SizeT")};
  if (std::int64_t{out.z} * out.channels > kMaxParts)
    throw FileError(file, "SizeC", fmt::format("at most {} pages", kMaxParts),
                    fmt::format("{} x {}", out.z, out.channels));
  // Three samples of a pixel are one channel of colours.
  if (pixels.child("Channel").attribute("SamplesPerPixel").as_int(1) == out.channels) out.channels = 1;
  const std::string order = pixels.attribute("DimensionOrder").as_string("XYZCT");
  if (order.size() != 5 || !order.starts_with("XY"))
    throw FileError(file, "DimensionOrder", "XY and Z, C, T", in_quotes(order));
  int step = 1;
  for (const char axis : order.substr(2)) {
    const std::size_t at = std::string_view("ZCT").find(axis);
    if (at == std::string_view::npos) throw FileError(file, "DimensionOrder", "XY and Z, C, T", in_quotes(order));
    out.steps[at] = step;
    step *= std::array{out.z, out.channels, out.times}[at];
  }
  check_planes(file, pixels, out);
  const auto unit = [&](const char* name) { return std::string_view(pixels.attribute(name).as_string("\xC2\xB5m")); };
  if (unit("PhysicalSizeXUnit") != unit("PhysicalSizeYUnit") ||
      unit("PhysicalSizeXUnit") != unit("PhysicalSizeZUnit")) {
    throw FileError(file, "PhysicalSizeXUnit", "the same unit along x, y and z", "different ones");
  }
  const auto length = [&](const char* name) { return length_of(file, pixels, name); };
  out.spacing = {length("PhysicalSizeX"), length("PhysicalSizeY"), length("PhysicalSizeZ")};
  if (out.z > 1 && pixels.attribute("PhysicalSizeX") && !pixels.attribute("PhysicalSizeZ"))
    warn(file, "PhysicalSizeZ", "a length, as PhysicalSizeX has one", "none; 1 is taken");
  return out;
}

std::optional<PageStack> imagej_stack(const std::filesystem::path& file, const std::string& description, int pages,
                                      const std::array<double, 2>& edges) {
  if (!description.starts_with("ImageJ=")) return std::nullopt;
  const auto value = [&](std::string_view key) -> std::string_view {
    const std::string start = '\n' + std::string(key) + '=';
    const std::size_t at = description.find(start);
    if (at == std::string::npos) return {};
    const std::string_view rest = std::string_view(description).substr(at + start.size());
    return trimmed(rest.substr(0, rest.find('\n')));
  };
  const auto count = [&](const char* key, int otherwise) {
    const std::string_view text = value(key);
    const auto number = text.empty() ? std::optional(otherwise) : parse_number<int>(text);
    if (!number || *number < 1 || *number > kMaxParts)
      throw FileError(file, key, fmt::format("1..{}", kMaxParts), in_quotes(text));
    return *number;
  };
  const int images = count("images", pages);
  PageStack out{1, count("channels", 1), count("frames", 1)};
  const std::int64_t others = std::int64_t{out.channels} * out.times;
  out.z = count("slices", static_cast<int>(std::max<std::int64_t>(images / others, 1)));
  if (others * out.z != images) {
    throw FileError(file, "images",
                    fmt::format("channels x slices x frames, {} x {} x {}", out.channels, out.z, out.times),
                    fmt::format("{}", images));
  }
  out.steps = {out.channels, 1, out.channels * out.z};
  if (value("unit").empty()) return out;
  const auto spacing = parse_number<double>(value("spacing"));
  out.spacing = {edges[0], edges[1], spacing.value_or(1)};
  if (!spacing && out.z > 1) warn(file, "spacing", "a length along z, as there is a unit", "none; 1 is taken");
  return out;
}

std::optional<FirstStrip> first_strip(const std::filesystem::path& file) {
  constexpr int kCompression = 259, kStripOffsets = 273, kShort = 3;
  TiffNumbers numbers(file);
  if (!numbers.is_known() || numbers.next(2) != 42) return std::nullopt;  // ImageJ writes no BigTIFF
  numbers.seek(numbers.next(4).value_or(0));
  FirstStrip strip;
  strip.big_endian = numbers.is_big();
  for (std::uint64_t i = numbers.next(2).value_or(0); i > 0; --i) {
    const auto tag = numbers.next(2), type = numbers.next(2), count = numbers.next(4);
    const bool narrow = type == kShort;
    const auto value = numbers.next(narrow ? 2 : 4);
    if (narrow) numbers.next(2);
    if (tag == kCompression && value != 1) return std::nullopt;
    if (tag == kStripOffsets && count == 1) strip.offset = value.value_or(0);
  }
  return strip.offset > 0 ? std::optional(strip) : std::nullopt;
}

}  // namespace gicube::scene
