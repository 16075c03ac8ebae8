#include "scene/formats/readers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <string>

#include <fmt/format.h>
#include <nifti2_io.h>

#include "scene/common/checks.h"
#include "scene/formats/data_stream.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {
namespace {

static_assert(sizeof(nifti_1_header) == 348 && sizeof(nifti_2_header) == 540);

struct Header {
  nifti_2_header raw{};         // the fields in use; those of version 1 are converted
  double data_offset = 0;       // a float in version 1
  std::int64_t min_offset = 0;  // bytes of the header and of the extension flag behind it
  bool swapped = false;
  Compression compression = Compression::kNone;

  std::string magic() const { return {raw.magic, strnlen(raw.magic, 4)}; }
};

template <typename Raw>
Header from(const Raw& raw, bool swapped) {
  Header header{.data_offset = static_cast<double>(raw.vox_offset), .min_offset = sizeof(Raw) + 4, .swapped = swapped};
  std::ranges::copy(raw.dim, header.raw.dim);
  std::ranges::copy(raw.pixdim, header.raw.pixdim);
  std::copy_n(raw.magic, 4, header.raw.magic);
  header.raw.qform_code = raw.qform_code;
  header.raw.sform_code = raw.sform_code;
  header.raw.quatern_b = static_cast<double>(raw.quatern_b);
  header.raw.quatern_c = static_cast<double>(raw.quatern_c);
  header.raw.quatern_d = static_cast<double>(raw.quatern_d);
  header.raw.qoffset_x = static_cast<double>(raw.qoffset_x);
  header.raw.qoffset_y = static_cast<double>(raw.qoffset_y);
  header.raw.qoffset_z = static_cast<double>(raw.qoffset_z);
  std::ranges::copy(raw.srow_x, header.raw.srow_x);
  std::ranges::copy(raw.srow_y, header.raw.srow_y);
  std::ranges::copy(raw.srow_z, header.raw.srow_z);
  header.raw.datatype = raw.datatype;
  header.raw.scl_slope = static_cast<double>(raw.scl_slope);
  header.raw.scl_inter = static_cast<double>(raw.scl_inter);
  return header;
}

template <typename Raw>
std::optional<Header> parse(std::span<const std::byte> start, void (*swap)(Raw*)) {
  Raw raw;
  if (start.size() < sizeof(Raw)) return std::nullopt;
  std::memcpy(&raw, start.data(), sizeof(Raw));
  if (raw.sizeof_hdr == static_cast<int>(sizeof(Raw))) return from(raw, false);
  swap(&raw);
  if (raw.sizeof_hdr == static_cast<int>(sizeof(Raw))) return from(raw, true);
  return std::nullopt;
}

std::optional<Header> read_header(const std::filesystem::path& file) {
  const Compression compression = starts_as_gzip(file) ? Compression::kGzip : Compression::kNone;
  DataStream stream(file, 0, compression);
  std::array<std::byte, sizeof(nifti_2_header)> buffer;
  const std::span<const std::byte> start(buffer.data(), stream.read(buffer));
  auto header = parse<nifti_1_header>(start, nifti_swap_as_nifti1);
  if (!header) header = parse<nifti_2_header>(start, nifti_swap_as_nifti2);
  if (header) header->compression = compression;
  return header;
}

// Whether header and data are in two files: as the magic of NIfTI says; always for Analyze 7.5, which has no magic.
bool is_pair(const Header& header) { return !header.magic().starts_with("n+"); }

// Converts from RAS, the axes of NIfTI, to LPS.
Vec3 from_ras(double x, double y, double z) { return {-x, -y, z}; }

// sform has precedence over qform, as in nibabel. Analyze has neither, and codes of 0 make both invalid.
void place(const std::filesystem::path& file, const nifti_2_header& raw, StoredLayout& layout) {
  layout.spacing = {raw.pixdim[1], raw.pixdim[2], raw.pixdim[3]};
  if (raw.sform_code <= 0 && raw.qform_code <= 0) return;
  nifti_dmat44 to_world{};
  if (raw.sform_code > 0) {
    std::ranges::copy(raw.srow_x, to_world.m[0]);
    std::ranges::copy(raw.srow_y, to_world.m[1]);
    std::ranges::copy(raw.srow_z, to_world.m[2]);
  } else {
    to_world = nifti_quatern_to_dmat44(raw.quatern_b, raw.quatern_c, raw.quatern_d, raw.qoffset_x, raw.qoffset_y,
                                       raw.qoffset_z, 1, 1, 1, raw.pixdim[0] < 0 ? -1 : 1);
  }
  const auto& m = to_world.m;
  for (std::size_t axis = 0; axis < 3; ++axis)
    layout.placement.directions[axis] = from_ras(m[0][axis], m[1][axis], m[2][axis]);
  layout.placement.origin = from_ras(m[0][3], m[1][3], m[2][3]);
  layout.placement.axes = WorldAxes::kPatient;
  if (raw.sform_code <= 0) return;
  const auto edge = [&](std::size_t axis) { return length(layout.placement.directions[axis]); };
  const Vec3 edges{edge(0), edge(1), edge(2)};
  const auto near = [](double a, double b) { return std::abs(std::abs(a) - b) <= 1e-4 * b; };  // chosen: of floats
  if (near(layout.spacing.x, edges.x) && near(layout.spacing.y, edges.y) && near(layout.spacing.z, edges.z)) return;
  warn(file, "pixdim", fmt::format("{:g} {:g} {:g} as in srow", edges.x, edges.y, edges.z),
       fmt::format("{:g} {:g} {:g}; srow is taken", layout.spacing.x, layout.spacing.y, layout.spacing.z));
  layout.spacing = edges;
}

StoredLayout layout_of(const std::filesystem::path& file, const Header& header) {
  const nifti_2_header& raw = header.raw;
  if (raw.dim[0] < 3 || raw.dim[0] > 7) throw FileError(file, "dim[0]", "3..7", fmt::format("{}", raw.dim[0]));
  StoredLayout layout;
  layout.file = file;
  layout.dims = checked_dims(file, "dim", {raw.dim + 1, 3});
  if (raw.datatype == NIFTI_TYPE_RGB24 || raw.datatype == NIFTI_TYPE_RGBA32) {
    layout.channels = raw.datatype == NIFTI_TYPE_RGB24 ? 3 : 4;
  } else {
    const auto type = type_named(lower_case(nifti_datatype_string(raw.datatype)));
    if (!type)
      throw FileError(file, "datatype", "a real number type of at most 64 bits",
                      fmt::format("{} ({})", raw.datatype, nifti_datatype_to_string(raw.datatype)));
    layout.type = *type;
  }
  place(file, raw, layout);
  layout.big_endian = header.swapped == (std::endian::native == std::endian::little);
  const bool is_analyze = header.magic().empty();  // it has funused1 and funused2 in place of slope and intercept
  if (raw.scl_slope == 0 || std::isnan(raw.scl_slope) || layout.channels > 1 || is_analyze) return layout;
  if (!std::isfinite(raw.scl_slope) || !std::isfinite(raw.scl_inter)) {
    throw FileError(file, "scl_slope, scl_inter", "finite numbers",
                    fmt::format("{}, {}", raw.scl_slope, raw.scl_inter));
  }
  layout.slope = raw.scl_slope;
  layout.intercept = raw.scl_inter;
  return layout;
}

DataPlace place_of(const std::filesystem::path& file, const Header& header, const std::filesystem::path& data) {
  // A float in NIfTI-1, exact up to 2^24. It must be whole.
  const double offset = header.data_offset, least = is_pair(header) ? 0 : static_cast<double>(header.min_offset);
  if (!(offset >= least && offset < 0x1p53) || offset != std::floor(offset)) {
    throw FileError(file, "vox_offset", fmt::format("a whole number from {} on", least), fmt::format("{}", offset));
  }
  DataPlace place;
  place.file = data;
  place.compression = data == file           ? header.compression
                      : starts_as_gzip(data) ? Compression::kGzip
                                             : Compression::kNone;
  place.skip = static_cast<std::uint64_t>(offset);
  return place;
}

// The other file of a pair, NAME.hdr and NAME.img, each gzipped or not.
std::filesystem::path partner(const std::filesystem::path& file, const char* extension) {
  std::filesystem::path name = file;
  if (lower_case(name.extension().string()) == ".gz") name.replace_extension();
  for (const char* const end : {"", ".gz"}) {
    std::error_code none;
    std::filesystem::path other = name;
    other.replace_extension(std::string(extension) + end);
    if (std::filesystem::exists(other, none)) return other;
  }
  return name.replace_extension(extension);
}

// An Analyze file has no magic and is recognised by its name.
bool has_pair_name(const std::filesystem::path& file) {
  const std::string name = lower_case(file.filename().string());
  return name.ends_with(".hdr") || name.ends_with(".hdr.gz");
}

}  // namespace

