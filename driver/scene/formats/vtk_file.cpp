// VTK's image data: .vti, and legacy .vtk of structured points (VTK's file formats, Kitware). VTK's own reader depends
// on 100 MB of libraries; pugixml reads the XML, and zlib decompresses.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <pugixml.hpp>

#include "scene/common/checks.h"
#include "scene/formats/header_lines.h"
#include "scene/formats/readers.h"

namespace gicube::scene {
namespace {

constexpr std::size_t kMaxXmlBytes = std::size_t{1} << 30;  // chosen: inline samples are part of it
constexpr std::string_view kAppended = "<AppendedData";

using Named = std::pair<std::string_view, StoredType>;
constexpr std::array kLegacyTypes = {
    Named{"char", StoredType::kInt8},          Named{"unsigned_char", StoredType::kUint8},
    Named{"short", StoredType::kInt16},        Named{"unsigned_short", StoredType::kUint16},
    Named{"int", StoredType::kInt32},          Named{"unsigned_int", StoredType::kUint32},
    Named{"long", StoredType::kInt64},         Named{"unsigned_long", StoredType::kUint64},
    Named{"vtktypeint64", StoredType::kInt64}, Named{"float", StoredType::kFloat32},
    Named{"double", StoredType::kFloat64}};

StoredType checked(const std::filesystem::path& file, std::optional<StoredType> type, std::string_view name) {
  if (!type) throw FileError(file, "type", "a number type of VTK", in_quotes(name));
  return *type;
}

template <typename Number>
std::vector<Number> numbers(const std::filesystem::path& file, const char* field, std::string_view text,
                            std::size_t count) {
  std::vector<Number> list;
  for (const std::string_view word : words_of(text)) {
    const auto number = parse_number<Number>(word);
    if (number) list.push_back(*number);
  }
  if (list.size() != count)
    throw FileError(file, field, fmt::format("{} numbers", count), in_quotes(text.substr(0, 80)));
  return list;
}

// Decodes base64 up to `count` bytes, or up to the first invalid character.
std::vector<std::byte> from_base64(std::string_view text, std::size_t count) {
  std::vector<std::byte> bytes;
  unsigned bits = 0, held = 0;
  for (const char c : text) {
    if (bytes.size() == count) break;
    const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                      : c == '/'             ? 63
                                             : -1;
    if (kBlank.find(c) != std::string_view::npos) continue;
    if (value < 0) break;
    held = held << 6 | static_cast<unsigned>(value);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<std::byte>(held >> bits & 0xff));
  }
  return bytes;
}

// The text of a file up to the appended samples.
struct Xml {
  pugi::xml_document document;
  std::uint64_t data = 0;  // the byte after the "_"; 0: nothing is appended
  bool is_raw = false;     // otherwise base64
};

void read_xml(const std::filesystem::path& file, Xml& xml) {
  DataStream stream(file, 0, Compression::kNone);
  std::string text;
  std::size_t appended = std::string::npos;
  while (appended == std::string::npos) {
    constexpr std::size_t kChunk = std::size_t{1} << 20;  // chosen
    const std::size_t had = text.size();
    if (had >= kMaxXmlBytes) throw FileError(file, "XML", fmt::format("at most {} bytes", kMaxXmlBytes), "more");
    text.resize(had + kChunk);
    text.resize(had + stream.read(std::as_writable_bytes(std::span(text).subspan(had))));
    appended = text.find(kAppended, had > kAppended.size() ? had - kAppended.size() : 0);
    if (text.size() < had + kChunk) break;
  }
  if (appended != std::string::npos) {
    // The "_" may be in the next chunk.
    std::string more(4096, '\0');
    more.resize(stream.read(std::as_writable_bytes(std::span(more))));
    const std::string tail = text.substr(appended) + more;
    const std::size_t end = tail.find('>'), begin = tail.find('_', end);
    if (end == std::string::npos || begin == std::string::npos)
      throw FileError(file, "AppendedData", "\"_\" before the samples", "none");
    xml.data = appended + begin + 1;
    const std::string_view encoding = std::string_view(tail).substr(0, end);
    xml.is_raw = encoding.find("\"raw\"") != std::string_view::npos;
    if (!xml.is_raw && encoding.find("\"base64\"") == std::string_view::npos)
      throw FileError(file, "AppendedData", "encoding raw or base64", in_quotes(encoding));
    text.resize(appended);
    text += "</VTKFile>";
  }
  if (const auto parsed = xml.document.load_string(text.c_str()); !parsed)
    throw FileError(file, "XML", "a VTKFile", fmt::format("{} at byte {}", parsed.description(), parsed.offset));
}

// Decodes the samples of an array, and reads only the part of the file that they need.
class ArrayReader {
 public:
  ArrayReader(const std::filesystem::path& file, const pugi::xml_node& root, const Xml& xml,
              const pugi::xml_node& array)
      : file_(file),
        word_bytes_(std::string_view(root.attribute("header_type").value()) == "UInt64" ? 8 : 4),
        big_endian_(std::string_view(root.attribute("byte_order").value()) == "BigEndian") {
    const std::string_view format = array.attribute("format").value(),
                           compressor = root.attribute("compressor").value();
    if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
      throw FileError(file, "compressor", "none or vtkZLibDataCompressor", in_quotes(compressor));
    is_packed_ = !compressor.empty();
    if (format == "binary") {
      text_ = array.child_value();
    } else if (format == "appended" && xml.data > 0) {
      const auto offset = parse_number<std::uint64_t>(array.attribute("offset").value());
      const std::uint64_t all = file_bytes(file);
      if (!offset || *offset >= all - xml.data)
        throw FileError(file, "offset", fmt::format("below {}", all - xml.data),
                        in_quotes(array.attribute("offset").value()));
      offset_ = xml.data + *offset;
      is_raw_ = xml.is_raw;
      if (is_raw_) return;
      std::ifstream input(file, std::ios::binary);
      input.seekg(static_cast<std::streamoff>(offset_));
      appended_.resize(std::min<std::uint64_t>(all - offset_, kMaxXmlBytes));
      input.read(appended_.data(), static_cast<std::streamsize>(appended_.size()));
      text_ = std::string_view(appended_).substr(0, appended_.find('<'));
    } else {
      throw FileError(file, "format", "ascii, binary or appended, with AppendedData", in_quotes(format));
    }
    text_ = trimmed(text_);
  }

