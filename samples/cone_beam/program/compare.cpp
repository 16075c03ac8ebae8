#include <fmt/format.h>

#include <iostream>

#include "cone_beam/phantom/comparison.h"
#include "cone_beam/program/commands.h"
#include "cone_beam/program/object.h"
#include "cone_beam/program/slices.h"
#include "cone_beam/program/statistics.h"
#include "cone_beam/scan/scan_file.h"
#include "scene/formats/volume_output.h"
#include "scene/formats/whole_file.h"
#include "scene/program/input_error.h"
#include "scene/program/program.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

std::vector<float> truth_of(const ObjectOptions& truth, const Grid& grid) {
  if (is_phantom(truth)) return voxels(phantom_of(truth), grid);
  GridValues other = read_values(truth.name);
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

}  // namespace

void compare(const CompareOptions& options) {
  for (const auto& file :
       {options.difference, options.profiles, options.stats, std::filesystem::path(options.slices.name)}) {
    check_folder(file);
  }
  const GridValues volume = read_values(options.volume);
  const std::vector<float> truth = truth_of(options.truth, volume.grid);
  const Comparison found = compare(volume.grid, volume.values, truth, options.field);
  const std::vector<float> difference = differences(volume.values, truth);
  if (!options.difference.empty()) {
    write_volume({volume.grid.dims, volume.grid.spacing, origin_of(volume.grid, {}), difference}, options.difference);
  }
  if (!options.profiles.empty()) write_whole(options.profiles, profiles_text(volume, truth));
  write_slices(options.slices, volume.grid, difference);
  if (!options.stats.empty()) write_json(to_json(found), options.stats);
  fmt::print("RMSE {:.6g}, bias {:.6g}, relative L2 error {:.6g}, PSNR {:.4g} dB, SSIM {:.6g}, {} voxels\n", found.rmse,
             found.bias, found.relative_l2, found.psnr, found.ssim, found.voxels);
}

void import(const ImportOptions& options) {
  check_folder(options.output);
  const ScanDescription description = description_of(options.scan);
  if (!options.output.empty()) return write_scan_file(description, options.output);
  std::cout << scan_text(description, std::filesystem::current_path());
}

}  // namespace gicube::samples