bool is_nifti(const std::filesystem::path& file) {
  const auto header = read_header(file);
  return header && (header->magic().starts_with("n+") || header->magic().starts_with("ni"));
}

StoredFile find_nifti(const std::filesystem::path& named, const std::string& part) {
  const std::string name = lower_case(named.filename().string());
  const bool is_image = name.ends_with(".img") || name.ends_with(".img.gz");
  const std::filesystem::path file = is_image ? partner(named, ".hdr") : named;
  const auto header = read_header(file);
  if (!header)
    throw FileError(file, "sizeof_hdr", "a NIfTI header (348 or 540)", "another beginning, or a shorter file");
  const std::string magic = header->magic();
  const bool pair = is_pair(*header);
  if (magic != "n+1" && magic != "n+2" && magic != "ni1" && magic != "ni2" && !(magic.empty() && has_pair_name(file))) {
    throw FileError(file, "magic", "\"n+1\", \"n+2\", \"ni1\" or \"ni2\"", '"' + magic + '"');
  }
  StoredLayout layout = layout_of(file, *header);
  DataPlace place = place_of(file, *header, pair ? partner(file, ".img") : file);
  const std::span sizes(header->raw.dim + 1, static_cast<std::size_t>(header->raw.dim[0]));
  const std::size_t chosen = chosen_part(file, "volume", volumes_in(file, "dim", sizes), part);
  place.skip += chosen * std::uint64_t{checked_bytes(layout)};
  return {layout, place, Encoding::kBytes};
}

}  // namespace gicube::scene
