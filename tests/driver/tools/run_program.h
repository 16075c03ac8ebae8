// A program of this build, run to its end.
#pragma once

#include <string>
#include <vector>

namespace gicube::tools_test {

struct Finished {
  int code = -1;  // exit code
  std::string out, err;
};

// `name` is a program of the build's bin folder. `variables` are set besides the environment, as "NAME=VALUE".
Finished run_program(const std::string& name, const std::vector<std::string>& arguments,
                     const std::vector<std::string>& variables = {});

}  // namespace gicube::tools_test
