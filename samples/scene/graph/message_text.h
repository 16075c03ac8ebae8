// Files of protobuf text.
#pragma once

#include <google/protobuf/text_format.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "scene/graph/faults.h"

namespace gicube::samples {

// `max_nesting` of braces bounds the parser's stack. Throws InputError with all that is wrong with the text if no message came of it.
template <typename Message>
Message parsed_message(const std::string& text, int max_nesting, Faults& faults) {
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&faults);
  parser.SetRecursionLimit(max_nesting);
  parser.AllowUnknownField(true);  // reported by AddWarning, and the parser goes on to the next fault
  Message message;
  if (!parser.ParseFromString(text, &message)) faults.throw_if_any();
  return message;
}

// The text of a file; `kind` says which: "a scene file". Throws InputError.
inline std::string read_text(const std::filesystem::path& path, const std::string& kind, std::uintmax_t max_mib) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path.string(), kind, "no such file");
  if (const auto bytes = std::filesystem::file_size(path, error); bytes > max_mib << 20) {
    throw InputError(path.string(), fmt::format("{} of at most {} MiB", kind, max_mib), fmt::format("{} bytes", bytes));
  }
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw InputError(path.string(), kind, "one that can't be read");
  return text.str();
}

}  // namespace gicube::samples
