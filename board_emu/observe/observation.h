// What a board shows of its inside while it works: a trace for Perfetto, a waveform for GTKWave and a file of events, each if asked
// for.
//
// The machine is seen through observer(). Time goes on in the trace where a power-up sets the board's time back to 0.
#pragma once

#include <optional>
#include <string>

#include "board/timeline.h"
#include "cycle/machine.h"
#include "observe/debugger.h"
#include "observe/events.h"
#include "observe/machine_trace.h"
#include "observe/observer_process.h"
#include "observe/observers.h"
#include "observe/trace_file.h"
#include "observe/waveform.h"

namespace gicube::emu {

struct ObservationOptions {
  std::string trace_file{};  // empty = none
  std::string vcd_file{};    // empty = none
  CycleWindow vcd_window{};
  CycleWindow trace_window{};   // of what the machine's cycles leave in the trace
  std::string event_file{};     // empty = none
  std::string observer_file{};  // a shared object (gicube/observer.h), which runs in a process of its own; empty = none
  bool is_boxed = true;         // that process
  Selection events{};
  Creation trace_creation = Creation::kReplaces;

  bool any() const { return !trace_file.empty() || !vcd_file.empty() || !event_file.empty() || !observer_file.empty(); }
};

// Board 0 writes the files as they are named, board i > 0 to FILE.i.
ObservationOptions for_board(const ObservationOptions& options, std::uint32_t board);

class Observation : public BoardObserver {
 public:
  // Opens the files; throws std::runtime_error that names the one that can't be.
  // `debugger`: sees the machine too; null for none. It must outlive this.
  explicit Observation(const ObservationOptions& options, Debugger* debugger = nullptr);

  const ObservationOptions& options() const { return options_; }

  void power_up(const v1::BoardConfig& config) override;
  Observer* observer() override { return observers_.empty() ? nullptr : &observers_; }
  bool places_cycles() const override { return cycles_.has_value() || wants_counters(); }
  bool wants_counters() const override { return debugger_ != nullptr && debugger_->is_attached(); }
  void counted(const std::vector<wire::Counter>& counters) override { debugger_->counted(counters); }
  void begin_command(Picoseconds begin, std::uint32_t ticket) override {
    if (debugger_ != nullptr) debugger_->begin_command(begin, ticket);
    if (!cycles_) return;
    // Only behind a command that broke off, whose turn is shorter than what was seen of it, is this not `begin`.
    cycles_->begin(std::max(origin_ps_ + begin, cycles_free_ps_), config_);
  }
  void end_command() override {
    if (event_file_) event_file_->flush();
    if (observer_) observer_->flush();
    if (!cycles_) return;
    cycles_->end();
    cycles_free_ps_ = cycles_->end_ps();
  }
  std::optional<ExplainedPixel> explained_pixel() override;
  void host_waited(const char* what, Picoseconds begin, Picoseconds end) override;
  void transferred(const BusDelivery& delivery) override;
  void served(const BusTransaction& transaction, Picoseconds begin, Picoseconds end) override;

  // Which of the files could not be written to its end; empty if all is well.
  std::string fault() const;

 private:
  const ObservationOptions options_;
  Debugger* const debugger_;
  v1::BoardConfig config_;
  std::optional<TraceFile> trace_;
  std::optional<MachineTrace> cycles_;
  std::optional<Waveform> waveform_;
  std::optional<TextFile> event_file_;
  std::optional<ObserverProcess> observer_;
  std::optional<Events> events_;
  Observers observers_;
  Picoseconds origin_ps_ = 0;  // of the board's time in the trace
  Picoseconds host_free_ps_ = 0;
  Picoseconds cycles_free_ps_ = 0;
};

}  // namespace gicube::emu
