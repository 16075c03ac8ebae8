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

// The versions that teem supports.
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
  std::vector<std::filesystem::path> series;  // in place of data_file
  std::uint64_t data_offset = 0;
};

// The value of a line "field: value". A line "field:=value" is a comment for readers.
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

// Refuses headers that teem misreads: it takes a line of one character for the header's end, and leaks memory in the
// other cases.
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

// teem's messages, the innermost last, without the surrounding ones that are always the same.
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

// Whether teem would take the line for "key:=value". These lines are omitted: teem searches all previous ones for each.
bool is_key_value(std::string_view line) {
  const std::size_t colon = line.find(": ");
  const bool field = colon != std::string_view::npos &&
                     airEnumVal(nrrdField, std::string(line.substr(0, colon)).c_str()) != nrrdField_unknown;
  return !field && line.find(":=") != std::string_view::npos;
}

// Finds the beginning of the data and, in `text`, the header for teem without the data file's name: teem would open the
// file and use the name of a numbered series as a printf format.
void split_header(const std::filesystem::path& file, bool allow_outside, Header& header, std::string& text) {
  const HeaderLines lines = read_header_lines(file, [](std::string_view line) { return line.empty(); });
  const auto names_list = [](const std::string& line) {
    const auto name = data_file_of(line);
    return name && name->starts_with("LIST");
  };
  // After LIST, names follow up to the file's end.
  const auto list = std::ranges::find_if(lines.lines, names_list);
  const std::vector<std::string> fields(lines.lines.begin(), list == lines.lines.end() ? list : list + 1);
  check_begin_and_fields(file, fields);
  header.data_file = file;
  header.data_offset = lines.end;
  for (const std::string& line : fields) {
    const auto name = data_file_of(line);
    if (!name) {
      if (!line.starts_with('#') && !is_key_value(line)) text += line + '\n';
      continue;
    }
    if (name->empty() || name->starts_with("SKIPLIST")) {
      throw FileError(file, "data file", "the name of one file, LIST or a numbered name", in_quotes(*name));
    }
    header.data_offset = 0;
    if (name->find('%') != std::string::npos || names_list(line)) {
      header.series = series_of(file, "data file", *name, std::span(lines.lines).subspan(fields.size()), allow_outside);
      header.data_file = header.series.front();
    } else {
      header.data_file = beside(file, "data file", *name, allow_outside);
    }
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

// The axes of space and, if there is one more, the other axis, with `count` samples.
struct Axes {
  std::array<unsigned, 3> space{};
  std::optional<unsigned> other;
  std::size_t count = 1;
};

// Whether an axis is not one of space: by its kind or, if other axes have directions, because it has none.
bool is_other(const Nrrd& nrrd, unsigned axis) {
  const int kind = nrrd.axis[axis].kind;
  if (kind == nrrdKindTime) return true;
  if (kind != nrrdKindUnknown) return nrrdKindIsDomain(kind) == 0;
  return nrrd.spaceDim > 0 && !AIR_EXISTS(nrrd.axis[axis].spaceDirection[0]);
}

// Axes of space with one sample are removed, the last first, until three remain. At most one other axis may have more
// than one sample.
Axes axes_of(const std::filesystem::path& file, const Nrrd& nrrd) {
  std::vector<unsigned> space;
  Axes axes;
  const auto take_other = [&](unsigned axis) {
    if (nrrd.axis[axis].size == 1) return;
    if (axes.other)
      throw FileError(file, "sizes", "one axis beside those of space",
                      fmt::format("axes {} and {}", *axes.other, axis));
    axes.other = axis;
    axes.count = nrrd.axis[axis].size;
  };
  for (unsigned i = 0; i < nrrd.dim; ++i) {
    if (is_other(nrrd, i)) {
      take_other(i);
    } else {
      space.push_back(i);
    }
  }
  for (std::size_t i = space.size(); i-- > 0 && space.size() > 3;) {
    if (nrrd.axis[space[i]].size == 1) space.erase(space.begin() + static_cast<std::ptrdiff_t>(i));
  }
  // Without a kind, the slowest of four axes is a time.
  if (space.size() == 4 && !axes.other) {
    take_other(space.back());
    space.pop_back();
  }
  if (space.size() != 3) {
    std::string sizes;
    for (unsigned i = 0; i < nrrd.dim; ++i)
      sizes +=
          fmt::format("{}{}{}", i > 0 ? " x " : "", nrrd.axis[i].size, is_other(nrrd, i) ? " (none of space)" : "");
    throw FileError(file, "sizes", "three axes of space", sizes);
  }
  std::ranges::copy(space, axes.space.begin());
  return axes;
}

// Converts a vector from the header's space to the world's.
Vec3 in_world(const Nrrd& nrrd, const double* v) {
  switch (nrrd.space) {
    case nrrdSpaceRightAnteriorSuperior:
    case nrrdSpaceRightAnteriorSuperiorTime: return {-v[0], -v[1], v[2]};
    case nrrdSpaceLeftAnteriorSuperior:
    case nrrdSpaceLeftAnteriorSuperiorTime: return {v[0], -v[1], v[2]};
    case nrrdSpace3DLeftHanded:
    case nrrdSpace3DLeftHandedTime: return {v[0], v[1], -v[2]};  // mirrored, so that the result is right-handed
    default: return {v[0], v[1], v[2]};
  }
}

void place(const Header& header, const Axes& axes, StoredLayout& layout) {
  const Nrrd& nrrd = *header.nrrd;
  if (header.io->seen[nrrdField_space_directions] == 0 || nrrd.spaceDim < 3) return;
  for (std::size_t i = 0; i < 3; ++i)
    layout.placement.directions[i] = in_world(nrrd, nrrd.axis[axes.space[i]].spaceDirection);
  if (AIR_EXISTS(nrrd.spaceOrigin[0])) layout.placement.origin = in_world(nrrd, nrrd.spaceOrigin);
  const bool patient = nrrd.space >= nrrdSpaceRightAnteriorSuperior && nrrd.space <= nrrdSpaceLeftPosteriorSuperior;
  const bool with_time =
      nrrd.space >= nrrdSpaceRightAnteriorSuperiorTime && nrrd.space <= nrrdSpaceLeftPosteriorSuperiorTime;
  layout.placement.axes = patient || with_time ? WorldAxes::kPatient : WorldAxes::kWorld;
}

// NaN if the header has spacings of other axes only.
double spacing_of(const Header& header, unsigned axis) {
  const int* seen = header.io->seen;
  if (seen[nrrdField_spacings] == 0 && seen[nrrdField_space_directions] == 0) return 1;
  double spacing = AIR_NAN;
  double direction[NRRD_SPACE_DIM_MAX];
  nrrdSpacingCalculate(header.nrrd.get(), axis, &spacing, direction);
  return spacing;
}

StoredLayout layout_of(const std::filesystem::path& file, const Header& header, const Axes& axes) {
  const Nrrd& nrrd = *header.nrrd;
  std::vector<std::int64_t> sizes;
  for (const unsigned axis : axes.space) {
    constexpr std::size_t kMax = std::numeric_limits<std::int64_t>::max();
    sizes.push_back(static_cast<std::int64_t>(std::min(nrrd.axis[axis].size, kMax)));
  }
  StoredLayout layout;
  layout.file = file;
  layout.dims = checked_dims(file, "sizes", sizes);
  layout.type = type_of(file, nrrd.type);
  const auto& space = axes.space;
  layout.spacing = {spacing_of(header, space[0]), spacing_of(header, space[1]), spacing_of(header, space[2])};
  layout.big_endian = header.io->endian == airEndianBig;
  place(header, axes, layout);
  return layout;
}

// The byte after `lines` line ends from `offset` on.
std::uint64_t skip_lines(const std::filesystem::path& file, std::uint64_t offset, unsigned lines) {
  DataStream stream(file, offset, Compression::kNone);
  std::vector<std::byte> chunk(65536);
  while (lines > 0) {
    const std::size_t came = stream.read(chunk);
    if (came == 0) throw FileError(file, "line skip", "that many lines", fmt::format("{} fewer", lines));
    for (std::size_t i = 0; i < came && lines > 0; ++i, ++offset) lines -= chunk[i] == std::byte{'\n'} ? 1 : 0;
  }
  return offset;
}

// "byte skip" counts bytes before the samples in the file, or in the decompressed stream.
DataPlace place_of(const std::filesystem::path& file, const Header& header, Compression compression,
                   std::size_t bytes) {
  DataPlace place;
  place.file = header.data_file;
  place.compression = compression;
  place.series = header.series;
  place.warns_of_more = header.data_file != file;
  place.offset = skip_lines(header.data_file, header.data_offset, header.io->lineSkip);
  const long skip = header.io->byteSkip;
  if (skip >= 0) {
    place.skip = static_cast<std::uint64_t>(skip);
    return place;
  }
  const bool at_end = skip == -1 && compression == Compression::kNone && header.series.empty();
  if (!at_end) throw FileError(file, "byte skip", "0 or more, or -1 for raw data", fmt::format("{}", skip));
  const std::uint64_t all = file_bytes(header.data_file);
  if (all >= place.offset + bytes) place.offset = all - bytes;
  return place;
}

// Interprets the other axis: colours, or a list of volumes of which one is chosen. `volumes`: the number of volumes of
// the layout's size before the chosen one.
void choose(const std::filesystem::path& file, const Nrrd& nrrd, const Axes& axes, const std::string& part,
            StoredLayout& layout, std::size_t& volumes) {
  if (!axes.other) {
    chosen_part(file, "volume", 1, part);
    return;
  }
  const int kind = nrrd.axis[*axes.other].kind;
  const bool first = *axes.other<axes.space[0], last = *axes.other> axes.space[2];
  if (!first && !last)
    throw FileError(file, "sizes", "an axis beside those of space before or behind them", "one between");
  const bool bytes = layout.type == StoredType::kUint8 || layout.type == StoredType::kUint16;
  const bool colours =
      kind == nrrdKindRGBColor || kind == nrrdKindRGBAColor || kind == nrrdKind3Color || kind == nrrdKind4Color;
  if (colours && first && bytes && part.empty()) {
    layout.channels = static_cast<int>(std::min<std::size_t>(axes.count, 5));  // more than four are refused later
    return;
  }
  const bool series = kind == nrrdKindUnknown || kind == nrrdKindList || kind == nrrdKindTime;
  const std::string what = kind == nrrdKindUnknown ? "volume" : airEnumStr(nrrdKind, kind);
  if (part.empty() && !series)
    throw FileError(file, "part", fmt::format("a number, 1..{}, as there are axes of kind {}", axes.count, what),
                    "none");
  const std::size_t chosen =
      chosen_part(file, what, static_cast<std::int64_t>(std::min<std::size_t>(axes.count, kMaxParts + 1)), part);
  if (last) {
    volumes = chosen;
    return;
  }
  layout.channels = static_cast<int>(axes.count);
  layout.channel = static_cast<int>(chosen);
}

StoredFile stored_file(const std::filesystem::path& file, const Header& header, StoredLayout layout,
                       std::size_t volumes, bool several) {
  const std::size_t bytes = checked_bytes(layout);
  const NrrdEncoding* encoding = header.io->encoding;
  const auto compression = encoding == nrrdEncodingRaw     ? std::optional(Compression::kNone)
                           : encoding == nrrdEncodingGzip  ? std::optional(Compression::kGzip)
                           : encoding == nrrdEncodingBzip2 ? std::optional(Compression::kBzip2)
                                                           : std::nullopt;
  DataPlace place = place_of(file, header, compression.value_or(Compression::kNone), bytes);
  if (volumes > 0 && (!compression || !header.series.empty()))
    throw FileError(file, "part", "1, as the samples are text or in several files", fmt::format("{}", volumes + 1));
  place.skip += volumes * std::uint64_t{bytes};
  place.warns_of_more = place.warns_of_more && !several;
  if (compression) return {layout, place, Encoding::kBytes};
  if (encoding == nrrdEncodingHex) return {layout, place, Encoding::kHex};
  if (encoding != nrrdEncodingAscii || !header.series.empty()) {
    throw FileError(file, "encoding", "raw, gzip, bzip2, ascii or hex (the last two in one file)", encoding->name);
  }
  layout.big_endian = std::endian::native == std::endian::big;
  return {layout, place, Encoding::kNumbers};
}

}  // namespace

bool is_nrrd(const std::filesystem::path& file) { return file_start(file, 7) == "NRRD000"; }

StoredFile find_nrrd(const std::filesystem::path& file, bool allow_outside, const std::string& part) {
  const Header header = read_header(file, allow_outside);
  const Axes axes = axes_of(file, *header.nrrd);
  StoredLayout layout = layout_of(file, header, axes);
  std::size_t volumes = 0;
  choose(file, *header.nrrd, axes, part, layout, volumes);
  return stored_file(file, header, layout, volumes, axes.other.has_value());
}

Volume read_nrrd_channels(const std::filesystem::path& file, int& channels) {
  const Header header = read_header(file, false);
  const Nrrd& nrrd = *header.nrrd;
  const bool vectors = nrrd.dim == 4 && nrrd.axis[0].size == 3;
  channels = vectors ? 3 : 1;
  const Axes axes = vectors ? Axes{{1, 2, 3}, 0, 3} : axes_of(file, nrrd);
  if (axes.other && !vectors)
    throw FileError(file, "sizes", "three axes, or a first one of 3 before them",
                    fmt::format("axis {} of {}", *axes.other, axes.count));
  StoredLayout layout = layout_of(file, header, axes);
  if (vectors && layout.dims[0] > kMaxFileDim / 3)
    throw FileError(file, "sizes", fmt::format("at most {} voxels of three", kMaxFileDim / 3),
                    fmt::format("{}", layout.dims[0]));
  layout.dims[0] *= channels;
  return read_stored(stored_file(file, header, layout, 0, false));
}

}  // namespace gicube::scene
