// Strict reading of protobuf text.
//
// Protobuf's own text parser decides what is right; it stops at the first value it can't read. So a faulty field is
// reported, blanked out of the text, and the parser runs again, until nothing but faults of structure can be left.
#include "textproto_reader.h"

#include <fmt/format.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "text_schema.h"

namespace gicube::emu {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::io::ColumnNumber;
using google::protobuf::io::Tokenizer;

constexpr std::size_t kMaxTextBytes = 1 << 20;  // chosen: a configuration is below 1 KB, 10,000 planned faults are 1 MB
constexpr int kMaxFaults = 100;                 // chosen: nobody reads more, and each costs a pass

struct Complaint {
  int line = 0;  // from 0, as protobuf counts
  int column = 0;
  std::string text;
};

class Collector : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int line, ColumnNumber column, const std::string& text) override {
    errors.push_back({line, column, text});
  }
  void AddWarning(int line, ColumnNumber column, const std::string& text) override {
    warnings.push_back({line, column, text});
  }

  std::vector<Complaint> errors, warnings;
};

// One `name: value` or `name { ... }`: tokens [name, end) of the text.
struct Field {
  std::string path;
  std::size_t name, end;
};

struct Scan {
  const Descriptor& schema;
  std::vector<Tokenizer::Token> tokens;
  std::vector<Field> fields;  // in the order of their names
};

bool is_open(const std::string& text) { return text == "{" || text == "<"; }
bool is_close(const std::string& text) { return text == "}" || text == ">"; }

std::vector<Tokenizer::Token> tokenize(const std::string& text) {
  google::protobuf::io::ArrayInputStream stream(text.data(), static_cast<int>(text.size()));
  Collector ignored;
  Tokenizer tokenizer(&stream, &ignored);
  tokenizer.set_comment_style(Tokenizer::SH_COMMENT_STYLE);
  tokenizer.set_require_space_after_number(false);
  tokenizer.set_allow_multiline_strings(true);
  std::vector<Tokenizer::Token> tokens;
  while (tokenizer.Next()) tokens.push_back(tokenizer.current());
  return tokens;
}

// Without the [index] that a repeated field has.
std::string_view bare(std::string_view name) { return name.substr(0, name.find('[')); }

const Descriptor* parent_type(const Descriptor* type, std::string_view path) {
  for (std::size_t dot; type != nullptr && (dot = path.find('.')) != std::string_view::npos;
       path.remove_prefix(dot + 1)) {
    const auto* field = type->FindFieldByName(std::string(bare(path.substr(0, dot))));
    type = field == nullptr ? nullptr : field->message_type();
  }
  return type;
}

// Nothing if the schema has no such field.
const FieldDescriptor* known_field(const Descriptor& schema, std::string_view path) {
  const Descriptor* type = parent_type(&schema, path);
  return type == nullptr ? nullptr : type->FindFieldByName(std::string(bare(path.substr(path.rfind('.') + 1))));
}

// The token after the value that begins at `at`.
std::size_t end_of_value(const std::vector<Tokenizer::Token>& tokens, std::size_t at) {
  if (at < tokens.size() && tokens[at].text == "-") ++at;
  if (at < tokens.size() && tokens[at].text == "[") {
    while (at < tokens.size() && tokens[at].text != "]") ++at;
  }
  return at < tokens.size() && !is_close(tokens[at].text) ? at + 1 : at;
}

// Finds the fields without judging them; a broken structure gives whatever can be recognised.
Scan scan(const std::string& text, const Descriptor& schema) {
  Scan result{schema, tokenize(text), {}};
  const auto& tokens = result.tokens;
  std::vector<std::size_t> open;                 // fields whose braces are open
  std::map<std::string, std::size_t> instances;  // of repeated fields
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    if (is_close(tokens[i].text)) {
      if (open.empty()) continue;
      result.fields[open.back()].end = i + 1;
      open.pop_back();
      continue;
    }
    if (tokens[i].type != Tokenizer::TYPE_IDENTIFIER) continue;
    const std::string parent = open.empty() ? "" : result.fields[open.back()].path + ".";
    Field field{parent + tokens[i].text, i, i + 1};
    const FieldDescriptor* known = known_field(schema, field.path);
    if (known != nullptr && known->is_repeated()) field.path += fmt::format("[{}]", instances[field.path]++);
    if (field.end < tokens.size() && tokens[field.end].text == ":") ++field.end;
    if (field.end < tokens.size() && is_open(tokens[field.end].text)) {
      open.push_back(result.fields.size());
      i = field.end++;
    } else if (field.end > i + 1) {
      field.end = end_of_value(tokens, field.end);
      i = field.end - 1;
    }
    result.fields.push_back(std::move(field));
  }
  for (const std::size_t unclosed : open) result.fields[unclosed].end = tokens.size();
  return result;
}

bool before(const Tokenizer::Token& token, const Complaint& place) {
  return std::pair(token.line, token.column) < std::pair(place.line, place.column);
}

// The field that a message of the parser is about: it reports the token after the one it has last consumed, so this is
// the last field whose name stands before that place.
const Field* field_at(const Scan& scan, const Complaint& place) {
  const Field* found = nullptr;
  for (const Field& field : scan.fields) {
    if (before(scan.tokens[field.name], place)) found = &field;
  }
  return found;
}

