#include "output.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <stdexcept>

namespace gicube::smi {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

std::string scaled(double value, std::initializer_list<const char*> units) {
  auto unit = units.begin();
  while (value >= 1000 && unit + 1 != units.end()) {
    value /= 1000;
    ++unit;
  }
  if (unit == units.begin()) return fmt::format("{:.0f} {}", value, *unit);
  return fmt::format("{:.{}f} {}", value, value < 10 ? 2 : value < 100 ? 1 : 0, *unit);
}

std::string value_text(const Message& message, const FieldDescriptor& field) {
  std::string text;
  google::protobuf::TextFormat::PrintFieldValueToString(message, &field, -1, &text);
  return text;
}

void add_fields(const Message& message, const Message& defaults, const std::string& path, Table& table) {
  const auto& descriptor = *message.GetDescriptor();
  for (int i = 0; i < descriptor.field_count(); ++i) {
    const FieldDescriptor& field = *descriptor.field(i);
    const std::string name = path + field.name();
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      add_fields(message.GetReflection()->GetMessage(message, &field),
                 defaults.GetReflection()->GetMessage(defaults, &field), name + ".", table);
      continue;
    }
    const std::string value = value_text(message, field), usual = value_text(defaults, field);
    table.add({name, value, value == usual ? "" : "(default " + usual + ")"});
  }
}

}  // namespace

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (const Column& column : columns_) widths.push_back(column.title.size());
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  const auto add_line = [&](const auto& cell) {
    std::string line;
    for (std::size_t i = 0; i < widths.size(); ++i) {
      if (i > 0) line += "  ";
      line += columns_[i].align == Align::kLeft ? fmt::format("{:<{}}", cell(i), widths[i])
                                                : fmt::format("{:>{}}", cell(i), widths[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  };
  add_line([this](std::size_t i) { return columns_[i].title; });
  for (const auto& row : rows_) add_line([&row](std::size_t i) { return row[i]; });
  return text;
}

std::string bytes_text(double bytes) { return scaled(bytes, {"B", "kB", "MB", "GB", "TB"}); }
std::string time_text(double picoseconds) { return scaled(picoseconds, {"ps", "ns", "us", "ms", "s"}); }

std::string configuration_text(const v1::BoardConfig& config) {
  Table table({{"FIELD"}, {"VALUE"}, {""}});
  add_fields(config, v1::BoardConfig::default_instance(), "", table);
  return table.text();
}

nlohmann::ordered_json to_json(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(message, &text, options);
  if (!status.ok()) throw std::runtime_error("the answer can't be written as JSON: " + std::string(status.message()));
  return nlohmann::ordered_json::parse(text);
}

nlohmann::ordered_json to_json(const v1::CounterSnapshot& snapshot) {
  nlohmann::ordered_json counters = nlohmann::ordered_json::object();
  for (const v1::Counter& counter : snapshot.counters()) counters[counter.name()] = counter.value();
  return {{"board", snapshot.board()}, {"simulated_ps", snapshot.simulated_ps()}, {"counters", std::move(counters)}};
}

void print(const nlohmann::ordered_json& json) { fmt::print("{}\n", json.dump(2)); }

}  // namespace gicube::smi
