#include "configuration.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include "table.h"

namespace gicube::smi {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

std::string value_text(const Message& message, const FieldDescriptor& field) {
  const auto& reflection = *message.GetReflection();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM: return reflection.GetEnum(message, &field)->name();
    case FieldDescriptor::CPPTYPE_UINT32: return std::to_string(reflection.GetUInt32(message, &field));
    case FieldDescriptor::CPPTYPE_UINT64: return std::to_string(reflection.GetUInt64(message, &field));
    case FieldDescriptor::CPPTYPE_BOOL: return reflection.GetBool(message, &field) ? "true" : "false";
    case FieldDescriptor::CPPTYPE_STRING: return reflection.GetString(message, &field);
    default: return "?";
  }
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

std::string configuration_text(const v1::BoardConfig& config) {
  Table table({{"FIELD"}, {"VALUE"}, {""}});
  add_fields(config, v1::BoardConfig::default_instance(), "", table);
  return table.text();
}

std::string bus_name(const v1::BoardConfig& config) { return v1::BusModel_Name(config.bus().model()); }
std::string fidelity_name(const v1::BoardConfig& config) { return v1::FidelityLevel_Name(config.fidelity()); }

}  // namespace gicube::smi
