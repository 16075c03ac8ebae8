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
#include "scene/formats/volume_library.h"

namespace gicube::scene {
namespace {

static_assert(std::endian::native == std::endian::little, "floats are written without conversion");

// One direction after another.
std::array<double, 9> numbers_of(const std::array<Vec3, 3>& d) {
  return {d[0].x, d[0].y, d[0].z, d[1].x, d[1].y, d[1].z, d[2].x, d[2].y, d[2].z};
}

std::string ending_of(const std::filesystem::path& path) {
  const std::string name = lower_case(path.filename().string());
  for (const char* ending : {".nrrd", ".mhd", ".mha", ".nii", ".nii.gz", ".vti", ".vdb"}) {
    if (name.ends_with(ending)) return ending;
  }
  return {};
}

std::string_view bytes_of(std::span<const float> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

// Writes one gzip stream of both parts.
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

// Sets space, origin and directions of the axes from `first` on; channels are before them. False: teem reported an
// error.
bool describe(Nrrd* nrrd, const FloatVolume& volume, unsigned first) {
  const auto spacing = in_order(volume.spacing), origin = in_order(volume.origin);
  double directions[4][NRRD_SPACE_DIM_MAX] = {};
  for (double& none : directions[0]) none = first > 0 ? AIR_NAN : 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto edge = in_order(spacing[axis] * volume.directions[axis]);
    std::ranges::copy(edge, directions[first + axis]);
  }
  const bool patient = volume.axes == WorldAxes::kPatient;
  const int space = patient ? nrrdSpaceSet(nrrd, nrrdSpaceLeftPosteriorSuperior) : nrrdSpaceDimensionSet(nrrd, 3);
  const bool good = space == 0 && nrrdSpaceOriginSet(nrrd, origin.data()) == 0;
  nrrdAxisInfoSet_nva(nrrd, nrrdAxisInfoSpaceDirection, directions);
  for (unsigned axis = 0; axis < 3; ++axis) nrrd->axis[first + axis].kind = nrrdKindDomain;
  if (first > 0) nrrd->axis[0].kind = nrrdKindRGBColor;
  return good;
}

// The text in front of the samples.
std::string nrrd_header(const FloatVolume& volume, const std::filesystem::path& path, const NrrdEncoding* encoding,
                        const Provenance& provenance) {
  const DecimalPoint point;
  const std::unique_ptr<Nrrd, decltype(&nrrdNix)> nrrd(nrrdNew(), &nrrdNix);  // nix: the values remain the caller's
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
      "TransformMatrix = {}\n{}Offset = {}\nElementSpacing = {}\nDimSize = {} {} {}\n"
      "ElementType = MET_FLOAT\nElementDataFile = {}\n",
      fmt::join(numbers_of(volume.directions), " "),
      volume.axes == WorldAxes::kPatient ? "" : "AnatomicalOrientation = ???\n",  // MetaIO's word for an unknown one
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

// NIfTI-1 in one file. libnifti makes the header, but does not check its writes. The axes are RAS. sform and qform are
// equal, because some programs read only one of them.
void write_nifti(const FloatVolume& volume, const std::filesystem::path& path, bool packed,
                 const Provenance& provenance) {
  const std::int64_t dims[8] = {3, volume.dims[0], volume.dims[1], volume.dims[2], 1, 1, 1, 1};
  const std::unique_ptr<nifti_image, decltype(&nifti_image_free)> image(nifti_make_new_nim(dims, NIFTI_TYPE_FLOAT32, 0),
                                                                        &nifti_image_free);
  if (!image) throw std::bad_alloc();
  const auto edges = in_order(volume.spacing);
  image->xyz_units = NIFTI_UNITS_MM;
  image->sform_code = image->qform_code = NIFTI_XFORM_SCANNER_ANAT;
  for (std::size_t axis = 0; axis < 4; ++axis) {
    const Vec3 column = axis < 3 ? edges[axis] * volume.directions[axis] : volume.origin;
    image->sto_xyz.m[0][axis] = -column.x;
    image->sto_xyz.m[1][axis] = -column.y;
    image->sto_xyz.m[2][axis] = column.z;
  }
  image->sto_xyz.m[3][3] = 1;
  nifti_dmat44_to_quatern(image->sto_xyz, &image->quatern_b, &image->quatern_c, &image->quatern_d, &image->qoffset_x,
                          &image->qoffset_y, &image->qoffset_z, nullptr, nullptr, nullptr, &image->qfac);
  image->dx = image->pixdim[1] = edges[0];
  image->dy = image->pixdim[2] = edges[1];
  image->dz = image->pixdim[3] = edges[2];
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

// VTK's image data with raw samples after the XML. Direction is a matrix, row by row (VTK 9).
void write_vti(const FloatVolume& volume, const std::filesystem::path& path) {
  const auto [x, y, z] = volume.dims;
  const auto& d = volume.directions;
  const std::array<double, 9> rows{d[0].x, d[1].x, d[2].x, d[0].y, d[1].y, d[2].y, d[0].z, d[1].z, d[2].z};
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", x - 1, y - 1, z - 1);
  const std::string header = fmt::format(
      "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "<ImageData WholeExtent=\"{}\" Origin=\"{}\" Spacing=\"{}\" Direction=\"{}\">\n<Piece Extent=\"{}\">\n"
      "<PointData Scalars=\"values\">\n<DataArray type=\"Float32\" Name=\"values\" format=\"appended\" offset=\"0\"/>\n"
      "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_",
      extent, fmt::join(in_order(volume.origin), " "), fmt::join(in_order(volume.spacing), " "), fmt::join(rows, " "),
      extent);
  const std::uint64_t bytes = volume.values.size_bytes();
  write_whole(path, [&](WholeFile& file) {
    file.write(header);
    file.write(std::string_view(reinterpret_cast<const char*>(&bytes), sizeof bytes));
    file.write(volume.values);
    file.write(std::string_view("\n</AppendedData>\n</VTKFile>\n"));
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
    throw FileError(path, "extension", ".nrrd, .mhd, .mha, .nii, .nii.gz, .vti or .vdb",
                    '"' + path.extension().string() + '"');
  }
  if (ending == ".nrrd") return write_nrrd(volume, path, nrrdEncodingRaw, provenance);
  if (ending == ".vdb") return write_by("openvdb", volume, path);
  if (ending == ".vti") return write_vti(volume, path);
  if (ending.starts_with(".mh")) return write_meta_image(volume, path, ending == ".mhd");
  write_nifti(volume, path, ending == ".nii.gz", provenance);
}

}  // namespace gicube::scene
