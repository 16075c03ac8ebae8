// Common parts of the main functions of all programs.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace gicube::samples {

// Calls `body`, which returns the exit code, and makes one line of what it throws: "NAME: ...". Exit codes: 2 for a
// UsageError, 1 for anything else, also where what was printed did not get to standard output.
int run_program(const char* name, const std::function<int()>& body);

// A line on standard error that begins with the program's name (this_run()).
void warn(const std::string& text);

// A file that an option names; empty: none.
struct Output {
  std::string option;
  std::filesystem::path file;
};

// Throws UsageError of --output unless that is a name which write_image() takes.
void check_picture_name(const std::filesystem::path& output);

// Checks before the work what would be found behind it. Throws InputError if the folder that is to hold a file isn't
// there or the file may not be written to, UsageError if two options name one file, or an option a file of `inputs`.
// An .mhd stands for its .raw too. A pipe or a device may have several.
void check_outputs(const std::vector<Output>& outputs, const std::vector<std::filesystem::path>& inputs = {});
// The latter alone, for inputs and derived names that are known later. An input may be a folder, whose pictures are
// slices.
void check_inputs_stay(const std::vector<Output>& outputs, const std::vector<std::filesystem::path>& inputs);

}  // namespace gicube::samples