  std::vector<std::byte> read(std::size_t bytes) const {
    if (!is_packed_) {
      if (number(take(0, word_bytes_), 0) != bytes) throw_size(bytes, number(take(0, word_bytes_), 0));
      std::vector<std::byte> all = is_raw_ ? take(word_bytes_, bytes) : take(0, word_bytes_ + bytes);
      if (!is_raw_) all.erase(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(word_bytes_));
      return all;
    }
    const std::vector<std::byte> start = take(0, 3 * word_bytes_);
    const std::uint64_t blocks = number(start, 0), block = number(start, 1), last = number(start, 2);
    const std::uint64_t whole = blocks - (last > 0 ? 1 : 0);
    if (blocks == 0 || blocks > bytes || block > kMaxVolumeBytes || whole * block + last != bytes)
      throw_size(bytes, whole * block + last);
    const std::size_t header = (3 + blocks) * word_bytes_;
    const std::vector<std::byte> sizes = take(0, header);
    std::uint64_t packed = 0;
    for (std::uint64_t i = 0; i < blocks; ++i) packed += std::min(number(sizes, 3 + i), std::uint64_t{1} << 40);
    // In base64 the header is encoded separately.
    const std::vector<std::byte> data = is_raw_ ? take(header, packed) : take_text((header + 2) / 3 * 4, packed);
    std::vector<std::byte> out;
    out.reserve(bytes);
    std::size_t at = 0;
    for (std::uint64_t i = 0; i < blocks; ++i) {
      const std::uint64_t from = number(sizes, 3 + i), to = i < whole ? block : last;
      const std::size_t had = out.size();
      out.resize(had + to);
      uLongf made = to;
      const int status = from > data.size() - at ? Z_DATA_ERROR
                                                 : uncompress(reinterpret_cast<Bytef*>(out.data() + had), &made,
                                                              reinterpret_cast<const Bytef*>(data.data() + at), from);
      if (status != Z_OK || made != to)
        throw FileError(file_, "compressed data", fmt::format("block {} of {} bytes", i, to), zError(status));
      at += from;
    }
    return out;
  }

