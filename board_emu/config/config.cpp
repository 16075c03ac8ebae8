#include "config.h"

#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <utility>

#include "asic/memory_standards.h"
#include "gicube/fidelity_levels.h"
#include "words/sdram_map.h"

namespace gicube::emu {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

int line_of(const FieldLines& lines, std::string_view path) {
  const auto found = lines.find(path);
  return found == lines.end() ? 0 : found->second;
}

void fill_in(Message& message) {
  const Descriptor& type = *message.GetDescriptor();
  const Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor* field = type.field(i);
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      fill_in(*reflection.MutableMessage(&message, field));
    } else if (reflection.HasField(message, field)) {
      continue;
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
      reflection.SetEnum(&message, field, field->default_value_enum());
    } else {
      reflection.SetUInt32(&message, field, field->default_value_uint32());
    }
  }
}

// Reports all numbers out of the range in the schema, and all enumerations without a value.
void check_fields(const Message& message, const std::string& path, const FieldLines& lines,
                  std::vector<Diagnostic>& found) {
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message.GetDescriptor()->field(i);
    const std::string name = path + field.name();
    if (field.message_type() != nullptr) {
      check_fields(message.GetReflection()->GetMessage(message, &field), name + ".", lines, found);
    } else if (auto what = fault_of(message, field)) {
      found.push_back({name, std::move(what->expected), std::move(what->got), line_of(lines, name)});
    }
  }
}

// Checks conditions that involve several fields.
void check_fields_together(const v1::BoardConfig& config, const FieldLines& lines, std::vector<Diagnostic>& found) {
  const auto report = [&](const char* field, std::string expected, std::string got) {
    found.push_back({field, std::move(expected), std::move(got), line_of(lines, field)});
  };
  if (config.cache().tags() == v1::of_voxels) {
    if (config.cache().ways() != 1)
      report("cache.ways", "1 with cache.tags=of_voxels", std::to_string(config.cache().ways()));
    if (config.cache().write_policy() == v1::write_back)
      report("cache.write_policy", "combining or write_through with cache.tags=of_voxels", "write_back");
  }
  if (config.cache().irradiance() == v1::in_cells) {
    if (config.asic().datapath() == v1::wide)
      report("cache.irradiance", "with_voxels with asic.datapath=wide", "in_cells");
    if (config.asic().voxel_format() != v1::density)
      report("cache.irradiance", "with_voxels with asic.voxel_format=rgb or rgba", "in_cells");
    if (config.asic().irradiance_words() > 1)
      report("cache.irradiance", "with_voxels with asic.irradiance_words=3", "in_cells");
    if (config.cache().miss_packets() < 16) {  // voxels of a sample and their irradiance
      report("cache.miss_packets", "at least 16 with cache.irradiance=in_cells",
             std::to_string(config.cache().miss_packets()));
    }
  }
  // chosen: with shorter intervals, the channel would do little else.
  const std::uint32_t rdram = config.rdram().refresh_interval(), ddr = config.ddr().refresh_interval(),
                      sdram = config.sdram().refresh_interval();
  if (rdram > 0 && rdram < 64) report("rdram.refresh_interval", "0 or at least 64 tCYCLE", std::to_string(rdram));
  if (ddr > 0 && ddr < 32) report("ddr.refresh_interval", "0 or at least 32 clocks", std::to_string(ddr));
  if (sdram > 0 && sdram < 32) report("sdram.refresh_interval", "0 or at least 32 clocks", std::to_string(sdram));
  using sdram_map::kRankBytes;
  const std::uint64_t needed = sdram_map::kFramebuffer + config.dsp().framebuffer_mb() * std::uint64_t{1'000'000};
  if (config.sdram().ranks() * kRankBytes < needed) {
    report("sdram.ranks",
           fmt::format("at least {}, for dsp.framebuffer_mb = {}", (needed + kRankBytes - 1) / kRankBytes,
                       config.dsp().framebuffer_mb()),
           std::to_string(config.sdram().ranks()));
  }
  const std::uint32_t block = config.asic().block_voxels(), volume = config.asic().max_volume_voxels();
  if (fault_of(config.asic(), *v1::AsicConfig::descriptor()->FindFieldByName("max_volume_voxels"))) return;
  if (!std::has_single_bit(volume)) {
    report("asic.max_volume_voxels", "a power of two", std::to_string(volume));
  } else if (std::has_single_bit(block) && block <= 64 && volume < block) {
    report("asic.max_volume_voxels", fmt::format("at least asic.block_voxels, {} voxels", block),
           std::to_string(volume));
  }
}

