// libgicube-dicom.so: series of DICOM by DCMTK. Debian 12 has security updates of DCMTK, but none of GDCM 3.0.21.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmjpeg/djdecode.h>
#include <dcmtk/dcmjpls/djdecode.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <system_error>
#include <tuple>

#include "scene/libraries/each_library.h"

namespace gicube::scene {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFiles = 65536;    // chosen: of a folder
constexpr Uint32 kMaxReadBytes = 4096;      // chosen: longer values are read when they are used
constexpr double kSaidDegrees = 0.1;        // chosen: the least tilt that is reported
constexpr double kSameStep = 0.01;          // chosen: steps that differ by a smaller part are equal
constexpr std::uint64_t kMaxPacked = 2000;  // chosen: bytes of samples per byte of a compressed file

// The number at `index` of an attribute, if there is one.
std::optional<double> number(DcmItem& item, const DcmTagKey& tag, unsigned long index = 0) {
  Float64 value = 0;
  if (item.findAndGetFloat64(tag, value, index).good()) return value;
  OFString text;
  if (item.findAndGetOFString(tag, text, index).bad()) return std::nullopt;
  OFBool good = OFFalse;
  value = OFStandard::atof(text.c_str(), &good);
  return good ? std::optional(value) : std::nullopt;
}

std::optional<int> whole(DcmItem& item, const DcmTagKey& tag) {
  Uint16 value = 0;
  if (item.findAndGetUint16(tag, value).good()) return value;
  const auto text = number(item, tag);
  return text && std::abs(*text) < 1e9 ? std::optional(static_cast<int>(*text)) : std::nullopt;
}

std::string text(DcmItem& item, const DcmTagKey& tag) {
  OFString value;
  return item.findAndGetOFString(tag, value).good() ? std::string(value.c_str()) : std::string();
}

std::optional<Vec3> vector(DcmItem& item, const DcmTagKey& tag, unsigned long first = 0) {
  const auto x = number(item, tag, first), y = number(item, tag, first + 1), z = number(item, tag, first + 2);
  if (!x || !y || !z || !std::isfinite(*x) || !std::isfinite(*y) || !std::isfinite(*z)) return std::nullopt;
  return Vec3{*x, *y, *z};
}

// One slice: a file, or a frame of one.
struct Slice {
  fs::path file;
  int frame = 0;
  std::optional<Vec3> row, column, position;
  std::optional<double> row_spacing, column_spacing, thickness;
  double slope = 1, intercept = 0;
  int instance = 0;
};

struct Series {
  std::string uid, name;
  int number = 0, rows = 0, columns = 0;
  std::vector<Slice> slices;
};

// Reads the geometry from a file, from the group of all frames, or from that of one.
void read_geometry(DcmItem& item, Slice& slice) {
  if (const auto row = vector(item, DCM_ImageOrientationPatient)) {
    slice.row = row;
    slice.column = vector(item, DCM_ImageOrientationPatient, 3);
  }
  if (const auto position = vector(item, DCM_ImagePositionPatient)) slice.position = position;
  if (const auto spacing = number(item, DCM_PixelSpacing)) {
    slice.row_spacing = spacing;
    slice.column_spacing = number(item, DCM_PixelSpacing, 1);
  }
  if (const auto between = number(item, DCM_SpacingBetweenSlices)) {
    slice.thickness = between;
  } else if (const auto thickness = number(item, DCM_SliceThickness)) {
    slice.thickness = thickness;
  }
  slice.slope = number(item, DCM_RescaleSlope).value_or(slice.slope);
  slice.intercept = number(item, DCM_RescaleIntercept).value_or(slice.intercept);
}

void read_frame_group(DcmItem& group, Slice& slice) {
  for (const DcmTagKey& tag : {DCM_PlaneOrientationSequence, DCM_PlanePositionSequence, DCM_PixelMeasuresSequence,
                               DCM_PixelValueTransformationSequence}) {
    DcmItem* item = nullptr;
    if (group.findAndGetSequenceItem(tag, item).good() && item != nullptr) read_geometry(*item, slice);
  }
}

// UID, rows, columns and plane: a series may have pictures in several planes, such as localizers.
using Group = std::tuple<std::string, int, int, std::string>;

void add_file(const fs::path& file, std::map<Group, Series>& groups) {
  DcmFileFormat format;
  if (format.loadFile(file.c_str(), EXS_Unknown, EGL_noChange, kMaxReadBytes).bad()) return;
  DcmDataset& data = *format.getDataset();
  const int rows = whole(data, DCM_Rows).value_or(0), columns = whole(data, DCM_Columns).value_or(0);
  if (rows < 1 || columns < 1 || !data.tagExists(DCM_PixelData)) return;  // such as a report
  Slice slice;
  slice.file = file;
  read_geometry(data, slice);
  slice.instance = whole(data, DCM_InstanceNumber).value_or(0);
  DcmItem* shared = nullptr;
  if (data.findAndGetSequenceItem(DCM_SharedFunctionalGroupsSequence, shared).good() && shared != nullptr)
    read_frame_group(*shared, slice);
  const int frames = std::clamp(whole(data, DCM_NumberOfFrames).value_or(1), 1, kMaxFileDim + 1);
  for (int frame = 0; frame < frames; ++frame) {
    Slice each = slice;
    each.frame = frame;
    DcmItem* group = nullptr;
    if (data.findAndGetSequenceItem(DCM_PerFrameFunctionalGroupsSequence, group, frame).good() && group != nullptr) {
      read_frame_group(*group, each);
    } else if (frames > 1) {
      // Frames without own positions follow each other if the file gives their distance.
      const bool follows = each.row && each.column && each.position && each.thickness;
      if (follows)
        each.position = *each.position + (frame * *each.thickness) * normalise(cross(*each.row, *each.column));
      if (!follows) each.position.reset();
    }
    std::string plane;
    if (each.row && each.column) {
      for (const Vec3& v : {*each.row, *each.column})
        plane += fmt::format("{:.2f} {:.2f} {:.2f} ", v.x + 0.0, v.y + 0.0, v.z + 0.0);
    }
    Series& series = groups[{text(data, DCM_SeriesInstanceUID), rows, columns, plane}];
    series.uid = text(data, DCM_SeriesInstanceUID);
    series.number = whole(data, DCM_SeriesNumber).value_or(0);
    series.name = text(data, DCM_Modality) + " " + text(data, DCM_SeriesDescription);
    series.rows = rows;
    series.columns = columns;
    series.slices.push_back(each);
  }
}

std::vector<Series> find_series(const fs::path& path) {
  std::map<Group, Series> groups;
  std::error_code fault;
  if (!fs::is_directory(path, fault)) {
    DcmFileFormat format;
    const OFCondition read = format.loadFile(path.c_str(), EXS_Unknown, EGL_noChange, kMaxReadBytes);
    if (read.bad()) fail(path, "file", "a DICOM file that DCMTK can read", read.text());
    add_file(path, groups);
    if (groups.empty()) fail(path, "PixelData", "pictures with rows and columns", "none");
  }
  std::size_t files = 0;
  for (fs::recursive_directory_iterator entry(path, fault), end; !fault && entry != end; entry.increment(fault)) {
    std::error_code unreadable;
    if (!entry->is_regular_file(unreadable) || entry->path().filename().string().starts_with('.')) continue;
    if (++files > kMaxFiles) fail(path, "folder", fmt::format("at most {} files", kMaxFiles), "more");
    add_file(entry->path(), groups);
  }
  std::vector<Series> all;
  for (auto& [key, series] : groups) all.push_back(std::move(series));
  if (all.empty()) fail(path, "folder", "a DICOM series with pictures", "none");
  std::ranges::stable_sort(all, {}, &Series::number);
  return all;
}

std::string listed(const std::vector<Series>& all) {
  std::string list;
  for (std::size_t i = 0; i < all.size() && i < 32; ++i) {
    list += fmt::format("{}{} ({}, {} of {} x {})", i > 0 ? ", " : "", i + 1, all[i].name, all[i].slices.size(),
                        all[i].columns, all[i].rows);
  }
  return list;
}

// The series with this number in the list, this UID, or this text in its description alone; without `part`, the one
// with the most slices.
Series choose(const fs::path& path, std::vector<Series> all, const std::string& part,
              std::vector<FileFault>& warnings) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (part == std::to_string(i + 1) || part == all[i].uid) return all[i];
    if (!part.empty() && all[i].name.find(part) != std::string::npos) found.push_back(i);
  }
  if (found.size() == 1) return all[found.front()];
  if (!part.empty()) fail(path, "part", "one series: " + listed(all), '"' + part + '"');
  const auto most = std::ranges::max_element(all, {}, [](const Series& series) { return series.slices.size(); });
  if (all.size() > 1) {
    warnings.push_back({path, "series", "a part: " + listed(all),
                        fmt::format("none; the one of most slices, {}, is taken", most - all.begin() + 1)});
  }
  return *most;
}

