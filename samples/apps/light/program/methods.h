// Methods of gicube-light: each is a command with its own options.
#pragma once

#include <CLI/CLI.hpp>

namespace gicube::samples {

// Adds a command that runs when it is parsed. Throws UsageError, InputError, FileError, and what Board throws.
void add_path(CLI::App& program);
void add_photon_map(CLI::App& program);

}  // namespace gicube::samples
