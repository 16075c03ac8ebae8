#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include <cmath>
#include <numbers>

#include "cone_beam/scan/formats.h"
#include "gicube/v1/cone_scan.pb.h"
#include "scene/common/faults.h"
#include "scene/common/whole_file.h"

namespace gicube::samples {
namespace {

constexpr std::uintmax_t kMaxMib = 16;  // chosen: a million angles
constexpr int kMaxNesting = 20;         // chosen: of braces; bounds the parser's stack
constexpr double kMaxPixels = 65536;    // chosen: of a detector's edge
constexpr int kMaxViews = 1 << 20;      // chosen
constexpr double kRadians = std::numbers::pi / 180;

// Converts the parsed message to a description; an error leaves that part of it at its default.
struct Translator {
  Faults& faults;
  std::filesystem::path folder;

  ScanDescription translate(const v1::ConeScan& source) {
    ScanDescription out;
    ConeGeometry& geometry = out.geometry;
    volume(source.volume(), out);
    source.view_size() > 0 ? views(source, out) : circle(source, out);
    out.projections = stack("projections", source.projections(), geometry.detector);
    out.flats = stack("flat", source.flat(), geometry.detector);
    out.darks = stack("dark", source.dark(), geometry.detector);
    out.dead = stack("dead", source.dead(), geometry.detector);
    out.intensities = source.intensities();
    if (source.has_dxchange()) dxchange(source, out);
    if (source.has_full_intensity()) out.full = positive("full_intensity", true, source.full_intensity());
    const bool corrects = !out.flats.empty() || !out.darks.empty() || source.has_full_intensity();
    faults.check(out.intensities || !corrects, "intensities", "true where there are flats, darks or a full_intensity",
                 "false");
    faults.check(!out.intensities || !out.flats.empty() || source.has_full_intensity(), "flat",
                 "files, or a full_intensity, where intensities is true", "none");
    return out;
  }

  // Reading the file completes the description.
  void dxchange(const v1::ConeScan& source, ScanDescription& out) {
    const bool twice = source.view_size() > 0 || source.angle_size() > 0 || source.has_even_angles() ||
                       source.has_projections() || source.intensities() || source.has_flat() || source.has_dark() ||
                       source.has_full_intensity() || source.detector().has_columns() || source.detector().has_rows();
    faults.check(!twice, "dxchange",
                 "no views, angles, columns, rows, projections, intensities, flat and dark beside it, which it has",
                 "some");
    out.dxchange = folder / source.dxchange();
  }

  void circle(const v1::ConeScan& source, ScanDescription& out) {
    ConeGeometry& geometry = out.geometry;
    geometry.source_to_axis = positive("source_to_axis", source.has_source_to_axis(), source.source_to_axis());
    geometry.source_to_detector =
        positive("source_to_detector", source.has_source_to_detector(), source.source_to_detector());
    geometry.detector = detector(source.detector(), !source.has_dxchange());
    out.columns_reversed = source.detector().columns_reversed();
    out.rows_reversed = source.detector().rows_reversed();
    if (!source.has_dxchange()) geometry.angles = angles(source);
  }

  void views(const v1::ConeScan& source, ScanDescription& out) {
    const v1::ConeDetector& pixels_of = source.detector();
    const bool circular = source.has_source_to_axis() || source.has_source_to_detector() || source.angle_size() > 0 ||
                          source.has_even_angles() || pixels_of.has_pitch_u() || pixels_of.has_pitch_v() ||
                          pixels_of.has_offset_u() || pixels_of.has_offset_v() || pixels_of.columns_reversed() ||
                          pixels_of.rows_reversed();
    faults.check(!circular, "view", "no distances, angles, pitches, offsets and reversals, which each view has itself",
                 "some");
    Detector& detector = out.geometry.detector;
    detector.columns = pixels("detector.columns", pixels_of.has_columns(), pixels_of.columns(), 2);
    detector.rows = pixels("detector.rows", pixels_of.has_rows(), pixels_of.rows(), 1);
    std::vector<ViewPose> poses;
    bool good = !circular;
    for (int i = 0; i < source.view_size(); ++i) {
      const auto vector = [&](const char* part, const auto& numbers) {
        const std::string field = fmt::format("view[{}].{}", i, part);
        const bool three = numbers.size() == 3;
        faults.check(three, field, "three numbers", std::to_string(numbers.size()));
        good = good && three;
        if (!three) return Vec3{};
        for (const double number : numbers) good = std::isfinite(finite(field, number)) && good;
        return Vec3{numbers[0], numbers[1], numbers[2]};
      };
      const v1::ConeView& view = source.view(i);
      poses.push_back({vector("source", view.source()), vector("centre", view.centre()), vector("u", view.u()),
                       vector("v", view.v())});
    }
    faults.check(poses.size() >= 2, "view", "at least 2", std::to_string(poses.size()));
    if (!good) return;
    try {
      for (std::size_t i = 0; i < poses.size(); ++i) check_view(poses[i], "", fmt::format("view[{}]", i));
    } catch (const FileError& error) {
      faults.fault(error.field(), error.expected(), error.got());
      return;
    }
    const bool placed = source.volume().centre_size() == 3;
    set_views(std::move(poses), out.centre, out, placed ? std::optional(out.centre.z) : std::nullopt);
  }

