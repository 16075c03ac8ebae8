// Reads the text in one pass over protobuf's tokens, because TextFormat stops at the first invalid value. TextFormat is
// used for single values.
#include "textproto_reader.h"

#include <fmt/format.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <utility>

#include "gicube/v1/field_range.pb.h"

namespace gicube::emu {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::io::ColumnNumber;
using google::protobuf::io::Tokenizer;

constexpr std::size_t kMaxDiagnostics = 100;  // chosen: more than a person reads
constexpr std::size_t kMaxShown = 60;         // chosen: characters of a value in an error message

class FirstError : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int line, ColumnNumber, const std::string& text) override {
    if (diagnostic.expected.empty()) diagnostic = {"", "protobuf text", text, line + 1};
  }

  Diagnostic diagnostic;
};

// The names of a message's fields: "one of processors, block_voxels, ...".
std::string expected_names(const google::protobuf::Descriptor& type) {
  std::string names;
  for (int i = 0; i < type.field_count(); ++i) names += (i > 0 ? ", " : "one of ") + type.field(i)->name();
  return names;
}

// Sets a number or an enumeration from its text. Returns false, and changes nothing, if the text is not a valid value.
bool read_value(const std::string& text, const FieldDescriptor& field, Message& message) {
  FirstError ignored;
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&ignored);
  return parser.ParseFieldValueFromString(text, &field, &message);
}

class Reader {
 public:
  Reader(std::string_view text, TextReading& result)
      : stream_(text.data(), static_cast<int>(text.size())), result_(result) {
    tokens_.set_comment_style(Tokenizer::SH_COMMENT_STYLE);
    tokens_.set_require_space_after_number(false);
    tokens_.set_allow_multiline_strings(true);
    tokens_.Next();
  }

  void read(Message& message) {
    try {
      read_fields(message, "", "");
    } catch (Diagnostic& broken) {
      result_.diagnostics.push_back(std::move(broken));
    }
    const Diagnostic& error = errors_.diagnostic;
    if (result_.diagnostics.empty() && !error.expected.empty()) result_.diagnostics.push_back(error);
  }

 private:
  // `close`: the bracket that ends the message, or empty for the text's end.
  void read_fields(Message& message, const std::string& path, const std::string& close) {
    while (!(close.empty() ? at_end() : accept(close))) {
      if (tokens_.current().type != Tokenizer::TYPE_IDENTIFIER) {
        break_off("a field's name" + (close.empty() ? "" : fmt::format(" or \"{}\"", close)));
      }
      const int line = tokens_.current().line + 1;
      const std::string name = take();
      const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
      const bool has_colon = accept(":");
      if (field == nullptr) {
        report(path + name, expected_names(*message.GetDescriptor()), fmt::format("\"{}\"", name), line);
        skip_value();
      } else {
        if (!has_colon && field->message_type() == nullptr && !opens_message()) break_off("\":\"");
        read_values(message, *field, path + field->name(), line);
      }
      if (!accept(";")) accept(",");
    }
  }

  void read_values(Message& message, const FieldDescriptor& field, const std::string& path, int line) {
    if (!field.is_repeated() || !accept("[")) return read_one(message, field, path, line);
    if (accept("]")) return;
    do {
      read_one(message, field, path, line);
    } while (accept(","));
    if (!accept("]")) break_off("\",\" or \"]\"");
  }

  void read_one(Message& message, const FieldDescriptor& field, std::string path, int line) {
    if (field.is_repeated()) path += fmt::format("[{}]", instances_[path]++);
    result_.lines.emplace(path, line);
    const auto& reflection = *message.GetReflection();
    const bool is_message = field.message_type() != nullptr;
    if (!field.is_repeated() && reflection.HasField(message, &field)) {
      skip_value();
      report(path, "one value", "a second one", line);
    } else if (is_message && opens_message()) {
      const std::string close = take() == "{" ? "}" : ">";
      Message* part =
          field.is_repeated() ? reflection.AddMessage(&message, &field) : reflection.MutableMessage(&message, &field);
      read_fields(*part, path + ".", close);
    } else {
      const std::string value = skip_value();
      const bool is_read = !is_message && read_value(value, field, message);
      if (!is_read) report(path, expected_value(field), value, line);
    }
  }

  // Skips a value: a token with its sign, or everything between brackets. Returns its text. It does not recurse, so no
  // text can exhaust the stack; read_fields() recurses only as deep as the schema.
  std::string skip_value() {
    const bool is_message = opens_message();
    std::string text;
    int depth = 0;  // of brackets
    do {
      if (at_end()) break_off("a value");
      const int step = bracket();
      if (depth + step < 0) return "nothing";
      depth += step;
      text += take();
    } while (depth > 0 || text == "-");
    return is_message ? "a message" : text;
  }

  bool at_end() { return tokens_.current().type == Tokenizer::TYPE_END; }
  bool opens_message() { return tokens_.current().text == "{" || tokens_.current().text == "<"; }

