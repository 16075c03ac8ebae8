#include "scene/formats/readers.h"

#include <algorithm>
#include <bit>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "scene/common/checks.h"
#include "scene/formats/data_stream.h"
#include "scene/formats/header_lines.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {
namespace {

class Header {
 public:
  explicit Header(const std::filesystem::path& file) : file_(file) {
    const HeaderLines lines =
        read_header_lines(file, [](std::string_view line) { return key_of(line) == "ElementDataFile"; });
    end_ = lines.end;
    if (lines.complete &&
        trimmed(std::string_view(lines.lines.back()).substr(lines.lines.back().find('=') + 1)).starts_with("LIST"))
      list_ = read_header_lines(file, [](std::string_view) { return false; }).lines;
    list_.erase(list_.begin(), list_.begin() + static_cast<std::ptrdiff_t>(std::min(list_.size(), lines.lines.size())));
    for (const std::string& line : lines.lines) {
      const std::size_t equals = line.find('=');
      if (trimmed(line).empty()) continue;
      if (equals == std::string::npos)
        throw FileError(file, "header", "lines \"Key = Value\"", in_quotes(line.substr(0, 40)));
      values_[std::string(key_of(line))] = std::string(trimmed(std::string_view(line).substr(equals + 1)));
    }
  }

  static std::string_view key_of(std::string_view line) { return trimmed(line.substr(0, line.find('='))); }

  std::uint64_t end() const { return end_; }
  const std::vector<std::string>& list() const { return list_; }  // the lines after "ElementDataFile = LIST"
  bool has(const std::string& key) const { return values_.contains(key); }

  const std::string& text(const std::string& key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) throw FileError(file_, key, "a value", "none");
    return found->second;
  }

  bool flag(const std::string& key, bool otherwise) const {
    if (!has(key)) return otherwise;
    const std::string value = lower_case(text(key));
    if (value == "true" || value == "t" || value == "1") return true;
    if (value == "false" || value == "f" || value == "0") return false;
    throw FileError(file_, key, "True or False", in_quotes(text(key)));
  }

  template <typename Number>
  std::vector<Number> numbers(const std::string& key) const {
    const std::string& value = text(key);
    std::vector<Number> list;
    for (const std::string_view word : words_of(value)) {
      const auto number = parse_number<Number>(word);
      if (!number) throw FileError(file_, key, "numbers", in_quotes(value));
      list.push_back(*number);
    }
    return list;
  }

  std::int64_t number(const std::string& key, std::int64_t otherwise) const {
    if (!has(key)) return otherwise;
    const auto list = numbers<std::int64_t>(key);
    if (list.size() != 1) throw FileError(file_, key, "one number", in_quotes(text(key)));
    return list[0];
  }

 private:
  std::filesystem::path file_;
  std::map<std::string, std::string> values_;
  std::vector<std::string> list_;
  std::uint64_t end_ = 0;
};

StoredType type_of(const std::filesystem::path& file, const std::string& name) {
  static const std::map<std::string, StoredType> kTypes = {
      {"MET_CHAR", StoredType::kInt8},       {"MET_UCHAR", StoredType::kUint8},
      {"MET_SHORT", StoredType::kInt16},     {"MET_USHORT", StoredType::kUint16},
      {"MET_INT", StoredType::kInt32},       {"MET_UINT", StoredType::kUint32},
      {"MET_LONG", StoredType::kInt32},      {"MET_ULONG", StoredType::kUint32},
      {"MET_LONG_LONG", StoredType::kInt64}, {"MET_ULONG_LONG", StoredType::kUint64},
      {"MET_FLOAT", StoredType::kFloat32},   {"MET_DOUBLE", StoredType::kFloat64}};
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) throw FileError(file, "ElementType", "a MET_ number type", in_quotes(name));
  return found->second;
}

Vec3 spacing_of(const std::filesystem::path& file, const Header& header) {
  const std::string key = header.has("ElementSpacing") ? "ElementSpacing" : "ElementSize";
  if (!header.has(key)) return {1, 1, 1};
  const auto list = header.numbers<double>(key);
  if (list.size() < 3) throw FileError(file, key, "three numbers", in_quotes(header.text(key)));
  return {list[0], list[1], list[2]};
}

// TransformMatrix has the directions of the axes, one after another. MetaImage does not say whether the world is a
// patient; ITK, which defines the format, treats it as one.
void place(const std::filesystem::path& file, const Header& header, StoredLayout& layout) {
  const auto given = [&](std::initializer_list<const char*> keys, std::size_t count) -> std::vector<double> {
    for (const char* const key : keys) {
      if (!header.has(key)) continue;
      auto list = header.numbers<double>(key);
      if (list.size() < count)
        throw FileError(file, key, fmt::format("{} numbers", count), in_quotes(header.text(key)));
      return list;
    }
    return {};
  };
  const auto axes = static_cast<std::size_t>(header.number("NDims", 3));
  const auto matrix = given({"TransformMatrix", "Rotation", "Orientation"}, axes * axes);
  const auto origin = given({"Offset", "Position", "Origin"}, 3);
  if (!origin.empty()) layout.placement.origin = {origin[0], origin[1], origin[2]};
  if (matrix.empty()) return;
  for (std::size_t i = 0; i < 3; ++i)
    layout.placement.directions[i] = {matrix[i * axes], matrix[i * axes + 1], matrix[i * axes + 2]};
  const bool unknown = header.has("AnatomicalOrientation") && header.text("AnatomicalOrientation").starts_with('?');
  layout.placement.axes = unknown ? WorldAxes::kWorld : WorldAxes::kPatient;
}