  double positive(const std::string& field, bool set, double value) {
    faults.check(set && std::isfinite(value) && value > 0, field, "a number above 0", set ? shown(value) : "none");
    return value;
  }
  double finite(const std::string& field, double value) {
    faults.check(std::isfinite(value), field, "a finite number", shown(value));
    return value;
  }
  int pixels(const std::string& field, bool set, std::uint32_t value, double least) {
    faults.check(set && value >= least && value <= kMaxPixels, field,
                 fmt::format("a whole number from {} to {}", least, kMaxPixels), set ? std::to_string(value) : "none");
    return static_cast<int>(std::min(value, static_cast<std::uint32_t>(kMaxPixels)));
  }

  Detector detector(const v1::ConeDetector& source, bool has_pixels) {
    Detector out;
    if (has_pixels) out.columns = pixels("detector.columns", source.has_columns(), source.columns(), 2);
    if (has_pixels) out.rows = pixels("detector.rows", source.has_rows(), source.rows(), 1);
    out.pitch_u = positive("detector.pitch_u", source.has_pitch_u(), source.pitch_u());
    out.pitch_v = source.has_pitch_v() ? positive("detector.pitch_v", true, source.pitch_v()) : out.pitch_u;
    out.offset_u = finite("detector.offset_u", source.offset_u());
    out.offset_v = finite("detector.offset_v", source.offset_v());
    return out;
  }

  std::vector<double> angles(const v1::ConeScan& source) {
    std::vector<double> out;
    const bool listed = source.angle_size() > 0;
    if (source.has_even_angles() == listed) {
      faults.fault("angle", "a list of angles, or even_angles", listed ? "both" : "none");
    }
    for (int i = 0; i < source.angle_size(); ++i) {
      out.push_back(kRadians * finite(fmt::format("angle[{}]", i), source.angle(i)));
    }
    if (listed || !source.has_even_angles()) return out;
    const v1::EvenAngles& even = source.even_angles();
    const auto count = even.count();
    if (!even.has_count() || count < 2 || count > kMaxViews) {
      faults.fault("even_angles.count", fmt::format("a whole number from 2 to {}", kMaxViews), std::to_string(count));
      return out;
    }
    const double first = finite("even_angles.first", even.first()), arc = finite("even_angles.arc", even.arc());
    const bool at_end = even.has_last_at_end() ? even.last_at_end() : std::abs(std::abs(arc) - 360) > 1e-9;
    faults.check(arc != 0, "even_angles.arc", "a number but 0", "0");
    for (std::uint32_t i = 0; i < count; ++i)
      out.push_back(kRadians * (first + arc * i / (at_end ? count - 1 : count)));
    return out;
  }

  void volume(const v1::ConeVolume& source, ScanDescription& out) {
    const auto count = [&](const std::string& field, int given, bool one) {
      const bool good = given == 0 || given == 3 || (one && given == 1);
      faults.check(good, field, one ? "one number or three" : "three numbers", std::to_string(given));
      return good && given > 0;
    };
    if (count("volume.size", source.size_size(), false)) {
      const auto size = [&](int i) { return pixels(fmt::format("volume.size[{}]", i), true, source.size(i), 2); };
      out.geometry.volume.dims = {size(0), size(1), size(2)};
    }
    const int edges = source.spacing_size();
    if (count("volume.spacing", edges, true)) {
      const auto edge = [&](int i) {
        return positive(fmt::format("volume.spacing[{}]", i), true, source.spacing(edges == 1 ? 0 : i));
      };
      out.geometry.volume.spacing = {edge(0), edge(1), edge(2)};
    }
    if (count("volume.centre", source.centre_size(), false)) {
      const auto part = [&](int i) { return finite(fmt::format("volume.centre[{}]", i), source.centre(i)); };
      out.centre = {part(0), part(1), part(2)};
    }
  }