  std::string take() {
    std::string text = tokens_.current().text;
    tokens_.Next();
    return text;
  }

  bool accept(std::string_view text) {
    if (at_end() || tokens_.current().text != text) return false;
    tokens_.Next();
    return true;
  }

  // Returns 1 for an opening bracket, -1 for a closing one, otherwise 0.
  int bracket() {
    const std::string& text = tokens_.current().text;
    if (text == "{" || text == "<" || text == "[") return 1;
    return text == "}" || text == ">" || text == "]" ? -1 : 0;
  }

  void report(std::string field, std::string expected, std::string got, int line) {
    if (result_.diagnostics.size() >= kMaxDiagnostics) {
      ++result_.left_out;
      return;
    }
    for (std::string* text : {&field, &got}) {
      if (text->size() > kMaxShown) text->replace(kMaxShown, std::string::npos, "...");
    }
    result_.diagnostics.push_back({std::move(field), std::move(expected), std::move(got), line});
  }

  // The text after this fault cannot be interpreted.
  [[noreturn]] void break_off(std::string expected) {
    const Tokenizer::Token& token = tokens_.current();
    throw Diagnostic{"", std::move(expected), at_end() ? "the end of the text" : fmt::format("\"{}\"", token.text),
                     token.line + 1};
  }

  google::protobuf::io::ArrayInputStream stream_;
  FirstError errors_;
  Tokenizer tokens_{&stream_, &errors_};
  TextReading& result_;
  std::map<std::string, int> instances_;  // of repeated fields
};

std::vector<std::uint64_t> numbers_in(std::string_view text) {
  std::vector<std::uint64_t> numbers;
  for (const char* at = text.begin(); at != text.end();) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(at, text.end(), number);
    if (error == std::errc()) numbers.push_back(number);
    at = std::max(end, at + 1);
  }
  return numbers;
}

}  // namespace

std::string to_string(const Diagnostic& diagnostic) {
  const std::string where = diagnostic.line > 0 ? fmt::format("line {}: ", diagnostic.line) : "";
  const std::string name = diagnostic.field.empty() ? "" : diagnostic.field + ": ";
  return fmt::format("{}{}expected {}, got {}", where, name, diagnostic.expected, diagnostic.got);
}

std::string to_string(std::span<const Diagnostic> diagnostics) {
  std::string text;
  for (const Diagnostic& each : diagnostics) text += (text.empty() ? "" : "\n") + to_string(each);
  return text;
}

std::string expected_value(const FieldDescriptor& field) {
  if (field.message_type() != nullptr) return "a message in braces";
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_UINT64) return "a whole number from 0 to 18446744073709551615";
  if (field.enum_type() == nullptr) return "a whole number from 0 to 4294967295";
  std::string names;
  for (int i = 0; i < field.enum_type()->value_count(); ++i) {
    const auto* value = field.enum_type()->value(i);
    if (value->number() != 0 && !value->options().deprecated())
      names += (names.empty() ? "one of " : ", ") + value->name();
  }
  return names;
}

std::optional<Diagnostic> fault_of(const Message& message, const FieldDescriptor& field) {
  const auto& reflection = *message.GetReflection();
  if (field.enum_type() != nullptr) {
    const auto* value = reflection.GetEnum(message, &field);
    if (value->number() != 0) return std::nullopt;
    return Diagnostic{"", expected_value(field), value->name()};
  }
  if (!field.options().HasExtension(v1::range) || !reflection.HasField(message, &field)) return std::nullopt;
  const std::string& range = field.options().GetExtension(v1::range);
  const std::uint64_t value = field.cpp_type() == FieldDescriptor::CPPTYPE_UINT64
                                  ? reflection.GetUInt64(message, &field)
                                  : reflection.GetUInt32(message, &field);
  const auto numbers = numbers_in(range);
  const std::size_t dots = range.find("..");
  if (dots == std::string::npos) {
    if (std::ranges::find(numbers, value) != numbers.end()) return std::nullopt;
    return Diagnostic{"", range, std::to_string(value)};
  }
  const std::string unit = range.substr(range.find(' '));
  const bool is_open = range[dots + 2] == ' ';
  if (value >= numbers[0] && (is_open || value <= numbers[1])) return std::nullopt;
  const std::string expected =
      is_open ? fmt::format("at least {}", numbers[0]) : fmt::format("{} to {}", numbers[0], numbers[1]);
  return Diagnostic{"", expected + unit, std::to_string(value)};
}

TextReading read_text(std::string_view text, Message& message) {
  TextReading result;
  if (text.size() > kMaxTextBytes) {
    result.diagnostics.push_back(
        {"", fmt::format("at most {} bytes of text", kMaxTextBytes), std::to_string(text.size())});
    return result;
  }
  Reader(text, result).read(message);
  return result;
}

}  // namespace gicube::emu