std::string value_text(const Scan& scan, const Field& field) {
  std::string text;
  for (std::size_t i = field.name + 1; i < field.end; ++i) {
    if (i == field.name + 1 && scan.tokens[i].text == ":") continue;
    if (is_open(scan.tokens[i].text)) return "a message";
    text += scan.tokens[i].text;
  }
  return text.empty() ? "nothing" : text;
}

std::size_t offset_of(const std::string& text, int line, int column) {
  std::size_t at = 0;
  for (int i = 0; i < line; ++i) at = text.find('\n', at) + 1;
  return at + static_cast<std::size_t>(column);
}

// Overwrites a field with spaces; every other token keeps its line and column.
void blank(std::string& text, const Scan& scan, const Field& field) {
  const Tokenizer::Token &first = scan.tokens[field.name], &last = scan.tokens[field.end - 1];
  const std::size_t begin = offset_of(text, first.line, first.column);
  const std::size_t end = std::min(text.size(), offset_of(text, last.line, last.column) + last.text.size());
  for (std::size_t i = begin; i < end; ++i) {
    if (text[i] != '\n') text[i] = ' ';
  }
}

// Braces after a scalar's name, or a bare value after a message's.
bool has_wrong_form(const Scan& scan, const Field& field) {
  const auto* known = known_field(scan.schema, field.path);
  if (known == nullptr) return false;
  return (known->message_type() != nullptr) != (value_text(scan, field) == "a message");
}

// The parser wants a name or a brace there, whatever field came before.
bool is_structural(const std::string& complaint) {
  return complaint.rfind("Expected identifier", 0) == 0 || complaint.rfind("Expected \"", 0) == 0 ||
         complaint.rfind("Message is missing", 0) == 0;
}

void report_unknown(const Scan& scan, const Collector& collector, std::vector<Fault>& faults) {
  for (const Complaint& warning : collector.warnings) {
    const Field* field = field_at(scan, warning);
    if (field == nullptr) continue;
    const Tokenizer::Token& name = scan.tokens[field->name];
    const auto* parent = parent_type(&scan.schema, field->path);
    const std::string expected = parent == nullptr ? "a field of " + scan.schema.name() : expected_names(*parent);
    Fault fault{field->path, expected, fmt::format("\"{}\"", name.text), name.line + 1};
    const auto same = [&fault](const Fault& other) { return other.line == fault.line && other.field == fault.field; };
    if (std::none_of(faults.begin(), faults.end(), same)) faults.push_back(std::move(fault));
  }
}

// Reports what stopped the parser; true if the field could be blanked, so that another pass makes sense.
bool report_error(std::string& text, const Scan& scan, const Complaint& error, std::vector<Fault>& faults) {
  const Field* field = field_at(scan, error);
  if (field != nullptr && is_structural(error.text) && !has_wrong_form(scan, *field)) field = nullptr;
  const auto* known = field == nullptr ? nullptr : known_field(scan.schema, field->path);
  if (known == nullptr) {
    faults.push_back({"", "protobuf text of " + scan.schema.full_name(), error.text, error.line + 1});
    return false;
  }
  const bool twice = error.text.find("specified multiple times") != std::string::npos;
  faults.push_back({field->path, twice ? "to be set once" : expected_value(*known),
                    twice ? "it a second time" : value_text(scan, *field), scan.tokens[field->name].line + 1});
  blank(text, scan, *field);
  return true;
}

}  // namespace

std::string to_string(const Fault& fault) {
  const std::string where = fault.line > 0 ? fmt::format("line {}: ", fault.line) : "";
  const std::string name = fault.field.empty() ? "" : fault.field + ": ";
  return fmt::format("{}{}expected {}, got {}", where, name, fault.expected, fault.got);
}

std::string to_string(std::span<const Fault> faults) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += '\n';
    text += to_string(fault);
  }
  return text;
}

TextReading read_text(std::string_view input, google::protobuf::Message& message) {
  TextReading result;
  if (input.size() > kMaxTextBytes) {
    result.faults.push_back({"", fmt::format("at most {} bytes of text", kMaxTextBytes), std::to_string(input.size())});
    return result;
  }
  std::string text(input);
  std::replace(text.begin(), text.end(), '\t', ' ');  // the tokenizer counts a tab as up to eight columns
  for (int pass = 0; pass < kMaxFaults; ++pass) {
    const Scan fields = scan(text, *message.GetDescriptor());
    Collector collector;
    google::protobuf::TextFormat::Parser parser;
    parser.RecordErrorsTo(&collector);
    parser.AllowUnknownField(true);
    const bool parsed = parser.ParseFromString(text, &message);
    report_unknown(fields, collector, result.faults);
    for (const Field& field : fields.fields) result.lines.emplace(field.path, fields.tokens[field.name].line + 1);
    if (parsed) break;
    const Complaint error =
        collector.errors.empty() ? Complaint{0, 0, "text that can't be read"} : collector.errors.front();
    if (!report_error(text, fields, error, result.faults)) break;
  }
  std::stable_sort(result.faults.begin(), result.faults.end(),
                   [](const Fault& a, const Fault& b) { return a.line < b.line; });
  return result;
}

}  // namespace gicube::emu
