// Other programs, run to their end.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace gicube::samples::sweep {

class RunFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// `program`: a path, or a name on the PATH. What it writes goes to the file `log`; it runs in `folder`, or in this process' own.
// Throws RunFailed unless it ends with exit code 0: how it ended, and the last line that it wrote.
void run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                 const std::filesystem::path& log, const std::filesystem::path& folder = {});

}  // namespace gicube::samples::sweep