StoredLayout layout_of(const std::filesystem::path& file, const Header& header) {
  StoredLayout layout;
  layout.file = file;
  const auto sizes = header.numbers<std::int64_t>("DimSize");
  if (const auto axes = header.number("NDims", 3); axes != static_cast<std::int64_t>(sizes.size())) {
    throw FileError(file, "DimSize", fmt::format("NDims = {} numbers", axes), in_quotes(header.text("DimSize")));
  }
  layout.dims = checked_dims(file, "DimSize", sizes);
  const auto channels = header.number("ElementNumberOfChannels", 1);
  if (channels < 1 || channels > kMaxParts)
    throw FileError(file, "ElementNumberOfChannels", fmt::format("1..{}", kMaxParts), fmt::format("{}", channels));
  layout.channels = static_cast<int>(channels);
  layout.type = type_of(file, header.text("ElementType"));
  layout.spacing = spacing_of(file, header);
  place(file, header, layout);
  // Both names are used.
  layout.big_endian = header.flag("ElementByteOrderMSB", header.flag("BinaryDataByteOrderMSB", false));
  return layout;
}

// HeaderSize: 0, the number of bytes before the data in the data file, or -1 for data at its end. If the header is in
// the same file, the data cannot begin before the header ends.
DataPlace place_of(const std::filesystem::path& file, const Header& header, std::size_t bytes, bool allow_outside) {
  DataPlace place;
  if (header.flag("CompressedData", false)) place.compression = Compression::kGzip;
  const std::string& name = header.text("ElementDataFile");
  const bool local = name == "LOCAL";
  if (name.empty()) throw FileError(file, "ElementDataFile", "LOCAL, LIST or the name of a file", "none");
  if (name.starts_with("LIST") || name.find('%') != std::string::npos) {
    place.series = series_of(file, "ElementDataFile", name, header.list(), allow_outside);
    place.file = place.series.front();
  } else {
    place.file = local ? file : beside(file, "ElementDataFile", name, allow_outside);
  }
  place.warns_of_more = !local;
  const std::uint64_t begin = local ? header.end() : 0;
  const std::int64_t skip = header.number("HeaderSize", 0);
  if (skip == -1 && place.compression == Compression::kNone && place.series.empty()) {
    const std::uint64_t all = file_bytes(place.file);
    place.offset = all >= begin + bytes ? all - bytes : begin;
  } else if (skip == 0 || (skip > 0 && static_cast<std::uint64_t>(skip) >= begin)) {
    place.offset = skip == 0 ? begin : static_cast<std::uint64_t>(skip);
  } else {
    throw FileError(file, "HeaderSize",
                    fmt::format("0, {} or more, or -1 for plain data", std::max<std::uint64_t>(begin, 1)),
                    fmt::format("{}", skip));
  }
  return place;
}

// The key of the file's first line; empty if the line is not "Key = Value".
std::string first_key(const std::filesystem::path& file) {
  const std::string start = file_start(file, 64);
  const std::string_view line = std::string_view(start).substr(0, start.find('\n'));
  const std::string_view key = Header::key_of(line);
  const bool is_text = std::ranges::all_of(key, [](char c) { return c >= ' ' && c <= '~'; });
  return line.find('=') != std::string_view::npos && is_text ? std::string(key) : "";
}

}  // namespace

bool is_meta_image(const std::filesystem::path& file) {
  const std::string key = first_key(file);
  return key == "ObjectType" || key == "NDims";
}

StoredFile find_meta_image(const std::filesystem::path& file, bool allow_outside, const std::string& part) {
  if (first_key(file).empty()) throw FileError(file, "header", "lines \"Key = Value\"", "another beginning");
  const Header header(file);
  if (header.has("ObjectType") && header.text("ObjectType") != "Image") {
    throw FileError(file, "ObjectType", "Image", in_quotes(header.text("ObjectType")));
  }
  StoredLayout layout = layout_of(file, header);
  const std::size_t bytes = checked_bytes(layout);
  DataPlace place = place_of(file, header, bytes, allow_outside);
  const bool binary = header.flag("BinaryData", true);
  const std::int64_t volumes = volumes_in(file, "DimSize", header.numbers<std::int64_t>("DimSize"));
  place.warns_of_more = place.warns_of_more && volumes == 1;
  const bool colours = layout.channels == 3 || layout.channels == 4;
  const bool small = layout.type == StoredType::kUint8 || layout.type == StoredType::kUint16;
  if (layout.channels > 1 && !(colours && small && part.empty())) {
    if (part.empty()) throw FileError(file, "part", fmt::format("a channel, 1..{}", layout.channels), "none");
    layout.channel = static_cast<int>(chosen_part(file, "channel", layout.channels, part));
  } else if (const std::size_t chosen = chosen_part(file, "volume", volumes, part); chosen > 0) {
    if (!binary || !place.series.empty())
      throw FileError(file, "part", "1, as the samples are text or in several files", part);
    place.skip += chosen * std::uint64_t{bytes};
  }
  if (binary) return {layout, place, Encoding::kBytes};
  layout.big_endian = std::endian::native == std::endian::big;
  return {layout, place, Encoding::kNumbers};
}

}  // namespace gicube::scene
