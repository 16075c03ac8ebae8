#include "gicube/scene/volume_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

#include "scene/common/checks.h"
#include "scene/formats/data_stream.h"
#include "scene/formats/orientation.h"
#include "scene/formats/readers.h"
#include "scene/formats/stored_samples.h"
#include "scene/formats/volume_library.h"

namespace gicube::scene {
namespace {

using Finder = StoredFile (*)(const VolumeSource&);
constexpr Finder kNrrd =
                     [](const VolumeSource&source) {
                       return find_nrrd(source.file, source.allow_outside, source.part);
                     },
                 kMetaImage =
                     [](const VolumeSource&source) {
                       return find_meta_image(source.file, source.allow_outside, source.part);
                     },
                 kNifti = [](const VolumeSource&source) { return find_nifti(source.file, source.part); },
                 kNumpy = [](const VolumeSource&source) { return find_numpy(source.file, source.part); },
                 kNumpyArchive = [](const VolumeSource&source) { return find_numpy_archive(source.file, source.part); },
                 kVtk = [](const VolumeSource&source) { return find_legacy_vtk(source.file); };

struct Format {
  const char* extension;  // lower case, at the end of the name
  Finder find;
};

constexpr std::array kFormats = {Format{".nrrd", kNrrd},     Format{".nhdr", kNrrd},    Format{".mhd", kMetaImage},
                                 Format{".mha", kMetaImage}, Format{".nii", kNifti},    Format{".nii.gz", kNifti},
                                 Format{".hdr", kNifti},     Format{".hdr.gz", kNifti}, Format{".img", kNifti},
                                 Format{".img.gz", kNifti},  Format{".npy", kNumpy},    Format{".npz", kNumpyArchive},
                                 Format{".vtk", kVtk}};

// Null: the name says nothing.
Finder finder_by_name(const std::filesystem::path& path) {
  const std::string name = lower_case(path.filename().string());
  for (const Format& format : kFormats) {
    if (name.ends_with(format.extension)) return format.find;
  }
  return nullptr;
}

Finder finder_by_contents(const std::filesystem::path& path) {
  if (is_nrrd(path)) return kNrrd;
  if (is_meta_image(path)) return kMetaImage;
  if (is_nifti(path)) return kNifti;
  if (is_numpy(path)) return kNumpy;
  if (is_legacy_vtk(path)) return kVtk;
  throw FileError(path, "format",
                  "NRRD, MetaImage, NIfTI, DICOM, TIFF, VTK, HDF5, OpenVDB, numpy, a folder of slices, or the layout "
                  "of raw samples",
                  "an unknown format and no layout");
}

StoredFile find_raw(const std::filesystem::path& path, const RawLayout& raw) {
  StoredLayout layout;
  layout.file = path;
  const std::array<std::int64_t, 3> sizes{raw.dims[0], raw.dims[1], raw.dims[2]};
  layout.dims = checked_dims(path, "dims", sizes);
  layout.type = stored_type(raw.type);
  layout.spacing = raw.spacing;
  layout.big_endian = raw.big_endian;
  DataPlace place;
  place.file = path;
  if (lower_case(path.extension().string()) == ".gz") place.compression = Compression::kGzip;
  place.skip = raw.skip_bytes;
  place.nothing_after = true;
  return {layout, place, Encoding::kBytes};
}

}  // namespace

std::vector<float> values_of(const Volume& volume) {
  return with_sample(volume.type, [&volume](auto sample) {
    std::vector<float> values(volume.samples.size() / sizeof sample);
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = static_cast<float>(sample_at<decltype(sample)>(volume.samples, i));
    }
    return values;
  });
}

ValueRange value_range_of(const Volume& volume) {
  if (volume.range) return *volume.range;
  if (volume.type == SampleType::kUint8) return {0, 255};
  if (volume.type == SampleType::kUint12) return {0, 4095};
  ValueRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for_each_plane(volume, [&](int, std::span<const std::byte> samples) {
    with_sample(volume.type, [&](auto sample) {
      for (std::size_t i = 0; i < samples.size() / sizeof sample; ++i) {
        const auto value = static_cast<double>(sample_at<decltype(sample)>(samples, i));
        if (std::isfinite(value)) range = {std::min(range.low, value), std::max(range.high, value)};
      }
    });
  });
  return range;
}

SampleType sample_type_named(const std::string& name, const std::string& field) {
  return named<SampleType>(field, name,
                           {{"uint8", SampleType::kUint8},
                            {"uint12", SampleType::kUint12},
                            {"uint16", SampleType::kUint16},
                            {"int16", SampleType::kInt16},
                            {"float32", SampleType::kFloat32}});
}

