// gicube-form-factors: radiosity in volumes, and visibility between voxels, by a GI-Cube board.
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>

#include "common/input_error.h"
#include "common/progress.h"
#include "form_factors/charts.h"
#include "form_factors/solve.h"
#include "form_factors/visibility.h"

namespace {

using namespace gicube::samples;

constexpr int kFailed = 1, kWrongUsage = 2;  // exit codes

// Found before the work, not behind it.
void check_folder(const std::filesystem::path& file) {
  if (file.empty()) return;
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) throw InputError(file.string(), "a folder that is there", "none");
}

int run(int argc, char** argv) {
  const auto options = parse_form_factor_options(argc, argv, std::cout);
  if (!options) return 0;
  if (const auto* wanted = std::get_if<SolveOptions>(&*options)) {
    for (const auto* file : {&wanted->factors, &wanted->solution, &wanted->picture, &wanted->board.stats}) {
      check_folder(*file);
    }
    ProgressLine progress(!wanted->board.quiet);
    solve(*wanted, progress);
  } else if (const auto* drawn = std::get_if<ChartOptions>(&*options)) {
    ProgressLine progress(!drawn->board.quiet);
    charts(*drawn, progress);
  } else {
    const auto& looked = std::get<VisibilityOptions>(*options);
    check_folder(looked.board.stats);
    ProgressLine progress(!looked.board.quiet);
    visibility(looked, progress);
  }
  return 0;
}

int report(const std::exception& error, int code) {
  std::cerr << "gicube-form-factors: " << error.what() << '\n';
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const UsageError& error) {
    return report(error, kWrongUsage);
  } catch (const std::bad_alloc&) {
    std::cerr << "gicube-form-factors: out of memory\n";
    return kFailed;
  } catch (const std::exception& error) {
    return report(error, kFailed);
  }
}
