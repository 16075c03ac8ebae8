#include "scene/program/program.h"

#include <exception>
#include <iostream>
#include <map>
#include <new>
#include <system_error>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/names.h"
#include "scene/program/board_options.h"
#include "scene/program/progress.h"

namespace gicube::samples {

int run_program(const char* name, const std::function<int()>& body) {
  constexpr int kFailed = 1, kWrongUsage = 2;
  const auto report = [name](const char* text, int code) {
    std::cerr << name << ": " << text << '\n';
    return code;
  };
  set_warning_handler([name](const std::string& text) { print_warning(name, text); });
  try {
    const int code = body();
    check_standard_output();
    return code;
  } catch (const UsageError& error) {
    return report(error.what(), kWrongUsage);
  } catch (const std::bad_alloc&) {
    return report("out of memory", kFailed);
  } catch (const std::exception& error) {
    return report(error.what(), kFailed);
  }
}

void warn(const std::string& text) { print_warning(this_run().program.c_str(), text); }

namespace {

bool is_file(const std::filesystem::path& file) {
  std::error_code error;
  return std::filesystem::is_regular_file(file, error);
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

bool is_picture(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".png" || extension == ".exr" || extension == ".tif" || extension == ".tiff";
}

// With the files that writers put beside others.
std::vector<Output> with_data_files(const std::vector<Output>& outputs) {
  std::vector<Output> all = outputs;
  for (const auto& [option, file] : outputs) {
    if (lower_case(file.extension().string()) != ".mhd") continue;
    all.push_back({option, std::filesystem::path(file).replace_extension(".raw")});
  }
  return all;
}

}  // namespace

void check_picture_name(const std::filesystem::path& output) {
  const std::string extension = output.extension().string();
  if (extension == ".png" || extension == ".exr") return;
  throw UsageError("--output: expected a name that ends in .png or .exr, got " + in_quotes(output.string()));
}

void check_inputs_stay(const std::vector<Output>& outputs, const std::vector<std::filesystem::path>& inputs) {
  for (const auto& [option, file] : with_data_files(outputs)) {
    if (file.empty() || !is_file(file)) continue;
    for (const std::filesystem::path& input : inputs) {
      std::error_code error;
      const bool slice = is_picture(file) && std::filesystem::is_directory(input, error);
      if (!std::filesystem::equivalent(slice ? folder_of(file) : file, input, error)) continue;
      throw UsageError(option + ": expected a name whose files are not read, got one that would replace " +
                       in_quotes(file.string()));
    }
  }
}

void check_outputs(const std::vector<Output>& outputs, const std::vector<std::filesystem::path>& inputs) {
  check_inputs_stay(outputs, inputs);
  std::map<std::filesystem::path, std::string> options;
  for (const auto& [option, file] : with_data_files(outputs)) {
    if (file.empty()) continue;
    const std::filesystem::path folder = folder_of(file);
    std::error_code error;
    if (!std::filesystem::is_directory(folder, error)) {
      throw InputError(file.string(), "a folder that is there", "none");
    }
    if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) continue;
    if (!may_be_written(file)) throw InputError(file.string(), "a file that may be written to", "a read-only one");
    const std::filesystem::path meant = std::filesystem::weakly_canonical(folder / file.filename());
    const auto [other, fresh] = options.try_emplace(meant, option);
    if (!fresh && other->second != option) {
      throw UsageError(option + ": expected another file than " + other->second + ", got " + file.string());
    }
  }
}

}  // namespace gicube::samples