Volume with_spacing(Volume volume, const std::optional<Vec3>& given) {
  if (given) {
    volume.spacing = *given;
    return volume;
  }
  const Vec3 own = volume.spacing;
  if (!is_finite(own) || own.x == 0 || own.y == 0 || own.z == 0) {
    throw FileError(volume.source, "spacing", "three finite numbers, none of them 0", shown_point(own));
  }
  volume.spacing = {std::abs(own.x), std::abs(own.y), std::abs(own.z)};
  return volume;
}

namespace {

// Where the samples of a file lie that is no folder.
StoredFile find(const VolumeSource& source) {
  const std::string name = lower_case(source.file.filename().string());
  // Many programs call raw samples so.
  const bool is_image = name.ends_with(".img") || name.ends_with(".img.gz");
  const Finder named = is_image && source.raw ? nullptr : finder_by_name(source.file);
  if (named != nullptr && source.raw) {
    throw FileError(source.file, "layout", "none: the file says its own", "the layout of raw samples");
  }
  if (source.raw) return find_raw(source.file, *source.raw);
  return (named != nullptr ? named : finder_by_contents(source.file))(source);
}

Volume read_otherwise(const std::string& reader, const VolumeSource& source) {
  return reader == "vti" ? read_vti(source.file, source.part) : read_by(reader, source.file, source.part);
}

// Who reads a file that no StoredFile describes: "vti", or the shared object of that name. Empty: none.
std::string library_of(const VolumeSource& source) {
  if (source.raw) return "";
  std::error_code fault;
  if (std::filesystem::is_directory(source.file, fault)) return is_dicom(source.file) ? "dicom" : "";
  if (finder_by_name(source.file) != nullptr) return "";
  const std::string name = lower_case(source.file.filename().string());
  if (name.ends_with(".dcm") || name.ends_with(".ima") || is_dicom(source.file)) return "dicom";
  if (name.ends_with(".vti") || is_vti(source.file)) return "vti";
  return is_hdf5(source.file) ? "hdf5" : is_openvdb(source.file) ? "openvdb" : "";
}

// Kinds of slices: a folder of pictures, or the pages of a TIFF.
enum class Slices { kNone, kFolder, kPages };
Slices slices_of(const VolumeSource& source) {
  std::error_code fault;
  const std::string name = lower_case(source.file.filename().string());
  const bool folder = std::filesystem::is_directory(source.file, fault);
  const bool pages = name.ends_with(".tif") || name.ends_with(".tiff");
  if ((folder || pages) && source.raw)
    throw FileError(source.file, "layout", "none: slices say their own", "the layout of raw samples");
  return folder ? Slices::kFolder : pages ? Slices::kPages : Slices::kNone;
}

}  // namespace

namespace {

// Applies the source's options: orientation, edges, and numbers for missing values.
Volume finished(Volume volume, const VolumeSource& source) {
  if (!source.as_stored) volume = oriented(std::move(volume));
  volume = with_spacing(std::move(volume), source.spacing);
  if (!source.nan || volume.type != SampleType::kFloat32) return volume;
  const auto replace = [value = static_cast<float>(*source.nan)](std::span<std::byte> samples) {
    const std::span floats(reinterpret_cast<float*>(samples.data()), samples.size() / sizeof(float));
    for (float& sample : floats) sample = std::isfinite(sample) ? sample : value;
  };
  replace(volume.samples);
  if (!volume.planes) return volume;
  volume.planes = [replace, planes = std::move(volume.planes)](int first, int count, std::span<std::byte> out) {
    planes(first, count, out);
    replace(out);
  };
  return volume;
}

}  // namespace

Volume read_volume(const VolumeSource& source) {
  if (const std::string library = library_of(source); !library.empty())
    return finished(read_otherwise(library, source), source);
  const Slices slices = slices_of(source);
  return finished(slices == Slices::kFolder  ? read_slices(source.file)
                  : slices == Slices::kPages ? read_pages(source.file, source.part)
                                             : read_stored(find(source)),
                  source);
}

Volume open_volume(const VolumeSource& source) {
  if (const std::string library = library_of(source); !library.empty())
    return finished(read_otherwise(library, source), source);
  const Slices slices = slices_of(source);
  return finished(slices == Slices::kFolder  ? open_slices(source.file)
                  : slices == Slices::kPages ? open_pages(source.file, source.part)
                                             : open_stored(find(source)),
                  source);
}

Volume read_volume(const std::filesystem::path& path, const std::optional<RawLayout>& layout) {
  VolumeSource source;
  source.file = path;
  source.raw = layout;
  return read_volume(source);
}

}  // namespace gicube::scene