  StackFiles stack(const std::string& field, const v1::StackOfViews& source, const Detector& detector) {
    StackFiles out;
    for (const std::string& file : source.file()) {
      faults.check(!file.empty(), field + ".file", "a file's name", "an empty one");
      out.files.push_back(folder / file);
    }
    if (!source.has_type()) {
      faults.check(!source.big_endian() && source.skip_bytes() == 0, field + ".type",
                   "a type of raw samples with big_endian and skip_bytes", "none");
      return out;
    }
    const auto type = raw_type(source.type());
    faults.check(type.has_value(), field + ".type", "uint8, uint16, int16 or float32", '"' + source.type() + '"');
    out.raw = {.dims = {detector.columns, detector.rows, 0},
               .type = type.value_or(SampleType::kFloat32),
               .big_endian = source.big_endian(),
               .skip_bytes = source.skip_bytes()};
    return out;
  }
};

std::string name_in(const std::filesystem::path& folder, const std::filesystem::path& file) {
  return file.parent_path() == folder ? file.filename().string() : std::filesystem::absolute(file).string();
}

void put(const StackFiles& files, const std::filesystem::path& folder, v1::StackOfViews& out) {
  for (const auto& file : files.files) out.add_file(name_in(folder, file));
  if (!files.raw) return;
  for (const auto& [name, type] : kRawTypes) {
    if (type == files.raw->type) out.set_type(name);
  }
  if (files.raw->big_endian) out.set_big_endian(true);
  if (files.raw->skip_bytes != 0) out.set_skip_bytes(files.raw->skip_bytes);
}

void put(const Detector& detector, v1::ConeDetector& out) {
  out.set_columns(static_cast<std::uint32_t>(detector.columns));
  out.set_rows(static_cast<std::uint32_t>(detector.rows));
  out.set_pitch_u(detector.pitch_u);
  out.set_pitch_v(detector.pitch_v);
  if (detector.offset_u != 0) out.set_offset_u(detector.offset_u);
  if (detector.offset_v != 0) out.set_offset_v(detector.offset_v);
}

}  // namespace

std::optional<SampleType> raw_type(const std::string& name) {
  const auto known = kRawTypes.find(name);
  return known == kRawTypes.end() ? std::nullopt : std::optional(known->second);
}

ScanDescription parse_scan(const std::string& text, const std::string& name, const std::filesystem::path& folder) {
  Faults faults(name);
  ScanDescription out = Translator{faults, folder}.translate(parsed_message<v1::ConeScan>(text, kMaxNesting, faults));
  faults.throw_if_any();
  out.file = name;
  return out;
}

ScanDescription read_scan_file(const std::filesystem::path& path) {
  ScanDescription out = parse_scan(read_text(path, "a scan file", kMaxMib), path.string(), path.parent_path());
  if (!out.dxchange.empty()) take_dxchange(out);
  return out;
}

std::string scan_text(const ScanDescription& description, const std::filesystem::path& folder) {
  const ConeGeometry& geometry = description.geometry;
  v1::ConeScan message;
  v1::ConeDetector& detector = *message.mutable_detector();
  if (geometry.circular()) {
    message.set_source_to_axis(geometry.source_to_axis);
    message.set_source_to_detector(geometry.source_to_detector);
    put(geometry.detector, detector);
    if (description.columns_reversed) detector.set_columns_reversed(true);
    if (description.rows_reversed) detector.set_rows_reversed(true);
    for (const double angle : geometry.angles) message.add_angle(angle * 180 / std::numbers::pi);
  } else {
    detector.set_columns(static_cast<std::uint32_t>(geometry.detector.columns));
    detector.set_rows(static_cast<std::uint32_t>(geometry.detector.rows));
    for (const ViewPose& pose : geometry.poses) {
      v1::ConeView& view = *message.add_view();
      const auto add = [](Vec3 v, auto* numbers) {
        for (const double number : {v.x, v.y, v.z}) numbers->Add(number);
      };
      add(pose.source + description.centre, view.mutable_source());
      add(pose.centre + description.centre, view.mutable_centre());
      add((description.columns_reversed ? -1.0 : 1.0) * pose.u, view.mutable_u());
      add((description.rows_reversed ? -1.0 : 1.0) * pose.v, view.mutable_v());
    }
  }
  v1::ConeVolume& volume = *message.mutable_volume();
  const Vec3 edges = geometry.volume.spacing, centre = description.centre;
  if (geometry.volume.dims[0] > 0) {
    for (const int dim : geometry.volume.dims) volume.add_size(static_cast<std::uint32_t>(dim));
  }
  if (edges.x > 0) {
    for (const double edge : {edges.x, edges.y, edges.z}) volume.add_spacing(edge);
  }
  if (length(centre) > 0) {
    for (const double part : {centre.x, centre.y, centre.z}) volume.add_centre(part);
  }
  if (!description.dxchange.empty()) {  // has these itself
    message.set_dxchange(name_in(folder, description.dxchange));
    message.clear_angle();
    detector.clear_columns();
    detector.clear_rows();
  } else {
    if (!description.projections.empty()) put(description.projections, folder, *message.mutable_projections());
    if (description.intensities) message.set_intensities(true);
    if (!description.flats.empty()) put(description.flats, folder, *message.mutable_flat());
    if (!description.darks.empty()) put(description.darks, folder, *message.mutable_dark());
  }
  if (!description.dead.empty()) put(description.dead, folder, *message.mutable_dead());
  if (description.full > 0) message.set_full_intensity(description.full);
  std::string text;
  google::protobuf::TextFormat::PrintToString(message, &text);
  return text;
}

void write_scan_file(const ScanDescription& description, const std::filesystem::path& path) {
  write_whole(path, scan_text(description, path.parent_path()));
}

}  // namespace gicube::samples
