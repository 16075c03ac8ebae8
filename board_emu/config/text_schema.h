// What a schema says, in words for fault messages.
#pragma once

#include <google/protobuf/descriptor.h>

#include <string>

namespace gicube::emu {

// "one of processors, block_voxels, ..."
inline std::string expected_names(const google::protobuf::Descriptor& type) {
  std::string names;
  for (int i = 0; i < type.field_count(); ++i) names += (i > 0 ? ", " : "one of ") + type.field(i)->name();
  return names;
}

// What a field takes: a whole number, one of an enumeration's names (0 is its "unspecified"), or a message.
inline std::string expected_value(const google::protobuf::FieldDescriptor& field) {
  if (field.message_type() != nullptr) return "a message in braces";
  if (field.cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_UINT64) {
    return "a whole number from 0 to 18446744073709551615";
  }
  if (field.enum_type() == nullptr) return "a whole number from 0 to 4294967295";
  std::string names;
  for (int i = 0; i < field.enum_type()->value_count(); ++i) {
    const auto* value = field.enum_type()->value(i);
    if (value->number() != 0) names += (names.empty() ? "one of " : ", ") + value->name();
  }
  return names;
}

}  // namespace gicube::emu