// Sorts the slices along the normal, and finds the volume's z axis and first position. Warns of uneven slices.
void sort(const fs::path& path, Series& series, StoredLayout& layout, std::vector<FileFault>& warnings) {
  auto& slices = series.slices;
  const Slice& some = slices.front();
  layout.spacing = {some.column_spacing.value_or(1), some.row_spacing.value_or(1), some.thickness.value_or(1)};
  const bool placed =
      some.row && some.column && std::ranges::all_of(slices, [](const Slice& s) { return s.position.has_value(); });
  if (!placed) {
    std::ranges::stable_sort(slices, {}, [](const Slice& s) { return std::pair(s.instance, s.frame); });
    warnings.push_back(
        {path, "ImagePositionPatient", "a position of each slice", "none; the order of InstanceNumber is taken"});
    return;
  }
  const Vec3 normal = cross(*some.row, *some.column);
  const auto along = [normal](const Slice& s) { return dot(*s.position, normal); };
  std::ranges::stable_sort(slices, {}, [&](const Slice& s) { return std::tuple(along(s), s.instance, s.frame); });
  const std::size_t before = slices.size();
  const auto twice =
      std::ranges::unique(slices, [&](const Slice& a, const Slice& b) { return std::abs(along(a) - along(b)) < 1e-4; });
  slices.erase(twice.begin(), twice.end());
  if (slices.size() < before) {
    warnings.push_back({path, "ImagePositionPatient", "one slice at each position",
                        fmt::format("{} slices at {} positions; the first of each are taken", before, slices.size())});
  }
  layout.placement.axes = WorldAxes::kPatient;
  layout.placement.directions = {*some.row, *some.column, normal};
  layout.placement.origin = *slices.front().position;
  if (slices.size() < 2) return;
  std::vector<double> steps;
  for (std::size_t i = 1; i < slices.size(); ++i) steps.push_back(along(slices[i]) - along(slices[i - 1]));
  std::vector<double> sorted = steps;
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
  const double step = sorted[sorted.size() / 2];
  const auto gap = std::ranges::find_if(steps, [&](double s) { return std::abs(s - step) > kSameStep * step; });
  if (gap != steps.end()) {
    const auto count = std::ranges::count_if(steps, [&](double s) { return std::abs(s - step) > kSameStep * step; });
    warnings.push_back({path, "ImagePositionPatient", fmt::format("even steps of {:g}", step),
                        fmt::format("{} others, the first of {:g} behind slice {}; shown as if even", count, *gap,
                                    gap - steps.begin() + 1)});
  }
  const double last = static_cast<double>(slices.size() - 1);
  const Vec3 way = *slices.back().position - *slices.front().position;
  layout.spacing.z = gap == steps.end() ? length(way) / last : step;
  const double cosine = dot(normalise(way), normal) / length(normal);
  const double degrees = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
  if (degrees > kSaidDegrees) {
    warnings.push_back({path, "gantry tilt", "slices right above each other",
                        fmt::format("{:.1f} degrees; the volume is shown without it, as a sheared one", degrees)});
    layout.placement.directions[2] = way;
  }
}

