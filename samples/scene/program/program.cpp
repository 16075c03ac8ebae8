#include "scene/program/program.h"

#include <exception>
#include <iostream>
#include <new>

#include "gicube/scene/error.h"
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
    return body();
  } catch (const UsageError& error) {
    return report(error.what(), kWrongUsage);
  } catch (const std::bad_alloc&) {
    return report("out of memory", kFailed);
  } catch (const std::exception& error) {
    return report(error.what(), kFailed);
  }
}

void check_folder(const std::filesystem::path& file) {
  if (file.empty()) return;
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) throw InputError(file.string(), "a folder that is there", "none");
}

}  // namespace gicube::samples
