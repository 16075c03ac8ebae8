#include "config.h"

#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "asic/memory_standards.h"
#include "text_schema.h"

namespace gicube::emu {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

struct Range {
  const char* field;
  std::uint32_t low;
  std::uint32_t high;
  const char* unit;
};

// The ranges of board_config.proto's comments.
constexpr std::array kRanges{
    Range{"asic.processors", 1, 16, "processors"}, Range{"asic.max_volume_voxels", 32, 1024, "voxels"},
    Range{"asic.queue_rays", 1, 4096, "rays"}, Range{"asic.core_khz", 1'000, 1'000'000, "kHz"},
    Range{"dsp.clock_khz", 1'000, 2'000'000, "kHz"},
    // chosen: keeps the picoseconds of the largest image at the slowest clock within 64 bits.
    Range{"dsp.viewing_ray_cycles", 0, 10'000, "DSP cycles"}, Range{"dsp.returned_ray_cycles", 0, 10'000, "DSP cycles"},
    Range{"dsp.host_ray_cycles", 0, 10'000, "DSP cycles"}, Range{"dsp.overflow_ray_cycles", 0, 10'000, "DSP cycles"},
    Range{"dsp.lighting_ray_cycles", 0, 10'000, "DSP cycles"}, Range{"dsp.run_rays", 0, 4096, "rays"},
    Range{"dsp.run_cycles", 0, 10'000, "DSP cycles"}, Range{"dsp.framebuffer_mb", 1, 1024, "MB"},
    Range{"pipeline.prefetch_stages", 1, 256, "core cycles"}, Range{"pipeline.compute_stages", 1, 256, "core cycles"},
    Range{"cache.miss_packets", 8, 1024, "packets"}, Range{"cache.write_packets", 32, 1024, "packets"},
    Range{"link.rays", 2, 64, "rays"}, Range{"rdram.processors_per_rdram", 1, 2, "processors"},
    Range{"rdram.clocks_per_core_cycle", 1, 16, "tCYCLE"}, Range{"rdram.t_ras", 1, 255, "tCYCLE"},
    Range{"rdram.t_rp", 1, 255, "tCYCLE"}, Range{"rdram.t_rr", 4, 255, "tCYCLE"}, Range{"rdram.t_pp", 4, 255, "tCYCLE"},
    Range{"rdram.t_rcd", 1, 255, "tCYCLE"}, Range{"rdram.t_cac", 1, 255, "tCYCLE"},
    Range{"rdram.t_cwd", 1, 255, "tCYCLE"}, Range{"rdram.t_rtr", 0, 255, "tCYCLE"},
    Range{"rdram.t_offp", 1, 255, "tCYCLE"}, Range{"rdram.refresh_interval", 0, 1'000'000, "tCYCLE"},
    Range{"rdram.rac_latency", 0, 255, "tCYCLE"}, Range{"ddr.processors_per_channel", 1, 2, "processors"},
    Range{"ddr.clocks_per_core_cycle", 1, 16, "clocks"}, Range{"ddr.t_ras", 1, 255, "clocks"},
    Range{"ddr.t_rc", 1, 255, "clocks"}, Range{"ddr.t_rp", 1, 255, "clocks"}, Range{"ddr.t_rrd", 1, 255, "clocks"},
    Range{"ddr.t_rcd", 1, 255, "clocks"}, Range{"ddr.t_cl", 1, 255, "clocks"}, Range{"ddr.t_wr", 0, 255, "clocks"},
    Range{"ddr.t_wtr", 0, 255, "clocks"}, Range{"ddr.t_rfc", 1, 255, "clocks"},
    Range{"ddr.refresh_interval", 0, 1'000'000, "clocks"}, Range{"ddr.controller_latency", 0, 255, "clocks"},
    Range{"ideal.memory", 0, 1, "(0 or 1)"}, Range{"ideal.queues", 0, 1, "(0 or 1)"},
    Range{"ideal.sorter", 0, 1, "(0 or 1)"}, Range{"bus.max_burst_dwords", 1, 1024, "dwords"},
    Range{"bus.latency_timer_clocks", 8, 255, "bus clocks"}, Range{"bus.read_latency_clocks", 0, 64, "bus clocks"},
    Range{"threads", 0, 1024, "threads, 0 = one a core"},  // chosen: above any host that this was tried on
};

struct Place {
  const Message* message;
  const FieldDescriptor* field;
};

// `path` must name a scalar of BoardConfig.
Place find_place(const v1::BoardConfig& config, std::string_view path) {
  const Message* message = &config;
  for (;;) {
    const std::size_t dot = path.find('.');
    const FieldDescriptor* field = message->GetDescriptor()->FindFieldByName(std::string(path.substr(0, dot)));
    if (dot == std::string_view::npos) return {message, field};
    message = &message->GetReflection()->GetMessage(*message, field);
    path.remove_prefix(dot + 1);
  }
}

std::uint32_t value_at(const v1::BoardConfig& config, std::string_view path) {
  const Place place = find_place(config, path);
  return place.message->GetReflection()->GetUInt32(*place.message, place.field);
}

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

void check_enums(const v1::BoardConfig& config, const FieldLines& lines, std::vector<Diagnostic>& found) {
  if (config.fidelity() == v1::approximate && config.sorter().queues() == v1::single) {
    found.push_back(
        {"fidelity", "functional or cycle with sorter.queues=single", "approximate", line_of(lines, "fidelity")});
  }
  for (const char* path : {"fidelity", "bus.model", "asic.partition", "asic.datapath", "sorter.queues", "sorter.policy",
                           "memory", "pace"}) {
    const Place place = find_place(config, path);
    const auto* value = place.message->GetReflection()->GetEnum(*place.message, place.field);
    if (value->number() != 0) continue;
    found.push_back({path, expected_value(*place.field), value->name(), line_of(lines, path)});
  }
}

void check_powers(const v1::BoardConfig& config, const FieldLines& lines, std::vector<Diagnostic>& found) {
  struct Power {
    const char* field;
    std::uint32_t high;
    const char* expected;
  };
  for (const Power& power :
       {Power{"cache.ways", 8, "1, 2, 4 or 8 ways"}, Power{"link.bits", 256, "a power of two from 1 to 256 bits"}}) {
    const std::uint32_t value = value_at(config, power.field);
    if (std::has_single_bit(value) && value <= power.high) continue;
    found.push_back({power.field, power.expected, std::to_string(value), line_of(lines, power.field)});
  }
  const std::uint32_t mbit = config.rdram().device_mbit();
  if (mbit != 144 && mbit != 288) {
    found.push_back(
        {"rdram.device_mbit", "144 or 288 Mbit", std::to_string(mbit), line_of(lines, "rdram.device_mbit")});
  }
}

void check_volume(const v1::AsicConfig& asic, const FieldLines& lines, std::vector<Diagnostic>& found) {
  const std::uint32_t block = asic.block_voxels(), volume = asic.max_volume_voxels();
  const bool block_is_good = block == 8 || block == 16 || block == 32 || block == 64;
  if (!block_is_good) {
    found.push_back(
        {"asic.block_voxels", "8, 16, 32 or 64 voxels", std::to_string(block), line_of(lines, "asic.block_voxels")});
  }
  if (volume < 32 || volume > 1024) return;  // reported with the other ranges
  const int line = line_of(lines, "asic.max_volume_voxels");
  if (!std::has_single_bit(volume)) {
    found.push_back({"asic.max_volume_voxels", "a power of two", std::to_string(volume), line});
  } else if (block_is_good && volume < block) {
    found.push_back({"asic.max_volume_voxels", fmt::format("at least asic.block_voxels, {} voxels", block),
                     std::to_string(volume), line});
  }
}

void check_memory(const v1::BoardConfig& config, const FieldLines& lines, std::vector<Diagnostic>& found) {
  const dram::Standard memory = memory_standard(config);
  const std::uint32_t edge = config.asic().max_volume_voxels() / config.asic().block_voxels();
  const std::uint32_t processors = config.asic().processors();
  const std::uint32_t blocks =
      (edge * edge * edge + processors - 1) / processors * std::min(memory.sharing, processors);
  const std::uint32_t devices = make_memory(config, blocks)->devices();
  if (devices <= memory.max_devices) return;
  found.push_back(
      {"asic.max_volume_voxels",
       fmt::format("a volume whose share of one {} channel fits its {} devices", memory.label, memory.max_devices),
       fmt::format("{}, which takes {}", config.asic().max_volume_voxels(), devices),
       line_of(lines, "asic.max_volume_voxels")});
}

void check_refresh(const v1::BoardConfig& config, const FieldLines& lines, std::vector<Diagnostic>& found) {
  struct Shortest {
    const char* field;
    std::uint32_t clocks;
    const char* unit;
  };
  // chosen: more often, and the channel does little else.
  for (const Shortest& shortest :
       {Shortest{"rdram.refresh_interval", 64, "tCYCLE"}, Shortest{"ddr.refresh_interval", 32, "clocks"}}) {
    const std::uint32_t value = value_at(config, shortest.field);
    if (value == 0 || value >= shortest.clocks) continue;
    found.push_back({shortest.field, fmt::format("0 or at least {} {}", shortest.clocks, shortest.unit),
                     std::to_string(value), line_of(lines, shortest.field)});
  }
}

}  // namespace

ParsedConfig parse_config(std::string_view text) {
  ParsedConfig parsed;
  TextReading reading = read_text(text, parsed.config);
  parsed.lines = std::move(reading.lines);
  parsed.diagnostics = std::move(reading.diagnostics);
  return parsed;
}

std::vector<Diagnostic> apply_override(v1::BoardConfig& config, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    return {{"", "field=value, as asic.processors=8", fmt::format("\"{}\"", assignment)}};
  }
  const std::string path(assignment.substr(0, equals)), value(assignment.substr(equals + 1));
  v1::BoardConfig changed = config;
  Message* message = &changed;
  for (std::string_view rest = path;;) {
    const std::size_t dot = rest.find('.');
    const std::string name(rest.substr(0, dot));
    const FieldDescriptor* field = message->GetDescriptor()->FindFieldByName(name);
    if (field == nullptr) {
      return {{path, expected_names(*message->GetDescriptor()), fmt::format("\"{}\"", name)}};
    }
    const bool is_message = field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
    if (dot == std::string_view::npos) {
      if (is_message) return {{path, "a field of it: " + expected_names(*field->message_type()), "the whole message"}};
      if (!read_value(value, *field, *message)) {
        return {{path, expected_value(*field), fmt::format("\"{}\"", value)}};
      }
      config = std::move(changed);
      return {};
    }
    if (!is_message) return {{path, fmt::format("\"{}\" to be the last name: it has no fields", name), path}};
    message = message->GetReflection()->MutableMessage(message, field);
    rest.remove_prefix(dot + 1);
  }
}

v1::BoardConfig resolve(const v1::BoardConfig& config) {
  v1::BoardConfig resolved = config;
  fill_in(resolved);
  return resolved;
}

std::vector<Diagnostic> check(const v1::BoardConfig& config, const FieldLines& lines) {
  std::vector<Diagnostic> found;
  check_enums(config, lines, found);
  for (const Range& range : kRanges) {
    const std::uint32_t value = value_at(config, range.field);
    if (value >= range.low && value <= range.high) continue;
    found.push_back({range.field, fmt::format("{} to {} {}", range.low, range.high, range.unit), std::to_string(value),
                     line_of(lines, range.field)});
  }
  check_powers(config, lines, found);
  check_refresh(config, lines, found);
  check_volume(config.asic(), lines, found);
  if (found.empty() && config.fidelity() != v1::functional) check_memory(config, lines, found);
  return found;
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
  std::string text;
  google::protobuf::TextFormat::PrintToString(counted, &text);
  std::uint64_t hash = 0xCBF2'9CE4'8422'2325;  // FNV-1a's offset basis and prime
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x0000'0100'0000'01B3;
  return hash;
}

std::string config_hash_text(const v1::BoardConfig& config) { return fmt::format("{:016x}", config_hash(config)); }

}  // namespace gicube::emu
