// Exceptions of gicube-scene: a text or value from the user is wrong. They are thrown before any board is changed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "gicube/error.h"

namespace gicube::scene {

// One fault. If a file names another file that has the fault, `file` is the inner one; the text has both.
struct GICUBE_API Fault {
  std::string file{};   // empty: the value is not from a file
  int line = 0;         // of a text file, from 1; 0: unknown
  std::string field{};  // its path, such as "node[ring].torus.radius"; empty: the text has invalid syntax
  std::string expected{}, got{};
  std::string text{};  // all of that as a sentence: "FILE:LINE: FIELD: expected ..., got ..."
};

// A scene, a transfer function or a value in them is wrong. what() has a line for each fault.
class GICUBE_API InputError : public Error {
 public:
  InputError(const std::string& field, const std::string& expected, const std::string& got);
  // At least one.
  explicit InputError(std::vector<Fault> faults);

  const std::vector<Fault>& faults() const { return faults_; }

  // Those of the first fault.
  const std::string& file() const { return faults_.front().file; }
  int line() const { return faults_.front().line; }
  const std::string& field() const { return faults_.front().field; }
  const std::string& expected() const { return faults_.front().expected; }
  const std::string& got() const { return faults_.front().got; }

 private:
  std::vector<Fault> faults_;
};

// A file cannot be read or written, is damaged, or has invalid contents.
class GICUBE_API FileError : public InputError {
 public:
  FileError(const std::filesystem::path& file, const std::string& field, const std::string& expected,
            const std::string& got);
};

// Receives a sentence about something suspicious in a file that is read nevertheless: "FILE: data: expected ..., got
// ...".
using WarningHandler = std::function<void(const std::string& text)>;
// Sets the handler of the warnings of all threads; initially there is none. Do not call it while files are read.
// Exceptions of the handler propagate out of the call that reads the file.
GICUBE_API void set_warning_handler(WarningHandler handler);

}  // namespace gicube::scene
