// The methods of gicube-light: each is a command with options of its own.
#pragma once

#include <CLI/CLI.hpp>

namespace gicube::samples {

// Each adds a command that carries out what its options ask for as it is parsed. Throws UsageError, InputError,
// FileError, and what Board throws.
void add_path(CLI::App& program);
void add_photon_map(CLI::App& program);

}  // namespace gicube::samples