// The format of a file's pixels.
struct Pixels {
  int allocated = 0, stored = 0, high = 0, channels = 1, planar = 0;
  bool is_signed = false;
};

class File {
 public:
  File(const fs::path& file, const Series& series) : file_(file) {
    if (const OFCondition read = format_.loadFile(file.c_str(), EXS_Unknown, EGL_noChange, kMaxReadBytes); read.bad())
      fail(file, "file", "a DICOM file that DCMTK can read", read.text());
    DcmDataset& data = *format_.getDataset();
    pixels_.allocated = whole(data, DCM_BitsAllocated).value_or(0);
    pixels_.stored = whole(data, DCM_BitsStored).value_or(pixels_.allocated);
    pixels_.high = whole(data, DCM_HighBit).value_or(pixels_.stored - 1);
    pixels_.is_signed = whole(data, DCM_PixelRepresentation).value_or(0) != 0;
    pixels_.channels = whole(data, DCM_SamplesPerPixel).value_or(1);
    const int a = pixels_.allocated;
    if ((a != 8 && a != 16) || pixels_.stored < 1 || pixels_.stored > a || pixels_.high < pixels_.stored - 1 ||
        pixels_.high >= a)
      fail(file, "BitsAllocated, BitsStored, HighBit", "8 or 16 bits, and those that are stored among them",
           fmt::format("{}, {}, {}", a, pixels_.stored, pixels_.high));
    frames_ = std::max(whole(data, DCM_NumberOfFrames).value_or(1), 1);
    frame_samples_ = static_cast<std::size_t>(series.rows) * static_cast<std::size_t>(series.columns) *
                     static_cast<std::size_t>(std::clamp(pixels_.channels, 1, 4));
    const std::uint64_t bytes =
        std::uint64_t{frame_samples_} * static_cast<std::uint64_t>(frames_) * static_cast<std::uint64_t>(a / 8);
    std::error_code fault;
    const std::uint64_t in_file = fs::file_size(file, fault);
    const E_TransferSyntax syntax = data.getOriginalXfer();
    const bool packed = DcmXfer(syntax).isEncapsulated();
    if (fault || bytes > kMaxVolumeBytes ||
        bytes > in_file * (packed || syntax == EXS_DeflatedLittleEndianExplicit ? kMaxPacked : 1))
      fail(file, "PixelData", fmt::format("{} bytes", bytes),
           fmt::format("a file of {} bytes (truncated, or the header is wrong)", in_file));
    if (data.chooseRepresentation(EXS_LittleEndianExplicit, nullptr).bad())
      fail(file, "transfer syntax", "one that DCMTK decodes (uncompressed, RLE, JPEG, JPEG-LS)",
           DcmXfer(syntax).getXferName());
    const std::string colours = text(data, DCM_PhotometricInterpretation);
    pixels_.planar = whole(data, DCM_PlanarConfiguration).value_or(0);
    const bool grey = pixels_.channels == 1 && colours.starts_with("MONOCHROME");
    if (!grey && !(pixels_.channels == 3 && colours == "RGB" && a == 8))
      fail(file, "PhotometricInterpretation", "MONOCHROME2, MONOCHROME1 or RGB of 8 bits",
           fmt::format("\"{}\" of {} channels", colours, pixels_.channels));
    inverted_ = colours == "MONOCHROME1";
    unsigned long count = 0;
    const OFCondition got = a == 8 ? data.findAndGetUint8Array(DCM_PixelData, bytes_, &count)
                                   : data.findAndGetUint16Array(DCM_PixelData, words_, &count);
    if (got.bad() || count < frame_samples_ * static_cast<std::size_t>(frames_))
      fail(file, "PixelData", fmt::format("{} samples", frame_samples_ * static_cast<std::size_t>(frames_)),
           fmt::format("{} (truncated, or the header is wrong)", count));
  }

