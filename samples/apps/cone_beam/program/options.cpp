#include "cone_beam/program/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <regex>

#include "cone_beam/scan/formats.h"
#include "gicube/scene/image_file.h"
#include "gicube/scene/volume_file.h"
#include "scene/common/checks.h"
#include "scene/program/option_group.h"

namespace gicube::samples {
namespace {

CLI::ValidationError expected(const std::string& option, const char* what, const std::string& text) {
  return CLI::ValidationError(option, fmt::format("expected {}, got {}", what, in_quotes(text)));
}

void add_allow_outside(CLI::App& app, const char* group, bool& target) {
  OptionGroup(app, group).flag("--allow-outside", target, "let headers name data files outside their folders");
}

void add_volume(CLI::App& app, ScanOptions& scan) {
  OptionGroup group(app, "Volume");
  group.parsed("--size", "X,Y,Z", "number of voxels (the scan's, or as many as the detector sees)",
               [&scan](const std::string& name, const std::string& text) {
                 const std::vector<int> sizes = parse_sizes(name, text, 3, ',');
                 scan.size = Dims{sizes[0], sizes[1], sizes[2]};
               });
  group.parsed("--spacing", "EDGE|X,Y,Z", "edges of a voxel (the scan's, or a pixel's at the axis)",
               [&scan](const std::string& name, const std::string& text) {
                 const bool three = text.find(',') != std::string::npos;
                 std::vector<double> edges = parse_numbers(name, text, three ? 3 : 1);
                 edges.resize(3, edges[0]);
                 for (const double edge : edges) {
                   if (!(edge > 0)) throw expected(name, "numbers above 0", text);
                 }
                 scan.spacing = {edges[0], edges[1], edges[2]};
               });
}

void add_pixels(OptionGroup& group, ScanOptions& scan, const std::string& when) {
  group.parsed("--detector", "WxH", "pixels" + when, [&scan](const std::string& option, const std::string& text) {
    const std::vector<int> sizes = parse_sizes(option, text, 2, 'x');
    scan.detector_size = {sizes[0], sizes[1]};
  });
  group.value("--pitch", scan.pitch, "distance of the pixels" + when)->check(CLI::PositiveNumber);
}

}  // namespace

PixelsGiven ScanOptions::pixels() const {
  PixelsGiven out;
  if (detector_size) out = {(*detector_size)[0], (*detector_size)[1]};
  out.pitch = pitch.value_or(0);
  return out;
}

void add_object(CLI::App& app, ObjectOptions& object, const std::string& name, const std::string& what) {
  app.add_option(name, object.name,
                 what +
                     ": builtin:shepp-logan, builtin:shepp-logan-high-contrast, builtin:sphere, builtin:discs, or a "
                     "volume file (.nrrd .mhd .mha .nii)")
      ->required();
  OptionGroup(app, "Options")
      .number("--radius", object.radius, CLI::PositiveNumber, "radius of a phantom, in the scan's unit");
  app.add_option("--value", object.value,
                 "value of the sphere, or factor of a head's or discs' values; water has about 0.02 per mm")
      ->capture_default_str();
  add_allow_outside(app, "Options", object.allow_outside);
}

void add_input(CLI::App& app, ScanOptions& scan) {
  app.add_option("SCAN", scan.input,
                 "a scan file (protobuf text), CTSimU's .json, RTK's geometry (.xml), Nikon's .xtekct, ASTRA's vectors "
                 "(text), or a folder of plastimatch's projection matrices")
      ->required();
  OptionGroup group(app, "Scan");
  group
      .value("--projections", scan.projections,
             "views that replace the scan's: .nrrd .mhd .mha .nii .pfm .tif, a folder of images, or raw")
      ->type_name("FILE...");
  group.parsed("--type", "NAME", "type of raw --projections: uint8 uint16 int16 float32, little-endian",
               [&scan](const std::string& name, const std::string& text) {
                 scan.type = raw_type(text);
                 if (!scan.type) throw expected(name, "uint8, uint16, int16 or float32", text);
               });
  add_pixels(group, scan, " of RTK's or ASTRA's views, if the projections' header does not give it");
  add_allow_outside(app, "Scan", scan.allow_outside);
  add_volume(app, scan);
}

void add_own_scan(CLI::App& app, ScanOptions& scan) {
  OptionGroup group(app, "Scan");
  group.file("--scan", scan.input, "take the geometry of this scan (a SCAN of reconstruct), instead of these options")
      ->type_name("SCAN");
  add_pixels(group, scan, " (256x256 of 1.56)");
  group.number("--source-to-axis", scan.source_to_axis, CLI::PositiveNumber, "distance from source to axis");
  group.number("--source-to-detector", scan.source_to_detector, CLI::PositiveNumber,
               "distance from source to detector");
  group.number("--views", scan.views, CLI::Range(2, 100'000), "number of views, uniform over the arc");
  group.number("--arc", scan.arc, CLI::Range(1.0, 360.0), "arc of the views, degrees");
  add_volume(app, scan);
}

void add_slices(CLI::App& app, SliceOptions& slices, const std::string& what) {
  OptionGroup group(app, "Output");
  group.value("--slices", slices.name, "write pictures of " + what + ": NAME_x.png, NAME_y.png, NAME_z.png")
      ->type_name("NAME");
  group.parsed("--grey", "LOW,HIGH", "values for black and white (nearly the least and the greatest)",
               [&slices](const std::string& name, const std::string& text) {
                 const std::vector<double> range = parse_numbers(name, text, 2);
                 if (range[0] >= range[1]) throw expected(name, "LOW below HIGH", text);
                 slices.grey = {range[0], range[1]};
               });
  group
      .parsed("--slice", "AXIS=INDEX", "a plane such as z=75, instead of the three in the middle; repeatable",
              [&slices](const std::string& name, const std::string& text) {
                static const std::regex kPlane("([xyz])=([0-9]{1,5})");
                std::smatch parts;
                if (!std::regex_match(text, parts, kPlane)) throw expected(name, "x, y or z = a whole number", text);
                slices.planes.emplace_back(text[0] - 'x', std::stoi(parts[2]));
              })
      ->take_all();
}

ScanDescription description_of(const ScanOptions& options) {
  StackFiles projections{options.projections, {}};
  if (options.type) {
    if (options.projections.empty()) throw UsageError("--type: only with --projections");
    projections.raw = RawLayout{};
    projections.raw->type = *options.type;
  }
  ScanDescription out;
  if (!options.input.empty()) {
    out = read_description(options.input, projections, options.pixels());
  } else {
    ConeGeometry& geometry = out.geometry;
    geometry.source_to_axis = options.source_to_axis;
    geometry.source_to_detector = options.source_to_detector;
    const std::array<int, 2> size = options.detector_size.value_or(std::array{256, 256});
    const double pitch = options.pitch.value_or(1.56);
    geometry.detector = {size[0], size[1], pitch, pitch};
    const double radians = std::numbers::pi / 180;
    geometry.angles = even_angles(options.views, 0, options.arc * radians);
  }
  for (StackFiles* files : {&out.projections, &out.flats, &out.darks, &out.dead})
    files->allow_outside = options.allow_outside;
  if (options.size) out.geometry.volume.dims = *options.size;
  if (options.spacing) out.geometry.volume.spacing = *options.spacing;
  complete_volume(out);
  return out;
}

bool is_phantom(const ObjectOptions& object) { return object.name.starts_with("builtin:"); }

Phantom phantom_of(const ObjectOptions& object) {
  const auto times_value = [&object](Phantom phantom) {
    for (Ellipsoid& ellipsoid : phantom) ellipsoid.value *= object.value;
    return phantom;
  };
  if (object.name == "builtin:shepp-logan") return times_value(shepp_logan(object.radius));
  if (object.name == "builtin:shepp-logan-high-contrast") return times_value(high_contrast_shepp_logan(object.radius));
  if (object.name == "builtin:sphere") return uniform_sphere(object.radius, object.value);
  if (object.name == "builtin:discs") return times_value(discs(object.radius));
  throw InputError("phantom", "builtin:shepp-logan, builtin:shepp-logan-high-contrast, builtin:sphere or builtin:discs",
                   in_quotes(object.name));
}

GridValues read_values(const std::filesystem::path& file, bool allow_outside) {
  VolumeSource source;
  source.file = file;
  source.allow_outside = allow_outside;
  const Volume volume = read_volume(source);
  GridValues out{{volume.dims, volume.spacing}, values_of(volume)};
  const auto bad = std::ranges::find_if(out.values, [](float value) { return !std::isfinite(value); });
  if (bad != out.values.end()) {
    throw FileError(file, fmt::format("voxel {}", bad - out.values.begin()), "a finite value", fmt::format("{}", *bad));
  }
  return out;
}

void write_values(const Grid& grid, Vec3 centre, std::span<const float> values, const Provenance& provenance,
                  const std::filesystem::path& file) {
  if (file.empty()) return;
  write_volume({grid.dims, grid.spacing, centre + to_space(grid, {0, 0, 0}), values}, file, provenance);
}

std::uint64_t hash_of(std::span<const float> values) { return scene::hash_of(std::as_bytes(values)); }

void check_volume_name(const char* option, const std::filesystem::path& path) {
  if (path.empty() || is_volume_output(path)) return;
  throw UsageError(fmt::format("{}: expected a name that ends in .nrrd, .mhd, .mha, .nii or .nii.gz, got {}", option,
                               in_quotes(path.string())));
}

Image slice_of(const Grid& grid, std::span<const float> values, int axis, int index,
               const std::array<double, 2>& grey) {
  const std::size_t across = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
  const auto columns = static_cast<std::size_t>(grid.dims[0]), rows = static_cast<std::size_t>(grid.dims[1]);
  const std::array<std::size_t, 3> strides{1, columns, columns * rows};
  Image image{grid.dims[across], grid.dims[up], {}};
  const std::size_t plane = static_cast<std::size_t>(index) * strides[static_cast<std::size_t>(axis)];
  for (int row = image.height - 1; row >= 0; --row) {
    for (int column = 0; column < image.width; ++column) {
      const double value = static_cast<double>(values[plane + static_cast<std::size_t>(row) * strides[up] +
                                                      static_cast<std::size_t>(column) * strides[across]]);
      const double part = std::clamp((value - grey[0]) / (grey[1] - grey[0]), 0.0, 1.0);
      const auto level = static_cast<std::uint8_t>(std::lround(255 * part));
      image.pixels.push_back({level, level, level, 4095});
    }
  }
  return image;
}

std::array<double, 2> grey_range(std::span<const float> values) {
  std::vector<float> sorted(values.begin(), values.end());
  const std::size_t tail = sorted.size() / 1000;
  const auto at = [&](std::size_t place) {
    std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(place));
    return static_cast<double>(sorted[place]);
  };
  const double low = at(tail), high = at(sorted.size() - 1 - tail);
  return {low, high > low ? high : low + 1};
}

std::filesystem::path SliceOptions::file(int axis, int index) const {
  return fmt::format("{}_{}{}.png", name, static_cast<char>('x' + axis), planes.empty() ? "" : std::to_string(index));
}

std::vector<Output> SliceOptions::outputs() const {
  std::vector<Output> out;
  const std::vector<std::pair<int, int>> middle{{0, 0}, {1, 0}, {2, 0}};
  if (name.empty()) return out;
  for (const auto& [axis, index] : planes.empty() ? middle : planes) out.push_back({"--slices", file(axis, index)});
  return out;
}

void write_slices(const SliceOptions& options, const Grid& grid, std::span<const float> values,
                  const Provenance& provenance) {
  if (options.name.empty()) return;
  const std::array<double, 2> grey = options.grey ? *options.grey : grey_range(values);
  auto planes = options.planes;
  if (planes.empty()) planes = {{0, grid.dims[0] / 2}, {1, grid.dims[1] / 2}, {2, grid.dims[2] / 2}};
  for (const auto& [axis, index] : planes) {
    const char letter = static_cast<char>('x' + axis);
    const int end = grid.dims[static_cast<std::size_t>(axis)];
    if (index >= end) {
      throw InputError(fmt::format("--slice {}", letter), fmt::format("0 to {}", end - 1), std::to_string(index));
    }
    write_png(slice_of(grid, values, axis, index, grey), options.file(axis, index), Colour{0, 0, 0}, provenance);
  }
}

}  // namespace gicube::samples
