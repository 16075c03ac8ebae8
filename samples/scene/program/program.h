// What the main functions of all programs share.
#pragma once

#include <filesystem>
#include <functional>

namespace gicube::samples {

// Calls `body`, which returns the exit code, and makes one line of what it throws: "NAME: ...". Exit codes: 2 for a
// UsageError, 1 for anything else.
int run_program(const char* name, const std::function<int()>& body);

// Throws InputError if the folder that is to hold `file` isn't there: found before the work, not behind it. Nothing for an
// empty name.
void check_folder(const std::filesystem::path& file);

}  // namespace gicube::samples
