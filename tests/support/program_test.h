// Base of the tests that run one of this build's programs as its users do, in a folder of the test's own.
#pragma once

#include <sys/wait.h>

#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples {

class ProgramTest : public testing::Test {
 protected:
  struct ProgramResult {
    int code = -1;  // exit code
    std::string out, err;
  };

  explicit ProgramTest(std::string program) : program_(std::move(program)) {}

  std::string path(const std::string& name) const { return folder_.file(name); }

  ProgramResult run(const std::string& arguments) const {
    const std::string command = GICUBE_BIN_DIR "/" + program_ + " " + arguments + " >" + path("stdout") + " 2>" +
                                path("stderr") + " </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(path("stdout")), text_of(path("stderr"))};
  }

 private:
  std::string program_;
  reference::TemporaryDirectory folder_;
};

}  // namespace gicube::samples
