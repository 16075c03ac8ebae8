#include "scene/program/board_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <bit>
#include <fstream>
#include <vector>

#include "gicube/fidelity_levels.h"
#include "gicube/scene/error.h"
#include "gicube/v1/board_config.pb.h"
#include "scene/program/program.h"

namespace gicube::samples {

namespace {

OpenOptions open_options(const BoardOptions& options, const std::function<void()>& while_waiting) {
  OpenOptions how;
  how.watchdog = options.watchdog;
  how.while_waiting = while_waiting;
  return how;
}

void add_fields(const google::protobuf::Message& message, const std::string& path, std::vector<std::string>& fields) {
  std::vector<const google::protobuf::FieldDescriptor*> set;
  message.GetReflection()->ListFields(message, &set);
  for (const auto* field : set) {
    const std::string name = path + std::string(field->name());
    if (field->message_type() == nullptr) {
      fields.push_back(name);
    } else {
      add_fields(message.GetReflection()->GetMessage(message, field), name + '.', fields);
    }
  }
}

// The fields of the board's configuration that the options set. The board has accepted them.
std::vector<std::string> fields_set(const BoardOptions& options) {
  std::vector<std::string> fields;
  for (const std::string& setting : options.settings) fields.push_back(setting.substr(0, setting.find('=')));
  if (options.config.empty()) return fields;
  std::ifstream file(options.config);
  google::protobuf::io::IstreamInputStream text(&file);
  v1::BoardConfig config;
  if (google::protobuf::TextFormat::Parse(&text, &config)) add_fields(config, "", fields);
  return fields;
}

void warn_of_unmodelled(const BoardOptions& options, Fidelity level) {
  if (options.quiet || options.has_own_level) return;
  constexpr std::size_t kNamed = 3;  // chosen
  std::vector<std::string> idle = fields_set(options);
  std::erase_if(idle, [&](const std::string& field) { return is_modelled(1U << static_cast<unsigned>(level), field); });
  if (idle.empty()) return;
  const std::size_t named = std::min(idle.size(), kNamed);
  const std::string more = idle.size() > named ? fmt::format(" and {} more", idle.size() - named) : "";
  warn(fmt::format("{}{}: not modelled at the level {}; --fidelity cycle models what is set",
                   fmt::join(idle.begin(), idle.begin() + static_cast<std::ptrdiff_t>(named), ", "), more,
                   name_of(level)));
}

// Restores a running board. An emulated one starts from the checkpoint.
void restore_running(const BoardOptions& options, Board& board) {
  if (!options.restore.empty() && !options.board.starts_with("emu:")) board.restore(options.restore.string());
}

}  // namespace

Board open_board(const BoardOptions& options, const std::function<void()>& while_waiting) {
  const std::string uri = board_uri(options);
  try {
    Board board = Board::open(uri, open_options(options, while_waiting));
    restore_running(options, board);
    warn_of_unmodelled(options, board.info().fidelity);
    return board;
  } catch (const BadArgument& error) {
    throw UsageError(error.what());
  }
}

BoardGroup open_boards(const BoardOptions& options, const std::function<void()>& while_waiting) {
  const std::vector<std::string> uris = board_uris(options);
  GroupOptions how{.buses = options.own_buses ? HostBuses::kOwn : HostBuses::kShared,
                   .board = open_options(options, while_waiting)};
  try {
    BoardGroup boards = uris.size() == 1 ? BoardGroup::open(uris[0], how) : BoardGroup::open(uris, how);
    restore_running(options, boards.board(0));
    warn_of_unmodelled(options, boards.board(0).info().fidelity);
    return boards;
  } catch (const BadArgument& error) {
    throw UsageError(error.what());
  }
}

void warn_if_invisible(const Board& board, const Image& image) {
  if (const std::string why = board.why_invisible(image); !why.empty()) warn(why);
}

void check_renders(const Dims& dims, const BoardInfo& info, const std::string& source) {
  constexpr int kMaxEdge = 1024, kBricksMinor = 3;
  if (info.protocol_minor < kBricksMinor || info.max_volume_voxels < 2 * info.block_voxels) {
    return check_fits(dims, info, source);
  }
  if (*std::max_element(dims.begin(), dims.end()) <= kMaxEdge) return;
  throw InputError(source, fmt::format("at most {} voxels an edge", kMaxEdge),
                   fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]));
}

void check_fits(const Dims& dims, const BoardInfo& info, const std::string& source) {
  const int longest = *std::max_element(dims.begin(), dims.end());
  if (longest <= info.max_volume_voxels) return;
  const unsigned needed = std::bit_ceil(static_cast<unsigned>(longest));
  throw InputError(source,
                   fmt::format("at most {} voxels an edge, which this board holds (--set asic.max_volume_voxels={} "
                               "makes an emulated one larger)",
                               info.max_volume_voxels, needed),
                   fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]));
}

}  // namespace gicube::samples
