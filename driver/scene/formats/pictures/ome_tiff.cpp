#include "scene/formats/pictures/ome_tiff.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <pugixml.hpp>
#include <string_view>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {
namespace {

// Whether an element has this name, possibly with a prefix: "ome:Pixels".
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

// A length in the C locale: pugixml uses the locale of the application.
double length_of(const std::filesystem::path& file, const pugi::xml_node& pixels, const char* name) {
  const pugi::xml_attribute length = pixels.attribute(name);
  if (!length) return 1;
  const auto value = parse_number<double>(trimmed(length.value()));
  if (!value) throw FileError(file, name, "a number", in_quotes(length.value()));
  return *value;
}

}  // namespace

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
  // If a pixel has as many samples as there are channels, they are one channel of colours.
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

}  // namespace gicube::scene
