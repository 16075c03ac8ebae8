// Records a board's activity: a trace for Perfetto, a waveform for GTKWave and a file of events, each only if
// requested.
//
// The machine is observed through observer(). A power-up sets the board's time to 0; time in the trace continues.
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
  CycleWindow trace_window{};   // cycles of the machine that the trace contains
  std::string event_file{};     // empty = none
  std::string observer_file{};  // shared object (gicube/observer.h), run in its own process; empty = none
  bool is_boxed = true;         // whether that process is sandboxed
  Selection events{};
  Creation trace_creation = Creation::kReplaces;

  bool any() const { return !trace_file.empty() || !vcd_file.empty() || !event_file.empty() || !observer_file.empty(); }
};

// Returns the options of one board: board 0 writes to FILE, board i > 0 to FILE.i.
ObservationOptions for_board(const ObservationOptions& options, std::uint32_t board);

class Observation : public BoardObserver {
 public:
  // Opens the files. Throws std::runtime_error, which names the file that cannot be opened.
  // `debugger`: also observes the machine; null: none. It must outlive this.
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
    // Later than `begin` only after an aborted command, which takes less time than the cycles recorded of it.
    cycles_->begin(std::max(origin_ps_ + begin, cycles_free_ps_));
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

  // States which file could not be written completely, or the observer's fault; empty: neither.
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
  Picoseconds origin_ps_ = 0;  // time in the trace at which the board's time is 0
  Picoseconds host_free_ps_ = 0;
  Picoseconds cycles_free_ps_ = 0;
};

}  // namespace gicube::emu
