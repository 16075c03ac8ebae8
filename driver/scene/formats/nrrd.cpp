#include "scene/formats/readers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <limits>
#include <memory>
#include <optional>
#include <ranges>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <teem/nrrd.h>

#include "scene/common/checks.h"
#include "scene/formats/data_stream.h"
#include "scene/formats/header_lines.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {
namespace {

// The versions that teem knows.
constexpr std::array<std::string_view, 6> kMagics = {"NRRD0001", "NRRD0002", "NRRD0003",
                                                     "NRRD0004", "NRRD0005", "NRRD0006"};

struct NrrdDelete {
  void operator()(Nrrd* nrrd) const { nrrdNuke(nrrd); }
  void operator()(NrrdIoState* state) const { nrrdIoStateNix(state); }
};

struct Header {
  std::unique_ptr<Nrrd, NrrdDelete> nrrd{nrrdNew()};
  std::unique_ptr<NrrdIoState, NrrdDelete> io{nrrdIoStateNew()};
  std::filesystem::path data_file;
  std::uint64_t data_offset = 0;
};

// The value of a line "field: value"; "field:=value" is a note that means nothing to readers.
std::optional<std::string> value_of(std::string_view line, std::string_view field) {
  const std::string start = std::string(field) + ':';
  if (lower_case(line.substr(0, start.size())) != start) return std::nullopt;
  if (line.substr(start.size()).starts_with('=')) return std::nullopt;
  return std::string(trimmed(line.substr(start.size())));
}

std::optional<std::string> data_file_of(std::string_view line) {
  const auto name = value_of(line, "data file");
  return name ? name : value_of(line, "datafile");
}

// teem takes a line of one character for the header's end, and leaks memory where this function throws.
void check_begin_and_fields(const std::filesystem::path& file, const std::vector<std::string>& lines) {
  const std::string magic = lines.empty() ? "" : lines.front().substr(0, 40);
  if (std::ranges::find(kMagics, magic) == kMagics.end()) {
    throw FileError(file, "magic", fmt::format("{}", fmt::join(kMagics, ", ")), '"' + magic + '"');
  }
  for (const std::string& line : lines) {
    if (line.find_first_of(std::string_view("\0\r", 2)) != std::string::npos) {
      throw FileError(file, "header", "lines of text", "a zero byte or a lone carriage return");
    }
    if (line.size() == 1 && line != "#") throw FileError(file, "header", "lines \"field: value\"", '"' + line + '"');
  }
  for (const char* field : {"type", "dimension", "sizes", "encoding"}) {
    if (std::ranges::none_of(lines, [&](const std::string& line) { return value_of(line, field).has_value(); })) {
      throw FileError(file, field, "a line of the header", "none");
    }
  }
}

// teem's messages, innermost last, without the frame that is the same for all.
std::string teem_error() {
  const std::unique_ptr<char, decltype(&std::free)> all(biffGetDone(NRRD), &std::free);
  std::string text;
  for (const auto part : std::views::split(std::string_view(all ? all.get() : ""), '\n')) {
    const std::string_view line = trimmed({part.begin(), part.end()});
    const std::size_t message = line.find(": ");
    if (message == std::string_view::npos || line.find("nrrdRead:") != std::string_view::npos) continue;
    if (line.ends_with("trouble reading NRRD file") || line.ends_with(": trouble")) continue;
    text += (text.empty() ? "" : ": ") + std::string(line.substr(message + 2));
  }
  return text.empty() ? "a header that teem refuses" : text;
}

// "key:=value", as teem tells it from a field. Nothing here needs one, and teem looks at all before it takes another.
bool is_key_value(std::string_view line) {
  const std::size_t colon = line.find(": ");
  const bool field = colon != std::string_view::npos &&
                     airEnumVal(nrrdField, std::string(line.substr(0, colon)).c_str()) != nrrdField_unknown;
  return !field && line.find(":=") != std::string_view::npos;
}

// Where the data begin and, in `text`, the header for teem. The data file's name is kept from teem, which would open it
// and, for a numbered series, take the name as a printf format.
void split_header(const std::filesystem::path& file, bool allow_outside, Header& header, std::string& text) {
  const HeaderLines lines = read_header_lines(file, [](std::string_view line) { return line.empty(); });
  check_begin_and_fields(file, lines.lines);
  header.data_file = file;
  header.data_offset = lines.end;
  for (const std::string& line : lines.lines) {
    const auto name = data_file_of(line);
    if (!name) {
      if (!line.starts_with('#') && !is_key_value(line)) text += line + '\n';
      continue;
    }
    if (name->empty() || name->find('%') != std::string::npos || *name == "LIST" || name->starts_with("LIST ") ||
        name->starts_with("SKIPLIST")) {
      throw FileError(file, "data file", "the name of one file", '"' + *name + '"');
    }
    header.data_file = beside(file, "data file", *name, allow_outside);
    header.data_offset = 0;
  }
}

Header read_header(const std::filesystem::path& file, bool allow_outside) {
  Header header;
  std::string text;
  split_header(file, allow_outside, header, text);
  header.io->skipData = AIR_TRUE;
  const DecimalPoint point;
  if (nrrdStringRead(header.nrrd.get(), text.c_str(), header.io.get()) != 0) {
    throw FileError(file, "header", "a valid NRRD header", teem_error());
  }
  return header;
}

StoredType type_of(const std::filesystem::path& file, int type) {
  switch (type) {
    case nrrdTypeChar: return StoredType::kInt8;
    case nrrdTypeUChar: return StoredType::kUint8;
    case nrrdTypeShort: return StoredType::kInt16;
    case nrrdTypeUShort: return StoredType::kUint16;
    case nrrdTypeInt: return StoredType::kInt32;
    case nrrdTypeUInt: return StoredType::kUint32;
    case nrrdTypeLLong: return StoredType::kInt64;
    case nrrdTypeULLong: return StoredType::kUint64;
    case nrrdTypeFloat: return StoredType::kFloat32;
    case nrrdTypeDouble: return StoredType::kFloat64;
    default: throw FileError(file, "type", "a number type", airEnumStr(nrrdType, type));
  }
}

// Axes of one sample go, the last first, until three are left.
std::vector<unsigned> spatial_axes(const Nrrd& nrrd) {
  std::vector<unsigned> axes(nrrd.dim);
  for (unsigned i = 0; i < nrrd.dim; ++i) axes[i] = i;
  for (std::size_t i = axes.size(); i-- > 0 && axes.size() > 3;) {
    if (nrrd.axis[axes[i]].size == 1) axes.erase(axes.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return axes;
}

// Not a number where the header says that of others only.
double spacing_of(const Header& header, unsigned axis) {
  const int* seen = header.io->seen;
  if (seen[nrrdField_spacings] == 0 && seen[nrrdField_space_directions] == 0) return 1;
  double spacing = AIR_NAN;
  double direction[NRRD_SPACE_DIM_MAX];
  nrrdSpacingCalculate(header.nrrd.get(), axis, &spacing, direction);
  return spacing;
}

// `channels`: of the first axis, taken into the second.
StoredLayout layout_of(const std::filesystem::path& file, const Header& header, std::size_t channels = 1) {
  const Nrrd& nrrd = *header.nrrd;
  const std::vector<unsigned> axes = channels > 1 ? std::vector<unsigned>{1, 2, 3} : spatial_axes(nrrd);
  std::vector<std::int64_t> sizes;
  for (const unsigned axis : axes) {
    constexpr std::size_t kMax = std::numeric_limits<std::int64_t>::max();
    sizes.push_back(static_cast<std::int64_t>(std::min(nrrd.axis[axis].size, kMax)));
  }
  if (channels > 1 && sizes[0] <= kMaxFileDim) sizes[0] *= static_cast<std::int64_t>(channels);
  StoredLayout layout;
  layout.file = file;
  layout.dims = checked_dims(file, "sizes", sizes);
  layout.type = type_of(file, nrrd.type);
  layout.spacing = {spacing_of(header, axes[0]), spacing_of(header, axes[1]), spacing_of(header, axes[2])};
  layout.big_endian = header.io->endian == airEndianBig;
  return layout;
}

// The byte behind `lines` line ends from `offset` on.
std::uint64_t skip_lines(const std::filesystem::path& file, std::uint64_t offset, unsigned lines) {
  DataStream stream(file, offset, false);
  std::vector<std::byte> chunk(65536);
  while (lines > 0) {
    const std::size_t came = stream.read(chunk);
    if (came == 0) throw FileError(file, "line skip", "that many lines", fmt::format("{} fewer", lines));
    for (std::size_t i = 0; i < came && lines > 0; ++i, ++offset) lines -= chunk[i] == std::byte{'\n'} ? 1 : 0;
  }
  return offset;
}

// Byte skips count before the samples: in the file, or in what a compressed stream holds.
DataPlace place_of(const std::filesystem::path& file, const Header& header, bool compressed, std::size_t bytes) {
  DataPlace place;
  place.file = header.data_file;
  place.compressed = compressed;
  place.warns_of_more = header.data_file != file;
  place.offset = skip_lines(header.data_file, header.data_offset, header.io->lineSkip);
  const long skip = header.io->byteSkip;
  if (skip >= 0) {
    place.skip = static_cast<std::uint64_t>(skip);
    return place;
  }
  const bool at_end = skip == -1 && !compressed;
  if (!at_end) throw FileError(file, "byte skip", "0 or more, or -1 for raw data", fmt::format("{}", skip));
  const std::uint64_t all = file_bytes(header.data_file);
  if (all >= place.offset + bytes) place.offset = all - bytes;
  return place;
}

StoredFile stored_file(const std::filesystem::path& file, const Header& header, StoredLayout layout) {
  const std::size_t bytes = checked_bytes(layout);
  const NrrdEncoding* encoding = header.io->encoding;
  if (encoding == nrrdEncodingRaw || encoding == nrrdEncodingGzip) {
    return {layout, place_of(file, header, encoding == nrrdEncodingGzip, bytes), Encoding::kBytes};
  }
  const DataPlace place = place_of(file, header, false, bytes);
  if (encoding == nrrdEncodingHex) return {layout, place, Encoding::kHex};
  if (encoding != nrrdEncodingAscii) {
    throw FileError(file, "encoding", "raw, gzip, ascii or hex", encoding->name);
  }
  layout.big_endian = std::endian::native == std::endian::big;
  return {layout, place, Encoding::kNumbers};
}

}  // namespace

bool is_nrrd(const std::filesystem::path& file) { return file_start(file, 7) == "NRRD000"; }

StoredFile find_nrrd(const std::filesystem::path& file, bool allow_outside) {
  const Header header = read_header(file, allow_outside);
  return stored_file(file, header, layout_of(file, header));
}

Volume read_nrrd_channels(const std::filesystem::path& file, int& channels) {
  const Header header = read_header(file, false);
  const bool vectors = header.nrrd->dim == 4 && header.nrrd->axis[0].size == 3;
  channels = vectors ? 3 : 1;
  return read_stored(stored_file(file, header, layout_of(file, header, vectors ? 3 : 1)));
}

}  // namespace gicube::scene