  const Pixels& pixels() const { return pixels_; }
  bool is_inverted() const { return inverted_; }

  // use(index, value) for each sample of a frame.
  template <typename Use>
  void for_each(int frame, const Use& use) const {
    if (frame >= frames_)
      fail(file_, "NumberOfFrames", fmt::format("at least {}", frame + 1), fmt::format("{}", frames_));
    const std::size_t first = static_cast<std::size_t>(frame) * frame_samples_;
    const int shift = pixels_.high + 1 - pixels_.stored;
    const unsigned mask = (1U << pixels_.stored) - 1, sign = 1U << (pixels_.stored - 1);
    const std::size_t plane = frame_samples_ / static_cast<std::size_t>(pixels_.channels);
    const auto channels = static_cast<std::size_t>(pixels_.channels);
    for (std::size_t i = 0; i < frame_samples_; ++i) {
      const std::size_t at = first + (pixels_.planar == 1 && channels > 1 ? i % channels * plane + i / channels : i);
      const unsigned value = (bytes_ != nullptr ? bytes_[at] : words_[at]) >> shift & mask;
      use(i, pixels_.is_signed ? static_cast<int>(value ^ sign) - static_cast<int>(sign) : static_cast<int>(value));
    }
  }

 private:
  fs::path file_;
  DcmFileFormat format_;
  Pixels pixels_;
  int frames_ = 1;
  std::size_t frame_samples_ = 0;
  bool inverted_ = false;
  const Uint8* bytes_ = nullptr;
  const Uint16* words_ = nullptr;
};