void check_memory(const v1::BoardConfig& config, const FieldLines& lines, std::vector<Diagnostic>& found) {
  const dram::Standard memory = memory_standard(config);
  const std::uint32_t edge = config.asic().max_volume_voxels() / config.asic().block_voxels();
  const std::uint32_t processors = config.asic().processors();
  const std::uint32_t blocks =
      (edge * edge * edge + processors - 1) / processors * std::min(memory.sharing, processors);
  const auto devices = make_memory(config, static_cast<std::uint32_t>(blocks_in_memory(config, blocks)))->devices();
  if (devices <= memory.max_devices) return;
  found.push_back(
      {"asic.max_volume_voxels",
       fmt::format("a volume whose share of one {} channel fits its {} devices", memory.label, memory.max_devices),
       fmt::format("{}, which takes {}", config.asic().max_volume_voxels(), devices),
       line_of(lines, "asic.max_volume_voxels")});
}

}  // namespace

ParsedConfig parse_config(std::string_view text) {
  ParsedConfig parsed;
  static_cast<TextReading&>(parsed) = read_text(text, parsed.config);
  return parsed;
}

std::vector<Diagnostic> apply_override(v1::BoardConfig& config, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  const bool is_plain = std::ranges::all_of(
      assignment, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '.' || c == '=' || c == '-'; });
  if (equals == std::string_view::npos || equals == 0 || !is_plain) {
    return {{"", "FIELD=VALUE, such as asic.processors=8", fmt::format("\"{}\"", assignment)}};
  }
  std::string text;  // protobuf text, such as "asic{processors:8}"
  for (const char c : assignment.substr(0, equals)) text += c == '.' ? '{' : c;
  const auto depth = static_cast<std::size_t>(std::ranges::count(text, '{'));
  text.append(":").append(assignment.substr(equals + 1)).append(depth, '}');
  v1::BoardConfig set;
  TextReading reading = read_text(text, set);
  for (Diagnostic& each : reading.diagnostics) each.line = 0;
  if (reading.diagnostics.empty()) config.MergeFrom(set);
  return std::move(reading.diagnostics);
}

v1::BoardConfig resolve(const v1::BoardConfig& config) {
  v1::BoardConfig resolved = config;
  fill_in(resolved);
  if (wants_approximate(resolved)) resolved.set_fidelity(v1::cycle);
  return resolved;
}

std::vector<Diagnostic> check(const v1::BoardConfig& config, const FieldLines& lines) {
  std::vector<Diagnostic> found;
  check_fields(config, "", lines, found);
  check_fields_together(config, lines, found);
  if (found.empty() && config.fidelity() != v1::functional) check_memory(config, lines, found);
  return found;
}

std::string explained(const v1::BoardConfig& config) {
  std::string text;
  const unsigned level = 1U << (config.fidelity() - v1::functional);
  const auto explain = [&](const auto& self, const Message& message, const std::string& path) -> void {
    const auto& type = *message.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
      const FieldDescriptor& field = *type.field(i);
      const std::string name = path + std::string(field.name());
      if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        self(self, message.GetReflection()->GetMessage(message, &field), name + '.');
        continue;
      }
      if (!field.options().HasExtension(v1::source)) continue;
      const bool is_enum = field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM;
      const std::string value = is_enum ? message.GetReflection()->GetEnum(message, &field)->name()
                                        : std::to_string(message.GetReflection()->GetUInt32(message, &field));
      const std::string usual =
          is_enum ? field.default_value_enum()->name() : std::to_string(field.default_value_uint32());
      const std::uint32_t percent = field.options().GetExtension(v1::uncertainty);
      text += fmt::format("{:<32} {:<14} {:<28}  {}{}{}{}\n", name, value, field.options().GetExtension(v1::range),
                          is_modelled(level, name) ? "" : "not modelled at this level; ",
                          value == usual ? "" : "default " + usual + ": ", field.options().GetExtension(v1::source),
                          percent == 0 ? "" : fmt::format(", give or take {}%", percent));
    }
  };
  explain(explain, resolve(config), "");
  return text;
}

std::string config_text(const v1::BoardConfig& config) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(resolve(config), &text);
  return text;
}

std::uint64_t config_hash(const v1::BoardConfig& config) {
  v1::BoardConfig counted = resolve(config);
  counted.clear_threads();
  counted.clear_pace();
  // Hashes of boards with the usual prices are those of releases that had none.
  if (counted.energy().SerializeAsString() == resolve({}).energy().SerializeAsString()) counted.clear_energy();
  std::string text;
  google::protobuf::TextFormat::PrintToString(counted, &text);
  std::uint64_t hash = 0xCBF2'9CE4'8422'2325;  // FNV-1a's offset basis and prime
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x0000'0100'0000'01B3;
  return hash;
}

std::string config_hash_text(const v1::BoardConfig& config) { return fmt::format("{:016x}", config_hash(config)); }

}  // namespace gicube::emu
