// A sweep from its options to its table.
#pragma once

#include <filesystem>
#include <functional>

#include "sweep/options.h"
#include "sweep/table.h"

namespace gicube::samples::sweep {

using SweepProgress = std::function<void(std::size_t done, std::size_t all)>;

// Runs what FOLDER/runs does not have yet by the gicube-render `program`, and works out costs and errors.
// Throws RunFailed, FileError, InputError (a figure that a run does not have).
Table sweep(const SweepOptions& options, const std::filesystem::path& program, const SweepProgress& progress);

// Of the options' folder and name: CSV, JSON, the gnuplot script, and with `chart` its picture. Throws FileError; RunFailed if
// gnuplot fails.
void write_files(const SweepOptions& options, const Table& table);

}  // namespace gicube::samples::sweep