// Reads the samples of all slices, scaled. False: `Sample` is an integer type, and some value does not fit. HU usually
// fit into int16, although the bits of their files could hold larger values.
template <typename Sample>
bool fill(const Series& series, const Pixels& pixels, LibraryVolume& out) {
  std::optional<File> file;
  fs::path open;
  bool told = false;
  const std::size_t in_slice = static_cast<std::size_t>(series.rows) * static_cast<std::size_t>(series.columns) *
                               static_cast<std::size_t>(pixels.channels);
  out.samples.reserve(in_slice * series.slices.size() * sizeof(Sample));
  for (const Slice& slice : series.slices) {
    const double slope = pixels.channels > 1 ? 1 : slice.slope, intercept = pixels.channels > 1 ? 0 : slice.intercept;
    bool fits = !std::is_integral_v<Sample> || (slope == 1 && intercept == std::floor(intercept));
    if (!fits) return false;
    if (!file || open != slice.file) file.emplace(slice.file, series);
    open = slice.file;
    const Pixels& own = file->pixels();
    if (own.channels != pixels.channels)
      fail(slice.file, "SamplesPerPixel", fmt::format("{} as in the first slice", pixels.channels),
           fmt::format("{}", own.channels));
    if (file->is_inverted() && !std::exchange(told, true))
      out.warnings.push_back({slice.file, "PhotometricInterpretation", "MONOCHROME2",
                              "MONOCHROME1, dark where values are high; the values are kept"});
    const std::size_t begin = out.samples.size();
    out.samples.resize(begin + in_slice * sizeof(Sample));
    auto* const to = reinterpret_cast<Sample*>(out.samples.data() + begin);
    file->for_each(slice.frame, [&](std::size_t i, int value) {
      const double scaled = slope * value + intercept;
      if constexpr (std::is_integral_v<Sample>) {
        fits = fits && scaled >= std::numeric_limits<Sample>::min() && scaled <= std::numeric_limits<Sample>::max();
        if (!fits) return;
      }
      to[i] = static_cast<Sample>(scaled);
    });
    if (!fits) return false;
  }
  return true;
}

// Whether all values that the bits of the first file can hold, scaled, are whole and from 0 to 255.
bool fits_bytes(const Series& series, const Pixels& pixels) {
  const double least = pixels.is_signed ? -std::ldexp(1.0, pixels.stored - 1) : 0;
  const double most = least + std::ldexp(1.0, pixels.stored) - 1;
  return std::ranges::all_of(series.slices, [&](const Slice& s) {
    return s.slope == 1 && s.intercept == std::floor(s.intercept) && least + s.intercept >= 0 &&
           most + s.intercept <= 255;
  });
}

LibraryVolume read_series(const fs::path& path, const std::string& part) {
  LibraryVolume out;
  Series series = choose(path, find_series(path), part, out.warnings);
  for (const Slice& slice : series.slices) {
    if (!std::isfinite(slice.slope) || !std::isfinite(slice.intercept))
      fail(slice.file, "RescaleSlope, RescaleIntercept", "finite numbers",
           fmt::format("{}, {}", slice.slope, slice.intercept));
  }
  sort(path, series, out.layout, out.warnings);
  out.layout.dims = {series.columns, series.rows,
                     static_cast<int>(std::min<std::size_t>(series.slices.size(), kMaxFileDim + 1))};
  const Pixels pixels = File(series.slices.front().file, series).pixels();
  out.layout.channels = pixels.channels;
  if (!sane_bytes(out.layout, pixels.channels > 1 ? 1 : sizeof(float)))
    fail(path, "size", fmt::format("1..{} voxels a side, {} bytes", kMaxFileDim, kMaxVolumeBytes),
         fmt::format("{} x {} x {}", series.columns, series.rows, series.slices.size()));
  const std::vector<FileFault> warnings = out.warnings;
  const auto filled = [&](StoredType type, bool (*fill_with)(const Series&, const Pixels&, LibraryVolume&)) {
    out.layout.type = type;
    out.samples.clear();
    out.warnings = warnings;
    return fill_with(series, pixels, out);
  };
  const bool coloured = pixels.channels > 1;
  const bool bytes = coloured || (pixels.allocated == 8 && fits_bytes(series, pixels));
  if (bytes && filled(StoredType::kUint8, fill<std::uint8_t>)) return out;
  if (coloured) fail(path, "PixelRepresentation", "unsigned colours of 8 bits", "others");
  if (!filled(StoredType::kInt16, fill<std::int16_t>)) filled(StoredType::kFloat32, fill<float>);
  return out;
}

void start() {
  OFLog::configure(OFLogger::OFF_LOG_LEVEL);
  DJDecoderRegistration::registerCodecs();
  DJLSDecoderRegistration::registerCodecs();
  DcmRLEDecoderRegistration::registerCodecs();
}

}  // namespace
}  // namespace gicube::scene

extern "C" __attribute__((visibility("default"))) const gicube::scene::VolumeLibrary* gicube_dicom() {
  using namespace gicube::scene;
  static const EachLibrary library("DCMTK", start, read_series);
  return &library;
}
