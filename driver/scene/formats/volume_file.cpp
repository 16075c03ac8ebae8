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

Volume open_raw(const std::filesystem::path& path, const RawLayout& raw) {
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
  return open_stored({layout, place, Encoding::kBytes});
}

Volume open_dicom(const VolumeSource& source) { return read_by("dicom", source.file, source.part); }

struct Format {
  const char* extensions;                    // ends of names, lower case, with blanks between
  bool (*is)(const std::filesystem::path&);  // by the contents; null: only the name tells
  Volume (*open)(const VolumeSource&);
  bool may_be_raw = false;  // a file of such a name may hold raw samples, if their layout is given
};

constexpr std::array kFormats{
    Format{".nrrd .nhdr", is_nrrd,
           [](const VolumeSource& s) { return open_stored(find_nrrd(s.file, s.allow_outside, s.part)); }},
    Format{".mhd .mha", is_meta_image,
           [](const VolumeSource& s) { return open_stored(find_meta_image(s.file, s.allow_outside, s.part)); }},
    Format{".nii .nii.gz .hdr .hdr.gz", is_nifti,
           [](const VolumeSource& s) { return open_stored(find_nifti(s.file, s.part)); }},
    Format{".img .img.gz", nullptr, [](const VolumeSource& s) { return open_stored(find_nifti(s.file, s.part)); },
           true},
    Format{".npy", is_numpy, [](const VolumeSource& s) { return open_stored(find_numpy(s.file, s.part)); }},
    Format{".npz", nullptr, [](const VolumeSource& s) { return open_stored(find_numpy_archive(s.file, s.part)); }},
    Format{".vtk", is_legacy_vtk, [](const VolumeSource& s) { return open_stored(find_legacy_vtk(s.file)); }},
    Format{".vti", is_vti, [](const VolumeSource& s) { return read_vti(s.file, s.part); }, true},
    Format{".tif .tiff", nullptr, [](const VolumeSource& s) { return open_pages(s.file, s.part); }},
    Format{".dcm .ima", is_dicom, open_dicom, true},
    Format{"", is_hdf5, [](const VolumeSource& s) { return read_by("hdf5", s.file, s.part); }},
    Format{"", is_openvdb, [](const VolumeSource& s) { return read_by("openvdb", s.file, s.part); }}};

Volume open_by_format(const VolumeSource& source) {
  std::error_code fault;
  const bool folder = std::filesystem::is_directory(source.file, fault);
  const std::string name = lower_case(source.file.filename().string());
  const auto has_name = [&](const Format& format) {
    return std::ranges::any_of(words_of(format.extensions), [&](std::string_view end) { return name.ends_with(end); });
  };
  const auto* found = folder ? kFormats.end() : std::ranges::find_if(kFormats, has_name);
  if (source.raw && (folder || (found != kFormats.end() && !found->may_be_raw)))
    throw FileError(source.file, "layout", "none, since the file or folder has its own", "the layout of raw samples");
  if (source.raw) return open_raw(source.file, *source.raw);
  if (folder) return is_dicom(source.file) ? open_dicom(source) : open_slices(source.file);
  if (found == kFormats.end()) {
    found = std::ranges::find_if(kFormats, [&](const Format& f) { return f.is != nullptr && f.is(source.file); });
  }
  if (found == kFormats.end()) {
    throw FileError(source.file, "format",
                    "NRRD, MetaImage, NIfTI, DICOM, TIFF, VTK, HDF5, OpenVDB, numpy, a folder of slices, or the layout "
                    "of raw samples",
                    "an unknown format and no layout");
  }
  return found->open(source);
}

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

Volume open_volume(const VolumeSource& source) { return finished(open_by_format(source), source); }

Volume read_volume(const VolumeSource& source) {
  Volume volume = open_volume(source);
  take_planes(volume);
  return volume;
}

Volume read_volume(const std::filesystem::path& path, const std::optional<RawLayout>& layout) {
  VolumeSource source;
  source.file = path;
  source.raw = layout;
  return read_volume(source);
}

}  // namespace gicube::scene
