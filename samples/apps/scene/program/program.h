// Common parts of the main functions of all programs.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace gicube::samples {

// Calls `body`, which returns the exit code, and prints its exception as one line: "NAME: ...". Exit codes: 2 for a
// UsageError, 1 for any other exception, and for a failure of standard output.
int run_program(const char* name, const std::function<int()>& body);

// Prints a warning on standard error, with the program's name (this_run()).
void warn(const std::string& text);

// An output file that an option names; empty: none.
struct Output {
  std::string option;
  std::filesystem::path file;
};

// Throws UsageError of --output unless write_image() supports the name.
void check_picture_name(const std::filesystem::path& output);

// Checks outputs before the work begins. Throws InputError if the folder of a file does not exist or the file is not
// writable, UsageError if two options name the same file, or an option a file of `inputs`. An .mhd includes its .raw.
// Pipes and devices may be named several times.
void check_outputs(const std::vector<Output>& outputs, const std::vector<std::filesystem::path>& inputs = {});
// Checks only the latter, for inputs and derived names that are known later. An input may be a folder, whose pictures
// are slices.
void check_inputs_stay(const std::vector<Output>& outputs, const std::vector<std::filesystem::path>& inputs);

}  // namespace gicube::samples
