#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "cone_beam/phantom/phantom.h"
#include "cone_beam/program/options.h"
#include "cone_beam/scan/formats.h"
#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/program/option_group.h"
#include "scene/program/program.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

struct CompareOptions {
  std::filesystem::path volume;
  ObjectOptions truth;
  FieldOfView field;
  std::filesystem::path difference, profiles, stats;
  SliceOptions slices;  // of the difference
};

std::vector<float> truth_of(const ObjectOptions& truth, const Grid& grid) {
  if (is_phantom(truth)) return voxels(phantom_of(truth), grid);
  GridValues other = read_values(truth.name, truth.allow_outside);
  if (other.grid.dims != grid.dims) {
    const auto text = [](const Dims& dims) { return fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]); };
    throw InputError(truth.name, text(grid.dims) + " voxels, as the volume has", text(other.grid.dims));
  }
  return std::move(other.values);
}

std::string profiles_text(const GridValues& volume, const std::vector<float>& truth) {
  std::string text = "axis,position,value,truth\n";
  const Dims dims = volume.grid.dims, middle{dims[0] / 2, dims[1] / 2, dims[2] / 2};
  const std::array<double, 3> edges{volume.grid.spacing.x, volume.grid.spacing.y, volume.grid.spacing.z};
  for (int axis = 0; axis < 3; ++axis) {
    const auto values = profile(volume.grid, volume.values, axis, middle);
    const auto wanted = profile(volume.grid, truth, axis, middle);
    const auto along = static_cast<std::size_t>(axis);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double position = (static_cast<double>(i) - (dims[along] - 1) / 2.0) * edges[along];
      text += fmt::format("{},{},{},{}\n", static_cast<char>('x' + axis), position, values[i], wanted[i]);
    }
  }
  return text;
}

void run_compare(const CompareOptions& options) {
  check_volume_name("--difference", options.difference);
  std::vector<Output> outputs = options.slices.outputs();
  outputs.insert(outputs.end(),
                 {{"--difference", options.difference}, {"--profiles", options.profiles}, {"--stats", options.stats}});
  check_outputs(outputs, {options.volume, options.truth.name});
  const GridValues volume = read_values(options.volume, options.truth.allow_outside);
  const std::vector<float> truth = truth_of(options.truth, volume.grid);
  const Comparison found = compare(volume.grid, volume.values, truth, options.field);
  const std::vector<float> difference = differences(volume.values, truth);
  Provenance provenance = this_run();
  provenance.scene_hash = hex(hash_of(volume.values));
  write_values(volume.grid, {}, difference, provenance, options.difference);
  if (!options.profiles.empty()) write_whole(options.profiles, profiles_text(volume, truth));
  write_slices(options.slices, volume.grid, difference, provenance);
  if (!options.stats.empty()) {
    write_json({{"voxels", found.voxels},
                {"rmse", found.rmse},
                {"bias", found.bias},
                {"relative_l2", found.relative_l2},
                {"psnr", found.psnr},  // null if it is infinite
                {"ssim", found.ssim}},
               provenance, options.stats);
  }
  fmt::print("RMSE {:.6g}, bias {:.6g}, relative L2 error {:.6g}, PSNR {:.4g} dB, SSIM {:.6g}, {} voxels\n", found.rmse,
             found.bias, found.relative_l2, found.psnr, found.ssim, found.voxels);
}

void run_import(const ScanOptions& scan, const std::filesystem::path& output) {
  check_outputs({{"--output", output}});
  ScanDescription description = description_of(scan);
  const std::string extension = lower_case(output.extension().string());
  if (extension == ".xml" || extension == ".txt") {
    // In the scan's own coordinates, with the files' order of pixels.
    ConeGeometry& geometry = description.geometry;
    std::vector<ViewPose> poses;
    for (std::size_t view = 0; view < geometry.angles.size(); ++view) {
      const ViewPose at = pose(geometry, view);
      poses.push_back({at.source + description.centre, at.centre + description.centre,
                       (description.columns_reversed ? -1.0 : 1.0) * at.u,
                       (description.rows_reversed ? -1.0 : 1.0) * at.v});
    }
    geometry.poses = std::move(poses);
    return (extension == ".xml" ? write_rtk : write_astra)(geometry, output);
  }
  if (!output.empty()) return write_scan_file(description, output);
  std::cout << scan_text(description, std::filesystem::current_path());
}

}  // namespace

void add_compare(CLI::App& program) {
  CLI::App& app = *program.add_subcommand("compare", "compare a volume with the truth");
  const auto options = std::make_shared<CompareOptions>();
  app.add_option("VOLUME", options->volume, "a volume file")->required();
  add_object(app, options->truth, "TRUTH", "the true object");
  OptionGroup field(app, "Field of view"), output(app, "Output");
  field.value("--field-radius", options->field.radius, "omit voxels farther from the axis")->check(CLI::PositiveNumber);
  field.value("--field-height", options->field.half_height, "omit voxels farther from the middle plane")
      ->check(CLI::PositiveNumber);
  output.file("--difference", options->difference, "write values - truth here, as a volume");
  output.file("--profiles", options->profiles, "write values and truth along three lines through the middle here, CSV");
  output.file("--stats", options->stats, "write the figures here, JSON");
  add_slices(app, options->slices, "the difference");
  app.callback([options] { run_compare(*options); });
}

void add_import(CLI::App& program) {
  CLI::App& app = *program.add_subcommand("import", "convert a scan to a scan file, RTK's geometry or ASTRA's vectors");
  const auto scan = std::make_shared<ScanOptions>();
  const auto output = std::make_shared<std::filesystem::path>();
  add_input(app, *scan);
  OptionGroup(app, "Output")
      .file("-o,--output", *output,
            "write a scan file, RTK's geometry (.xml) or ASTRA's vectors (.txt) here (print a scan file)");
  app.callback([=] { run_import(*scan, *output); });
}

}  // namespace gicube::samples