 private:
  [[noreturn]] void throw_size(std::size_t bytes, std::uint64_t got) const {
    throw FileError(file_, "data", fmt::format("{} bytes", bytes), fmt::format("{}", got));
  }
  std::vector<std::byte> take_text(std::size_t begin, std::size_t bytes) const {
    auto out = from_base64(text_.substr(std::min(begin, text_.size())), bytes);
    if (out.size() < bytes)
      throw FileError(file_, "data", fmt::format("{} bytes of base64", bytes),
                      fmt::format("{} (truncated)", out.size()));
    return out;
  }
  // `begin`: from the array's first byte; 0 for base64.
  std::vector<std::byte> take(std::size_t begin, std::size_t bytes) const {
    if (!is_raw_) return take_text(begin, bytes);
    DataPlace place;
    place.file = file_;
    place.offset = offset_ + begin;
    return read_data(place, bytes);
  }
  std::uint64_t number(std::span<const std::byte> bytes, std::size_t index) const {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < word_bytes_; ++i) {
      const std::byte byte = bytes[index * word_bytes_ + (big_endian_ ? i : word_bytes_ - 1 - i)];
      value = value << 8 | std::to_integer<std::uint64_t>(byte);
    }
    return value;
  }

  std::filesystem::path file_;
  std::size_t word_bytes_;
  bool big_endian_, is_packed_ = false, is_raw_ = false;
  std::uint64_t offset_ = 0;
  std::string appended_;
  std::string_view text_;
};

std::vector<std::byte> ascii_samples(const std::filesystem::path& file, const char* text, StoredType type,
                                     std::size_t count) {
  return with_sample(type, [&](auto sample) {
    std::vector<std::byte> out;
    for (const std::string_view word : words_of(text)) {
      const auto number = parse_number<decltype(sample)>(word);
      if (!number) throw FileError(file, "data", "numbers that the type can hold", in_quotes(word.substr(0, 40)));
      const auto* const bytes = reinterpret_cast<const std::byte*>(&*number);
      out.insert(out.end(), bytes, bytes + sizeof sample);
    }
    if (out.size() != count * sizeof sample)
      throw FileError(file, "data", fmt::format("{} numbers", count), fmt::format("{}", out.size() / sizeof sample));
    return out;
  });
}

// The array that `part` names, or the active scalars, or the first.
pugi::xml_node choose(const std::filesystem::path& file, const pugi::xml_node& data, const std::string& part) {
  const std::string wanted = part.empty() ? data.attribute("Scalars").value() : part;
  std::string names;
  for (const pugi::xml_node& array : data.children("DataArray")) {
    const std::string_view name = array.attribute("Name").value();
    if (name == wanted) return array;
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  const pugi::xml_node first = data.child("DataArray");
  if (!part.empty() || !first)
    throw FileError(file, "part", names.empty() ? "an array" : "one of " + names,
                    part.empty() ? "none" : in_quotes(part));
  return first;
}

}  // namespace

bool is_vti(const std::filesystem::path& file) {
  const std::string start = file_start(file, 512);
  return start.find("<VTKFile") != std::string::npos && start.find("ImageData") != std::string::npos;
}

Volume read_vti(const std::filesystem::path& file, const std::string& part) {
  Xml xml;
  read_xml(file, xml);
  const pugi::xml_node root = xml.document.child("VTKFile"), image = root.child("ImageData"),
                       piece = image.child("Piece");
  if (!image || !piece) throw FileError(file, "VTKFile", "ImageData with a Piece", root.attribute("type").value());
  const std::string_view whole = image.attribute("WholeExtent").value();
  if (piece.next_sibling("Piece") || std::string_view(piece.attribute("Extent").value()) != whole)
    throw FileError(file, "Piece", fmt::format("one, of the WholeExtent \"{}\"", whole), "others");
  const auto extent = numbers<std::int64_t>(file, "WholeExtent", whole, 6);
  const bool cells = !piece.child("PointData").child("DataArray");
  const pugi::xml_node array = choose(file, piece.child(cells ? "CellData" : "PointData"), part);
  std::array<std::int64_t, 3> sizes{};
  for (std::size_t i = 0; i < 3; ++i)
    sizes[i] = std::clamp<std::int64_t>(extent[2 * i + 1], -kMaxParts, kMaxParts) -
               std::clamp<std::int64_t>(extent[2 * i], -kMaxParts, kMaxParts) + (cells ? 0 : 1);
  StoredLayout layout;
  layout.file = file;
  layout.dims = checked_dims(file, "WholeExtent", sizes);
  const std::string_view type = array.attribute("type").value();
  layout.type = checked(file, type_named(lower_case(type)), type);
  layout.channels = array.attribute("NumberOfComponents").as_int(1);
  if (layout.channels != 1 && !((layout.channels == 3 || layout.channels == 4) && layout.type == StoredType::kUint8))
    throw FileError(file, "NumberOfComponents", "1, or 3 or 4 of UInt8", array.attribute("NumberOfComponents").value());
  const auto given = [&](const char* name, const char* otherwise, std::size_t count) {
    const pugi::xml_attribute attribute = image.attribute(name);
    return numbers<double>(file, name, attribute ? attribute.value() : otherwise, count);
  };
  const auto spacing = given("Spacing", "1 1 1", 3), origin = given("Origin", "0 0 0", 3);
  const auto d = given("Direction", "1 0 0 0 1 0 0 0 1", 9);
  layout.spacing = {spacing[0], spacing[1], spacing[2]};
  layout.placement.axes = WorldAxes::kWorld;
  layout.placement.origin = {origin[0], origin[1], origin[2]};
  for (std::size_t i = 0; i < 3; ++i) {
    layout.placement.directions[i] = {d[i], d[3 + i], d[6 + i]};
    const double steps = static_cast<double>(extent[2 * i]) + (cells ? 0.5 : 0);
    layout.placement.origin = layout.placement.origin + steps * spacing[i] * layout.placement.directions[i];
  }
  const std::size_t bytes = checked_bytes(layout);
  if (std::string_view(array.attribute("format").value()) == "ascii") {
    layout.big_endian = std::endian::native == std::endian::big;
    return to_volume(ascii_samples(file, array.child_value(), layout.type, bytes / bytes_of(layout.type)), layout);
  }
  layout.big_endian = std::string_view(root.attribute("byte_order").value()) == "BigEndian";
  return to_volume(ArrayReader(file, root, xml, array).read(bytes), layout);
}

