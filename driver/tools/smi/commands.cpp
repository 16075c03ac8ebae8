// The commands that only ask the management plane.
#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include <iostream>
#include <iterator>

#include "client.h"
#include "local_boards.h"
#include "output.h"
#include "transport/pci_devices.h"

namespace gicube::smi {
namespace {

const char* state_of(const v1::BoardInfo& board) { return board.in_use() ? "in use" : "free"; }

// Prints JSON if that was requested, otherwise by print_text(message).
template <typename Message, typename PrintText>
int show(const Options& options, const Message& message, const PrintText& print_text) {
  if (options.json) {
    print(to_json(message));
  } else {
    print_text(message);
  }
  return 0;
}

void print_boards(const v1::ListBoardsResponse& boards) {
  Table table({{"BOARD", Align::kRight},
               {"OPEN WITH"},
               {"STATE"},
               {"FIDELITY"},
               {"BUS"},
               {"PROCESSORS", Align::kRight},
               {"LARGEST VOLUME", Align::kRight},
               {"CONFIGURATION"}});
  for (const v1::BoardInfo& board : boards.boards()) {
    const v1::BoardConfig& config = board.config();
    table.add({std::to_string(board.board()), board.bus_endpoint(), state_of(board),
               v1::FidelityLevel_Name(config.fidelity()), v1::BusModel_Name(config.bus().model()),
               std::to_string(config.asic().processors()), fmt::format("{}^3", config.asic().max_volume_voxels()),
               board.config_hash()});
  }
  fmt::print("{}", table.text());
}

void print_board(const v1::BoardInfo& board) {
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
}

void print_plan(const v1::FaultPlanInfo& plan) {
  if (plan.plan_text().empty()) return fmt::print("board {}: no fault plan\n", plan.board());
  fmt::print("board {}: {} faults so far, in {} messages down and {} up, by this plan:\n{}{}", plan.board(),
             plan.faults(), plan.messages_down(), plan.messages_up(), plan.plan_text(),
             plan.plan_text().ends_with('\n') ? "" : "\n");
}

// The log as a plan, one fault per line.
void print_log(const v1::FaultLog& log) {
  if (log.faults().empty()) fmt::print("# board {}: no fault has happened\n", log.board());
  google::protobuf::TextFormat::Printer printer;
  printer.SetSingleLineMode(true);
  for (const v1::PlannedFault& fault : log.faults()) {
    std::string text;
    printer.PrintToString(fault, &text);
    fmt::print("fault {{ {}}}\n", text);
  }
  if (log.left_out() > 0) fmt::print("# {} more have happened, for which the log has no room\n", log.left_out());
}

int set_plan(const Options& options, const std::string& text) {
  v1::SetFaultPlanRequest request;
  request.set_plan_text(text);
  return show(options, Client(options).call(&Stub::SetFaultPlan, request), print_plan);
}

void print_trace(const v1::TraceInfo& trace) {
  fmt::print("board {} writes {}\n", trace.board(), trace.file().empty() ? "no trace" : "its trace to " + trace.file());
}

v1::TraceInfo set_trace(Client& client, const std::string& file) {
  v1::SetTraceRequest request;
  request.set_file(file);
  return client.call(&Stub::SetTrace, request);
}

}  // namespace

int list(const Options& options) {
  // A guest has PCI functions and no board process.
  const bool has_process = !options.management.empty() || !local_processes().empty();
  if (!has_process && !pci_devices().empty()) return overview(options);
  return show(options, Client(options).call(&Stub::ListBoards), print_boards);
}

int info(const Options& options) { return show(options, Client(options).call(&Stub::GetInfo), print_board); }

int reset(const Options& options) {
  return show(options, Client(options).call(&Stub::Reset), [](const v1::BoardInfo& board) {
    fmt::print("board {} is reset and {}\n", board.board(), state_of(board));
  });
}

int show_faults(const Options& options) { return show(options, Client(options).call(&Stub::GetFaultPlan), print_plan); }
int set_faults(const Options& options) {
  const bool from_input = options.plan_file == "-";
  return set_plan(options, from_input ? std::string(std::istreambuf_iterator<char>(std::cin), {})
                                      : read_file("faults set", options.plan_file));
}
int clear_faults(const Options& options) { return set_plan(options, ""); }

int log_faults(const Options& options) {
  v1::GetFaultLogRequest request;
  request.set_clear(options.clear_log);
  return show(options, Client(options).call(&Stub::GetFaultLog, request), print_log);
}

int show_trace(const Options& options) { return show(options, Client(options).call(&Stub::GetTrace), print_trace); }

int start_trace(const Options& options) {
  Client client(options);
  if (options.trace_file.empty()) throw UsageError("trace start: expected the name of a file, got an empty one");
  return show(options, set_trace(client, options.trace_file), print_trace);
}

int stop_trace(const Options& options) {
  Client client(options);
  const v1::TraceInfo before = client.call(&Stub::GetTrace);
  return show(options, set_trace(client, ""), [&before](const v1::TraceInfo& now) {
    if (before.file().empty()) return print_trace(now);
    fmt::print("board {}: {} is complete; open it in ui.perfetto.dev\n", now.board(), before.file());
  });
}

int checkpoint(const Options& options) {
  Client client(options);
  v1::SaveCheckpointRequest request;
  request.set_file(options.checkpoint_file);
  return show(options, client.call(&Stub::SaveCheckpoint, request), [](const v1::CheckpointInfo& saved) {
    fmt::print("board {} at {} ps is in {}, {} bytes\n", saved.board(), saved.simulated_ps(), saved.file(),
               saved.bytes());
  });
}

}  // namespace gicube::smi
