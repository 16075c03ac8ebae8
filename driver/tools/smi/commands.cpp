#include "commands.h"

#include <fmt/format.h>

#include "configuration.h"
#include "json.h"
#include "table.h"

namespace gicube::smi {
namespace {

const char* state_of(const v1::BoardInfo& board) { return board.in_use() ? "in use" : "free"; }

}  // namespace

int list(const Options& options) {
  const v1::ListBoardsResponse boards = Client(options).list();
  if (options.json) {
    print(to_json(boards));
    return 0;
  }
  Table table({{"BOARD", Align::kRight},
               {"OPEN WITH"},
               {"STATE"},
               {"FIDELITY"},
               {"BUS"},
               {"PROCESSORS", Align::kRight},
               {"LARGEST VOLUME", Align::kRight},
               {"CONFIGURATION"}});
  for (const v1::BoardInfo& board : boards.boards()) {
    const auto& asic = board.config().asic();
    table.add({std::to_string(board.board()), board.bus_endpoint(), state_of(board), fidelity_name(board.config()),
               bus_name(board.config()), std::to_string(asic.processors()),
               fmt::format("{}^3", asic.max_volume_voxels()), board.config_hash()});
  }
  fmt::print("{}", table.text());
  return 0;
}

int info(const Options& options) {
  const v1::BoardInfo board = Client(options).info();
  if (options.json) {
    print(to_json(board));
    return 0;
  }
  fmt::print("board {}: {}, version {}\n", board.board(), board.product(), board.version());
  fmt::print("open with      {}\n", board.bus_endpoint());
  fmt::print("state          {}\n", state_of(board));
  fmt::print("configuration  {}\n\n", board.config_hash());
  fmt::print("{}\n", configuration_text(board.config()));
  Table routines(
      {{"ROUTINE", Align::kRight}, {"NAME"}, {"DSP CYCLES", Align::kRight}, {"AT MOST", Align::kRight}, {"FROM"}});
  for (const v1::ScatteringRoutine& routine : board.routines()) {
    routines.add({std::to_string(routine.number()), routine.name(), std::to_string(routine.cycles()),
                  std::to_string(routine.cycle_budget()), routine.file().empty() ? "built in" : routine.file()});
  }
  if (!routines.empty()) fmt::print("{}", routines.text());
  return 0;
}

int reset(const Options& options) {
  const v1::BoardInfo board = Client(options).reset();
  if (options.json) {
    print(to_json(board));
  } else {
    fmt::print("board {} is reset and {}\n", board.board(), state_of(board));
  }
  return 0;
}

int trace(const Options& options) {
  Client client(options);
  if (options.trace_action == TraceAction::kStart && options.trace_file.empty()) {
    throw UsageError("trace start: expected the name of a file, got an empty one");
  }
  const v1::TraceInfo before = options.trace_action == TraceAction::kStop ? client.trace() : v1::TraceInfo{};
  const v1::TraceInfo now =
      options.trace_action == TraceAction::kShow
          ? client.trace()
          : client.set_trace(options.trace_action == TraceAction::kStart ? options.trace_file : "");
  if (options.json) {
    print(to_json(now));
  } else if (options.trace_action == TraceAction::kStop && !before.file().empty()) {
    fmt::print("board {}: {} is complete; open it in ui.perfetto.dev\n", now.board(), before.file());
  } else if (now.file().empty()) {
    fmt::print("board {} writes no trace\n", now.board());
  } else {
    fmt::print("board {} writes its trace to {}\n", now.board(), now.file());
  }
  return 0;
}

}  // namespace gicube::smi
