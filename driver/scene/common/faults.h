// Syntax errors and faulty values of a scene, in the order of detection; all are reported together.
#pragma once

#include <fmt/format.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "scene/common/checks.h"

namespace gicube::scene {

class Faults : public google::protobuf::io::ErrorCollector {
 public:
  explicit Faults(std::string name) : name_(std::move(name)) {}

  void AddError(int line, int column, const std::string& message) override {
    const std::string text = fmt::format("{}:{}:{}: {}", name_, line + 1, column + 1, message);
    faults_.push_back({name_, line + 1, "", "protobuf text with known fields", message, text});
  }
  // The parser reports unknown fields as warnings when it may continue after them.
  void AddWarning(int line, int column, const std::string& message) override { AddError(line, column, message); }

  void fault(const std::string& field, const std::string& expected, const std::string& got) {
    add({"", 0, field, expected, got, fmt::format("{}: expected {}, got {}", field, expected, got)});
  }
  void check(bool good, const std::string& field, const std::string& expected, const std::string& got) {
    if (!good) fault(field, expected, got);
  }
  // Returns the value; check_whole() returns one within the range, so that it fits into an int.
  double check_range(const std::string& field, double value, double low, double high) {
    check(value >= low && value <= high, field, shown(low) + " to " + shown(high), shown(value));
    return value;
  }
  int check_whole(const std::string& field, std::uint32_t value, int low, int high) {
    return static_cast<int>(std::clamp<double>(check_range(field, value, low, high), low, high));
  }
  // Whether exactly one of these parts is present.
  bool check_one(const std::string& field, const std::string& expected, std::initializer_list<bool> there) {
    const auto count = std::ranges::count(there, true);
    check(count == 1, field, expected, count == 0 ? "none" : "several");
    return count == 1;
  }
  // Calls a function that may throw InputError about a part or another file; `between` separates field and message.
  template <typename Call>
  void gather(const std::string& field, const Call& call, const char* between = ": ") {
    try {
      call();
    } catch (const InputError& error) {
      for (Fault& fault : within(field, error, between)) add(std::move(fault));
    }
  }
  // Overload for messages that contain the whole field.
  template <typename Call>
  void gather(const Call& call) {
    try {
      call();
    } catch (const InputError& error) {
      for (const Fault& fault : error.faults()) add(fault);
    }
  }
  // Overload for messages that name a field of `field` itself: "FIELD.RADIUS: expected ...".
  template <typename Call>
  void gather_part(const std::string& field, const Call& call) {
    gather(field, call, ".");
  }
  void throw_if_any() const {
    if (!faults_.empty()) throw InputError(faults_);
  }

 private:
  void add(Fault fault) {
    if (fault.file.empty()) fault.file = name_;
    fault.text = name_ + ": " + fault.text;
    faults_.push_back(std::move(fault));
  }

  std::string name_;
  std::vector<Fault> faults_;
};

// Parses a text whose braces are nested at most `max_nesting` deep, which bounds the parser's stack. Throws InputError
// with all syntax errors and unknown fields; values are not checked then, because unknown fields are missing.
template <typename Message>
Message parsed_message(const std::string& text, int max_nesting, Faults& faults) {
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&faults);
  parser.SetRecursionLimit(max_nesting);
  parser.AllowUnknownField(true);  // reported by AddWarning; the parser continues with the next fault
  Message message;
  parser.ParseFromString(text, &message);
  faults.throw_if_any();
  return message;
}

}  // namespace gicube::scene
