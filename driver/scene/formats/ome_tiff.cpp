#include "scene/formats/ome_tiff.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <pugixml.hpp>
#include <string_view>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

// Elements may have a prefix: "ome:Pixels".
bool is_named(const pugi::xml_node& node, std::string_view name) {
  const std::string_view full = node.name();
  return full == name || (full.ends_with(name) && full[full.size() - name.size() - 1] == ':');
}

void check_planes(const std::filesystem::path& file, const pugi::xml_node& pixels) {
  for (const pugi::xml_node& data : pixels.children()) {
    if (!is_named(data, "TiffData")) continue;
    if (data.first_child()) throw FileError(file, "TiffData", "planes in this file", "a UUID of another");
    const int page = data.attribute("IFD").as_int(0), z = data.attribute("FirstZ").as_int(0);
    if (page != z) throw FileError(file, "TiffData", fmt::format("plane {} in page {}", z, z), fmt::format("{}", page));
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
  constexpr int kClassic = 42, kBig = 43, kNewSubfileType = 254, kLong = 4, kReduced = 1, kMask = 4;
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
    bool is_full = true;
    for (std::uint64_t i = 0; i < entries; ++i) {
      const auto tag = numbers.next(2), type = numbers.next(2), count = numbers.next(offset_bytes);
      const auto value = numbers.next(4);  // a LONG's; in BigTIFF four bytes more belong to it
      if (big) numbers.next(4);
      if (tag == kNewSubfileType && type == kLong && count == 1)
        is_full = (value.value_or(0) & (kReduced | kMask)) == 0;
    }
    const auto next = numbers.next(offset_bytes);
    if (!next) {
      throw FileError(file, "image", fmt::format("page {} at byte {}", page, at), "the file's end (truncated)");
    }
    if (is_full) pages.push_back(page);
    at = *next;
  }
  return pages;
}

std::optional<OmePixels> ome_pixels(const std::filesystem::path& file, const std::string& description) {
  if (description.find("<OME") == std::string::npos && description.find(":OME") == std::string::npos)
    return std::nullopt;
  pugi::xml_document document;
  if (const auto parsed = document.load_string(description.c_str()); !parsed) {
    throw FileError(file, "ImageDescription", "an OME document", parsed.description());
  }
  const pugi::xml_node pixels = document.find_node([](const pugi::xml_node& node) { return is_named(node, "Pixels"); });
  if (!pixels) throw FileError(file, "Pixels", "an element of the OME document", "none");
  for (const char* const name : {"SizeC", "SizeT"}) {
    if (const int size = pixels.attribute(name).as_int(1); size != 1) {
      throw FileError(file, name, "1", fmt::format("{}", size));
    }
  }
  check_planes(file, pixels);
  OmePixels out{.size_z = pixels.attribute("SizeZ").as_int(0)};
  if (out.size_z < 1) throw FileError(file, "SizeZ", "1 or more", pixels.attribute("SizeZ").value());
  const auto unit = [&](const char* name) { return std::string_view(pixels.attribute(name).as_string("\xC2\xB5m")); };
  if (unit("PhysicalSizeXUnit") != unit("PhysicalSizeYUnit") ||
      unit("PhysicalSizeXUnit") != unit("PhysicalSizeZUnit")) {
    throw FileError(file, "PhysicalSizeXUnit", "the same unit along x, y and z", "different ones");
  }
  const auto length = [&](const char* name) { return length_of(file, pixels, name); };
  out.spacing = {length("PhysicalSizeX"), length("PhysicalSizeY"), length("PhysicalSizeZ")};
  return out;
}

}  // namespace gicube::scene
