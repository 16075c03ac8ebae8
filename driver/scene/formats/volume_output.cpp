#include "gicube/scene/volume_file.h"

#include <fmt/format.h>
#include <nifti2_io.h>
#include <teem/nrrd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/formats/compressed_nrrd.h"
#include "scene/formats/header_lines.h"

namespace gicube::scene {
namespace {

static_assert(std::endian::native == std::endian::little, "floats are written as they lie in memory");

std::array<double, 3> in_order(Vec3 v) { return {v.x, v.y, v.z}; }

std::string ending_of(const std::filesystem::path& path) {
  const std::string name = lower_case(path.filename().string());
  for (const char* ending : {".nrrd", ".mhd", ".mha", ".nii", ".nii.gz"}) {
    if (name.ends_with(ending)) return ending;
  }
  return {};
}

std::string_view bytes_of(std::span<const float> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

// One gzip stream of both parts.
void write_gzip(WholeFile& file, std::string_view start, std::string_view rest) {
  constexpr int kGzip = MAX_WBITS + 16, kMemory = 8;    // zlib.h: with gzip's header; its default
  constexpr std::size_t kMaxIn = std::size_t{1} << 30;  // zlib counts in 32 bits
  std::vector<char> packed(std::size_t{64} << 10);      // chosen
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<z_stream, decltype(&deflateEnd)> ended(&stream, &deflateEnd);
  const auto step = [&](int flush) {
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    const int status = deflate(&stream, flush);
    file.write(std::string_view(packed.data(), packed.size() - stream.avail_out));
    return status;
  };
  for (std::string_view part : {start, rest}) {
    for (; !part.empty(); part.remove_prefix(std::min(part.size(), kMaxIn))) {
      stream.next_in =
          reinterpret_cast<Bytef*>(const_cast<char*>(part.data()));  // NOLINT(*-const-cast): it is only read
      stream.avail_in = static_cast<uInt>(std::min(part.size(), kMaxIn));
      while (stream.avail_in > 0) step(Z_NO_FLUSH);
    }
  }
  while (step(Z_FINISH) != Z_STREAM_END) {
  }
}

// Where the samples lie; of channels, which come first, nothing is said. Whether teem took it.
bool describe(Nrrd* nrrd, const FloatVolume& volume, unsigned first) {
  const auto edges = in_order(volume.spacing), origin = in_order(volume.origin);
  double directions[4][NRRD_SPACE_DIM_MAX] = {};
  for (double& none : directions[0]) none = first > 0 ? AIR_NAN : 0;
  for (std::size_t axis = 0; axis < 3; ++axis) directions[first + axis][axis] = edges[axis];
  const bool good = nrrdSpaceDimensionSet(nrrd, 3) == 0 && nrrdSpaceOriginSet(nrrd, origin.data()) == 0;
  nrrdAxisInfoSet_nva(nrrd, nrrdAxisInfoSpaceDirection, directions);
  for (unsigned axis = 0; axis < 3; ++axis) nrrd->axis[first + axis].kind = nrrdKindDomain;
  if (first > 0) nrrd->axis[0].kind = nrrdKindRGBColor;
  return good;
}

// The text in front of the samples.
std::string nrrd_header(const FloatVolume& volume, const std::filesystem::path& path, const NrrdEncoding* encoding,
                        const Provenance& provenance) {
  const DecimalPoint point;
  const std::unique_ptr<Nrrd, decltype(&nrrdNix)> nrrd(nrrdNew(), &nrrdNix);  // nix: the values stay ours
  const std::unique_ptr<NrrdIoState, decltype(&nrrdIoStateNix)> io(nrrdIoStateNew(), &nrrdIoStateNix);
  auto* values = const_cast<float*>(volume.values.data());  // NOLINT(*-const-cast): teem only reads it
  const unsigned first = volume.channels > 1 ? 1 : 0;
  std::array<std::size_t, 4> sizes{static_cast<std::size_t>(volume.channels)};
  for (unsigned axis = 0; axis < 3; ++axis) sizes[first + axis] = static_cast<std::size_t>(volume.dims[axis]);
  io->format = nrrdFormatNRRD;
  io->encoding = encoding;
  bool good = nrrdWrap_nva(nrrd.get(), values, nrrdTypeFloat, first + 3, sizes.data()) == 0 &&
              describe(nrrd.get(), volume, first);
  for (const auto& [key, value] : entries(provenance)) {
    good = good && nrrdKeyValueAdd(nrrd.get(), key.c_str(), value.c_str()) == 0;
  }
  char* text = nullptr;
  good = good && nrrdStringWrite(&text, nrrd.get(), io.get()) == 0;
  const std::unique_ptr<char, decltype(&std::free)> header(text, &std::free);
  if (good) return std::string(header.get()) + '\n';
  const std::unique_ptr<char, decltype(&std::free)> fault(biffGetDone(NRRD), &std::free);
  throw FileError(path, "header", "one that teem can write", fault ? fault.get() : "an error");
}

void write_nrrd(const FloatVolume& volume, const std::filesystem::path& path, const NrrdEncoding* encoding,
                const Provenance& provenance) {
  const std::string header = nrrd_header(volume, path, encoding, provenance);
  write_whole(path, [&](WholeFile& file) {
    file.write(header);
    if (encoding == nrrdEncodingGzip) return write_gzip(file, {}, bytes_of(volume.values));
    file.write(volume.values);
  });
}

// MetaImage; its samples in the same file, or in another.
void write_meta_image(const FloatVolume& volume, const std::filesystem::path& path, bool apart) {
  const auto [x, y, z] = volume.dims;
  const auto data = std::filesystem::path(path).replace_extension(".raw");
  const std::string header = fmt::format(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = {}\nElementSpacing = {}\nDimSize = {} {} {}\n"
      "ElementType = MET_FLOAT\nElementDataFile = {}\n",
      fmt::join(in_order(volume.origin), " "), fmt::join(in_order(volume.spacing), " "), x, y, z,
      apart ? data.filename().string() : "LOCAL");
  WholeFiles files;
  if (apart) files.write(data, bytes_of(volume.values));
  files.write(path, [&](WholeFile& file) {
    file.write(header);
    if (!apart) file.write(volume.values);
  });
  files.commit();
}

// One extension of lines "key=value".
void add_comment(nifti_image* image, const Provenance& provenance) {
  std::string text;
  for (const auto& [key, value] : entries(provenance)) text += key + '=' + value + '\n';
  if (!text.empty()) {
    nifti_add_extension(image, text.c_str(), static_cast<int>(text.size()) + 1, NIFTI_ECODE_COMMENT);
  }
}

// NIfTI-1 in one file, of which libnifti makes the header; it does not check its writes. Its axes are the scanner's: sform and qform say the same, since some programs read one and some the other.
void write_nifti(const FloatVolume& volume, const std::filesystem::path& path, bool packed,
                 const Provenance& provenance) {
  const std::int64_t dims[8] = {3, volume.dims[0], volume.dims[1], volume.dims[2], 1, 1, 1, 1};
  const std::unique_ptr<nifti_image, decltype(&nifti_image_free)> image(nifti_make_new_nim(dims, NIFTI_TYPE_FLOAT32, 0),
                                                                        &nifti_image_free);
  if (!image) throw std::bad_alloc();
  const auto edges = in_order(volume.spacing), origin = in_order(volume.origin);
  image->dx = image->pixdim[1] = edges[0];
  image->dy = image->pixdim[2] = edges[1];
  image->dz = image->pixdim[3] = edges[2];
  image->xyz_units = NIFTI_UNITS_MM;
  image->sform_code = image->qform_code = NIFTI_XFORM_SCANNER_ANAT;
  image->qfac = 1;  // with a quaternion of 0: no rotation
  image->qoffset_x = origin[0];
  image->qoffset_y = origin[1];
  image->qoffset_z = origin[2];
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) image->sto_xyz.m[row][column] = row == column ? edges[row] : 0;
    image->sto_xyz.m[row][3] = origin[row];
  }
  image->sto_xyz.m[3][3] = 1;
  add_comment(image.get(), provenance);
  image->nifti_type = NIFTI_FTYPE_NIFTI1_1;
  nifti_set_iname_offset(image.get(), 1);
  nifti_1_header header{};
  if (nifti_convert_nim2n1hdr(image.get(), &header) != 0) {
    throw FileError(path, "header", "one that libnifti can make", "an error");
  }
  std::string start(reinterpret_cast<const char*>(&header), sizeof header);
  start += std::string{static_cast<char>(image->num_ext > 0 ? 1 : 0), 0, 0, 0};
  for (const nifti1_extension& each : std::span(image->ext_list, static_cast<std::size_t>(image->num_ext))) {
    start.append(reinterpret_cast<const char*>(&each.esize), sizeof each.esize);
    start.append(reinterpret_cast<const char*>(&each.ecode), sizeof each.ecode);
    start.append(each.edata, static_cast<std::size_t>(each.esize) - sizeof each.esize - sizeof each.ecode);
  }
  write_whole(path, [&](WholeFile& file) {
    if (packed) return write_gzip(file, start, bytes_of(volume.values));
    file.write(start);
    file.write(volume.values);
  });
}

}  // namespace

void write_compressed_nrrd(const FloatVolume& volume, const std::filesystem::path& path, const Provenance& provenance) {
  write_nrrd(volume, path, nrrdEncodingGzip, provenance);
}

bool is_volume_output(const std::filesystem::path& path) { return !ending_of(path).empty(); }

void write_volume(const FloatVolume& volume, const std::filesystem::path& path, const Provenance& provenance) {
  if (volume.values.empty() || volume.values.size() != voxels_of(volume.dims)) {
    throw FileError(path, "values", fmt::format("{} x {} x {}", volume.dims[0], volume.dims[1], volume.dims[2]),
                    std::to_string(volume.values.size()));
  }
  const std::string ending = ending_of(path);
  if (ending.empty()) {
    throw FileError(path, "extension", ".nrrd, .mhd, .mha, .nii or .nii.gz", '"' + path.extension().string() + '"');
  }
  if (ending == ".nrrd") return write_nrrd(volume, path, nrrdEncodingRaw, provenance);
  if (ending.starts_with(".mh")) return write_meta_image(volume, path, ending == ".mhd");
  write_nifti(volume, path, ending == ".nii.gz", provenance);
}

}  // namespace gicube::scene
