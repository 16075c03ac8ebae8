#include <google/protobuf/text_format.h>

#include <numbers>

#include "cone_beam/scan/scan_file.h"
#include "gicube/v1/cone_scan.pb.h"
#include "scene/formats/whole_file.h"

namespace gicube::samples {
namespace {

void put(const StackFiles& files, const std::filesystem::path& folder, v1::StackOfViews& out) {
  for (const auto& file : files.files) {
    out.add_file(file.parent_path() == folder ? file.filename().string() : std::filesystem::absolute(file).string());
  }
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

std::string scan_text(const ScanDescription& description, const std::filesystem::path& folder) {
  const ConeGeometry& geometry = description.geometry;
  v1::ConeScan message;
  message.set_source_to_axis(geometry.source_to_axis);
  message.set_source_to_detector(geometry.source_to_detector);
  put(geometry.detector, *message.mutable_detector());
  if (description.columns_reversed) message.mutable_detector()->set_columns_reversed(true);
  if (description.rows_reversed) message.mutable_detector()->set_rows_reversed(true);
  for (const double angle : geometry.angles) message.add_angle(angle * 180 / std::numbers::pi);
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
  if (!description.projections.empty()) put(description.projections, folder, *message.mutable_projections());
  if (description.intensities) message.set_intensities(true);
  if (!description.flats.empty()) put(description.flats, folder, *message.mutable_flat());
  if (!description.darks.empty()) put(description.darks, folder, *message.mutable_dark());
  if (description.full > 0) message.set_full_intensity(description.full);
  std::string text;
  google::protobuf::TextFormat::PrintToString(message, &text);
  return text;
}

void write_scan_file(const ScanDescription& description, const std::filesystem::path& path) {
  write_whole(path, scan_text(description, path.parent_path()));
}

}  // namespace gicube::samples
