#include "scene/graph/graph_reader.h"

#include <cmath>

#include "gicube/scene/scene.h"
#include "scene/buckyball.h"
#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

RawLayout read_raw(Faults& faults, const std::string& field, const v1::RawLayout& source) {
  RawLayout layout;
  faults.check(source.dims_size() == 3, field + ".dims", "3 numbers, x y z", std::to_string(source.dims_size()));
  for (int i = 0; i < std::min(source.dims_size(), 3); ++i) {
    layout.dims[static_cast<std::size_t>(i)] = faults.check_whole(field + ".dims", source.dims(i), 1, kMaxFileDim);
  }
  faults.gather(field, [&] { layout.type = sample_type_named(source.type(), "type"); });
  layout.big_endian = source.big_endian();
  layout.skip_bytes = source.skip_bytes();
  return layout;
}

// The points as a transfer function file, so that one parser checks both.
std::string as_text(const v1::TransferFunction& source) {
  const auto word = [](bool there, double value) { return there ? shown(value) : "missing"; };
  std::string text;
  for (const v1::ColourPoint& point : source.colour()) {
    const v1::Colour& colour = point.colour();
    text += fmt::format("colour {} {} {} {}\n", word(point.has_value(), point.value()), colour.red(), colour.green(),
                        colour.blue());
  }
  for (const v1::OpacityPoint& point : source.opacity()) {
    text += fmt::format("opacity {} {}\n", word(point.has_value(), point.value()),
                        word(point.has_opacity(), point.opacity()));
  }
  return text;
}

}  // namespace

Vec3 finite_vector(Faults& faults, const std::string& field, const v1::Vector& v) {
  const Vec3 vector{v.x(), v.y(), v.z()};
  faults.check(is_finite(vector), field, "finite numbers", shown_point(vector));
  return vector;
}

std::filesystem::path named_file(Faults& faults, const std::string& field, const std::string& name,
                                 const NamedFiles& files) {
  std::filesystem::path file;
  faults.gather_part(field, [&] { file = files.file("file", name); });
  return file;
}

Colour read_colour(Faults& faults, const std::string& field, const v1::Colour& colour) {
  return {faults.check_range(field + ".red", colour.red(), 0, 1),
          faults.check_range(field + ".green", colour.green(), 0, 1),
          faults.check_range(field + ".blue", colour.blue(), 0, 1)};
}

VolumeSource read_volume_source(Faults& faults, const std::string& field, const v1::VolumeSource& source,
                                const NamedFiles& files) {
  VolumeSource result;
  if (source.has_builtin() == source.has_file()) {
    faults.fault(field, "either builtin or file", source.has_file() ? "both" : "neither");
  }
  if (source.has_builtin()) {
    faults.check(source.builtin() == "buckyball", field + ".builtin", "\"buckyball\"", in_quotes(source.builtin()));
    result.builtin = source.builtin();
  }
  if (source.has_file()) result.file = named_file(faults, field, source.file(), files);
  result.allow_outside = files.allow_outside;
  if (source.has_size()) {
    faults.check(source.has_builtin(), field + ".size", "only with builtin", "it with a file");
    faults.check_range(field + ".size", source.size(), kMinBuckyballSize, kMaxBuckyballSize);
  }
  result.size = static_cast<int>(source.size());
  if (source.spacing_size() != 0) {
    const bool good = source.spacing_size() == 3;
    faults.check(good, field + ".spacing", "3 numbers, x y z", std::to_string(source.spacing_size()));
    for (const double edge : source.spacing()) {
      faults.check(edge > 0 && std::isfinite(edge), field + ".spacing", "numbers above 0", shown(edge));
    }
    if (good) result.spacing = Vec3{source.spacing(0), source.spacing(1), source.spacing(2)};
  }
  if (source.has_raw()) {
    faults.check(source.has_file(), field + ".raw", "only with file", "it without");
    result.raw = read_raw(faults, field + ".raw", source.raw());
    if (result.spacing) result.raw->spacing = *result.spacing;
  }
  return result;
}

std::optional<TransferFunctionFile> read_transfer_function_of(Faults& faults, const std::string& field,
                                                              const v1::TransferFunction& source,
                                                              const NamedFiles& files) {
  std::optional<TransferFunctionFile> result;
  const bool points = source.colour_size() != 0 || source.opacity_size() != 0;
  if (!faults.check_one(field, "one of file, preset, and points of colour and opacity",
                        {source.has_file(), source.has_preset(), points})) {
    return result;
  }
  if (source.has_file()) {
    const std::filesystem::path file = named_file(faults, field, source.file(), files);
    if (!file.empty()) faults.gather(field + ".file", [&] { result = read_transfer_function(file); });
  } else if (source.has_preset()) {
    faults.gather(field, [&] { result = find_preset(source.preset()); });
  } else {
    faults.gather(field, [&] { result = parse_transfer_function(as_text(source), ""); });
  }
  return result;
}

}  // namespace gicube::scene