bool is_legacy_vtk(const std::filesystem::path& file) { return file_start(file, 14) == "# vtk DataFile"; }

StoredFile find_legacy_vtk(const std::filesystem::path& file) {
  if (!is_legacy_vtk(file)) throw FileError(file, "header", "\"# vtk DataFile\"", "another beginning");
  bool in_field = false;
  const HeaderLines header = read_header_lines(file, [&in_field](std::string_view line) {
    if (in_field) return true;
    in_field = line.starts_with("FIELD");
    return line.starts_with("LOOKUP_TABLE");
  });
  StoredFile found;
  found.layout.file = file;
  found.layout.big_endian = true;
  found.layout.placement.axes = WorldAxes::kWorld;
  found.place.file = file;
  found.place.offset = header.end;
  bool is_points = false, cells = false, sized = false, typed = false;
  std::vector<std::int64_t> sizes;
  for (std::size_t i = 2; i < header.lines.size(); ++i) {
    const std::string_view line = header.lines[i];
    const auto words = words_of(line);
    if (words.empty()) continue;
    const std::string_view key = words[0], rest = line.substr(line.find(key) + key.size());
    const auto vector = [&] {
      const auto list = numbers<double>(file, std::string(key).c_str(), rest, 3);
      return Vec3{list[0], list[1], list[2]};
    };
    if (key == "ASCII")
      found.encoding = Encoding::kNumbers, found.layout.big_endian = std::endian::native == std::endian::big;
    if (key == "DATASET") is_points = words.size() > 1 && words[1] == "STRUCTURED_POINTS";
    if (key == "DIMENSIONS") sizes = numbers<std::int64_t>(file, "DIMENSIONS", rest, 3), sized = true;
    if (key == "SPACING" || key == "ASPECT_RATIO") found.layout.spacing = vector();
    if (key == "ORIGIN") found.layout.placement.origin = vector();
    if (key == "CELL_DATA") cells = true;
    const bool in_array =
        i + 1 == header.lines.size() && !typed && words.size() == 4;  // name, components, tuples, type
    if ((key == "SCALARS" && words.size() >= 3) || in_array) {
      const std::string_view name = key == "SCALARS" ? words[2] : words[3];
      const auto* const type = std::ranges::find(kLegacyTypes, name, &Named::first);
      found.layout.type = checked(file, type != kLegacyTypes.end() ? std::optional(type->second) : std::nullopt, name);
      const std::string_view count = in_array ? words[1] : words.size() > 3 ? words[3] : "1";
      if (count != "1") throw FileError(file, "SCALARS", "one component", in_quotes(count));
      typed = true;
    }
  }
  if (!is_points || !sized || !typed || !header.complete)
    throw FileError(file, "header", "STRUCTURED_POINTS with DIMENSIONS and SCALARS",
                    !is_points ? "another DATASET" : "none");
  if (cells) {
    for (std::int64_t& size : sizes) size -= 1;
    found.layout.placement.origin = found.layout.placement.origin + 0.5 * found.layout.spacing;
  }
  found.layout.dims = checked_dims(file, "DIMENSIONS", sizes);
  return found;
}

}  // namespace gicube::scene
