#include "run_program.h"

#include <sys/wait.h>

#include "temporary_directory.h"
#include "test.h"

namespace gicube::tools_test {
namespace {

std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  text += '\'';
  return text;
}

}  // namespace

Finished run_program(const std::string& name, const std::vector<std::string>& arguments,
                     const std::vector<std::string>& variables) {
  const reference::TemporaryDirectory folder;
  std::string command = "env";
  for (const std::string& variable : variables) command.append(" ").append(quoted(variable));
  command.append(" ").append(quoted(std::string(GICUBE_BIN_DIR "/") + name));
  for (const std::string& argument : arguments) command.append(" ").append(quoted(argument));
  command.append(" >").append(quoted(folder.file("out")));
  command.append(" 2>").append(quoted(folder.file("err"))).append(" </dev/null");
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of(folder.file("out")),
          text_of(folder.file("err"))};
}

}  // namespace gicube::tools_test
