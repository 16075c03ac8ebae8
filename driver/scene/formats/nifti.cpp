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

#include "scene/formats/data_stream.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {
namespace {

static_assert(sizeof(nifti_1_header) == 348 && sizeof(nifti_2_header) == 540);

struct Header {
  nifti_2_header raw{};         // of version 1 too: what counts of it in the fields of version 2
  double data_offset = 0;       // a float in version 1
  std::int64_t min_offset = 0;  // header and the four bytes that announce extensions
  bool swapped = false;
  bool gzipped = false;

  std::string magic() const { return {raw.magic, strnlen(raw.magic, 4)}; }
};

template <typename Raw>
Header from(const Raw& raw, bool swapped) {
  Header header{.data_offset = static_cast<double>(raw.vox_offset), .min_offset = sizeof(Raw) + 4, .swapped = swapped};
  std::ranges::copy(raw.dim, header.raw.dim);
  std::ranges::copy(raw.pixdim, header.raw.pixdim);
  std::copy_n(raw.magic, 4, header.raw.magic);
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
  const bool gzipped = starts_as_gzip(file);
  DataStream stream(file, 0, gzipped);
  std::array<std::byte, sizeof(nifti_2_header)> buffer;
  const std::span<const std::byte> start(buffer.data(), stream.read(buffer));
  auto header = parse<nifti_1_header>(start, nifti_swap_as_nifti1);
  if (!header) header = parse<nifti_2_header>(start, nifti_swap_as_nifti2);
  if (header) header->gzipped = gzipped;
  return header;
}

StoredType type_of(const std::filesystem::path& file, int datatype) {
  switch (datatype) {
    case NIFTI_TYPE_INT8: return StoredType::kInt8;
    case NIFTI_TYPE_UINT8: return StoredType::kUint8;
    case NIFTI_TYPE_INT16: return StoredType::kInt16;
    case NIFTI_TYPE_UINT16: return StoredType::kUint16;
    case NIFTI_TYPE_INT32: return StoredType::kInt32;
    case NIFTI_TYPE_UINT32: return StoredType::kUint32;
    case NIFTI_TYPE_INT64: return StoredType::kInt64;
    case NIFTI_TYPE_UINT64: return StoredType::kUint64;
    case NIFTI_TYPE_FLOAT32: return StoredType::kFloat32;
    case NIFTI_TYPE_FLOAT64: return StoredType::kFloat64;
    default:
      throw FileError(file, "datatype", "a real number type of at most 64 bits",
                      fmt::format("{} ({})", datatype, nifti_datatype_to_string(datatype)));
  }
}

StoredLayout layout_of(const std::filesystem::path& file, const Header& header) {
  const nifti_2_header& raw = header.raw;
  if (header.magic() != "n+1" && header.magic() != "n+2") {
    throw FileError(file, "magic", "\"n+1\" or \"n+2\" (header and data in one file)", '"' + header.magic() + '"');
  }
  if (raw.dim[0] < 3 || raw.dim[0] > 7) throw FileError(file, "dim[0]", "3..7", fmt::format("{}", raw.dim[0]));
  StoredLayout layout;
  layout.file = file;
  layout.dims = checked_dims(file, "dim", {raw.dim + 1, static_cast<std::size_t>(raw.dim[0])});
  layout.type = type_of(file, raw.datatype);
  layout.spacing = {raw.pixdim[1], raw.pixdim[2], raw.pixdim[3]};
  layout.big_endian = header.swapped == (std::endian::native == std::endian::little);
  if (raw.scl_slope == 0 || std::isnan(raw.scl_slope)) return layout;
  if (!std::isfinite(raw.scl_slope) || !std::isfinite(raw.scl_inter)) {
    throw FileError(file, "scl_slope, scl_inter", "finite numbers",
                    fmt::format("{}, {}", raw.scl_slope, raw.scl_inter));
  }
  layout.slope = raw.scl_slope;
  layout.intercept = raw.scl_inter;
  return layout;
}

DataPlace place_of(const std::filesystem::path& file, const Header& header) {
  // A float in NIfTI-1: exact up to 2^24, and a whole number always.
  const double offset = header.data_offset;
  if (!(offset >= static_cast<double>(header.min_offset) && offset < 0x1p53) || offset != std::floor(offset)) {
    throw FileError(file, "vox_offset", fmt::format("a whole number from {} on", header.min_offset),
                    fmt::format("{}", offset));
  }
  DataPlace place;
  place.file = file;
  place.compressed = header.gzipped;
  place.skip = static_cast<std::uint64_t>(offset);
  return place;
}

}  // namespace

bool is_nifti(const std::filesystem::path& file) {
  const auto header = read_header(file);
  return header && (header->magic().starts_with("n+") || header->magic().starts_with("ni"));
}

StoredFile find_nifti(const std::filesystem::path& file) {
  const auto header = read_header(file);
  if (!header)
    throw FileError(file, "sizeof_hdr", "a NIfTI header (348 or 540)", "another beginning, or a shorter file");
  return {layout_of(file, *header), place_of(file, *header), Encoding::kBytes};
}

}  // namespace gicube::scene
