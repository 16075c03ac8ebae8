#include "scene/program/program.h"

#include <exception>
#include <iostream>
#include <map>
#include <new>
#include <system_error>

#include "gicube/scene/error.h"
#include "scene/common/whole_file.h"
#include "scene/names.h"
#include "scene/program/board_options.h"

namespace gicube::samples {

int run_program(const char* name, const std::function<int()>& body) {
  constexpr int kFailed = 1, kWrongUsage = 2;
  const auto report = [name](const char* text, int code) {
    std::cerr << name << ": " << text << '\n';
    return code;
  };
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

void warn(const std::string& text) { std::cerr << this_run().program << ": warning: " << text << '\n'; }

void check_outputs(const std::vector<Output>& outputs) {
  std::map<std::filesystem::path, std::string> options;
  for (const auto& [option, file] : outputs) {
    if (file.empty()) continue;
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    std::error_code error;
    if (!std::filesystem::is_directory(folder, error)) {
      throw InputError(file.string(), "a folder that is there", "none");
    }
    if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) continue;
    const auto [other, fresh] = options.try_emplace(std::filesystem::canonical(folder) / file.filename(), option);
    if (!fresh && other->second != option) {
      throw UsageError(option + ": expected another file than " + other->second + ", got " + file.string());
    }
  }
}

}  // namespace gicube::samples
