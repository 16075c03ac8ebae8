// The whole page: measures until no section asks for more, then writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "studies/results/bench.h"

namespace gicube::samples::results {

struct ReportOptions {
  std::filesystem::path folder;  // RESULTS.md goes there, all else into its results/
  Design design;
  int jobs = 1;
  bool quiet = false;
  std::vector<std::string> only;  // names of sections; empty: all
};

std::vector<std::string> section_names();

// Throws InputError (a file can't be written) and std::runtime_error (a run failed).
void write_report(const ReportOptions& options);

}  // namespace gicube::samples::results
