// Faults of a scene's text and of its meaning, in the order in which they are met; all of them are told at once.
#pragma once

#include <fmt/format.h>
#include <google/protobuf/io/tokenizer.h>

#include <stdexcept>
#include <string>

#include "scene/program/checks.h"

namespace gicube::samples {

class Faults : public google::protobuf::io::ErrorCollector {
 public:
  explicit Faults(std::string name) : name_(std::move(name)) {}

  void AddError(int line, int column, const std::string& message) override {
    add(fmt::format(":{}:{}: {}", line + 1, column + 1, message));
  }
  // The parser only warns of unknown fields when it is told to go on behind them.
  void AddWarning(int line, int column, const std::string& message) override { AddError(line, column, message); }

  void fault(const std::string& field, const std::string& expected, const std::string& got) {
    add(fmt::format(": {}: expected {}, got {}", field, expected, got));
  }
  void check(bool good, const std::string& field, const std::string& expected, const std::string& got) {
    if (!good) fault(field, expected, got);
  }
  // Runs something that throws InputError or FileError about its own file.
  template <typename Call>
  void gather(const std::string& field, const Call& call) {
    try {
      call();
    } catch (const std::runtime_error& error) {
      add(fmt::format(": {}: {}", field, error.what()));
    }
  }
  // The same where the message names a field of `field` itself: "FIELD.RADIUS: expected ...".
  template <typename Call>
  void gather_part(const std::string& field, const Call& call) {
    try {
      call();
    } catch (const std::runtime_error& error) {
      add(fmt::format(": {}.{}", field, error.what()));
    }
  }
  void throw_if_any() const {
    if (!text_.empty()) throw InputError(text_);
  }

 private:
  void add(const std::string& text) { text_ += fmt::format("{}{}{}", text_.empty() ? "" : "\n", name_, text); }

  std::string name_;
  std::string text_;
};

}  // namespace gicube::samples
