#include "observe/observation.h"

#include <fmt/format.h>

#include <algorithm>

namespace gicube::emu {

namespace {

// Processes and threads of the trace; machine_trace.h has those of the machine.
constexpr Track kHost{1, 11}, kBusDown{2, 21}, kBusUp{2, 22}, kDsp{3, 31};

void name_tracks(TraceFile& trace) {
  trace.name_process(kHost.process, "host");
  trace.name_track(kHost, "waits for the board");
  trace.name_process(kBusDown.process, "host bus");
  trace.name_track(kBusDown, "down, to the board");
  trace.name_track(kBusUp, "up, to the host");
  trace.name_process(kDsp.process, "DSP");
  trace.name_track(kDsp, "commands");
}

}  // namespace

ObservationOptions for_board(const ObservationOptions& options, std::uint32_t board) {
  ObservationOptions own = options;
  for (std::string* file : {&own.trace_file, &own.vcd_file, &own.event_file}) {
    if (board > 0 && !file->empty()) *file += '.' + std::to_string(board);
  }
  return own;
}

Observation::Observation(const ObservationOptions& options, Debugger* debugger)
    : options_(options), debugger_(debugger) {
  if (debugger != nullptr) observers_.add(*debugger);
  if (!options.trace_file.empty()) {
    trace_.emplace(options.trace_file, options.trace_creation);
    name_tracks(*trace_);
    cycles_.emplace(*trace_, options.trace_window);
    observers_.add(*cycles_);
  }
  if (!options.vcd_file.empty()) {
    waveform_.emplace(options.vcd_file, options.vcd_window);
    observers_.add(*waveform_);
  }
  if (!options.event_file.empty()) event_file_.emplace(options.event_file);
  if (!options.observer_file.empty()) observer_.emplace(options.observer_file, options.is_boxed);
  if (event_file_ || observer_) {
    events_.emplace(options.events, [this](const gicube_event& event) {
      if (observer_) observer_->add(event);
      if (!event_file_) return;
      event_file_->add("{}\n", to_json(event));
      event_file_->end_record();
    });
    observers_.add(*events_);
  }
}

std::optional<ExplainedPixel> Observation::explained_pixel() {
  const auto& pixel = options_.events.life;
  if (!pixel) return std::nullopt;
  return ExplainedPixel{(*pixel)[0], (*pixel)[1],
                        [this](const PixelLife& life) { event_file_->add("{}\n", to_json(life)); }};
}

void Observation::power_up(const v1::BoardConfig& config) {
  end_command();
  config_ = config;
  if (debugger_ != nullptr) debugger_->power_up(config.asic().core_khz(), config.fidelity() == v1::cycle);
  if (trace_) {
    origin_ps_ = host_free_ps_ = cycles_free_ps_ = trace_->latest();
    trace_->instant(kDsp, "power-up", origin_ps_);
    cycles_->power_up(origin_ps_, config_);
    trace_->complete();
  }
  if (waveform_) {
    waveform_->end_machine();
    waveform_->set_clock(config.asic().core_khz());
  }
  if (event_file_) event_file_->flush();
}

void Observation::host_waited(const char* what, Picoseconds begin, Picoseconds end) {
  if (!trace_) return;
  const Picoseconds from = std::max(origin_ps_ + begin, host_free_ps_), to = origin_ps_ + end;
  if (to <= from) return;
  trace_->slice(kHost, what, from, to, "");
  host_free_ps_ = to;
}

void Observation::transferred(const BusDelivery& delivery) {
  if (!trace_) return;
  trace_->slice(delivery.direction == BusDirection::kDown ? kBusDown : kBusUp,
                kCargoNames[static_cast<std::size_t>(delivery.cargo)], origin_ps_ + delivery.begin_ps,
                origin_ps_ + delivery.time_ps, fmt::format(R"("bytes":{})", delivery.bytes));
  cycles_->transferred(delivery.direction == BusDirection::kDown, origin_ps_ + delivery.begin_ps,
                       origin_ps_ + delivery.time_ps, delivery.bytes);
}

void Observation::served(const BusTransaction& transaction, Picoseconds begin, Picoseconds end) {
  if (!trace_ || end == begin) return;
  constexpr Picoseconds kMillisecond = 1'000'000'000;
  const std::uint64_t khz = config_.asic().core_khz();
  // Rounds to the nearest cycle, because asic_ps was rounded down.
  const std::uint64_t cycles = transaction.asic_ps / kMillisecond * khz +
                               (transaction.asic_ps % kMillisecond * khz + kMillisecond / 2) / kMillisecond;
  trace_->slice(kDsp, transaction.name, origin_ps_ + begin, origin_ps_ + end,
                fmt::format(R"("dsp_cycles":{},"core_cycles":{})", transaction.dsp_cycles, cycles));
  cycles_->served(origin_ps_ + begin, origin_ps_ + end,
                  cycles_to_ps(transaction.dsp_cycles, config_.dsp().clock_khz()));
}

std::string Observation::fault() const {
  const auto incomplete = [](const TextFile& file) {
    return "expected to write all of " + file.path() + ", but a write failed";
  };
  if (trace_ && !trace_->file().good()) return incomplete(trace_->file());
  if (waveform_ && !waveform_->file().good()) return incomplete(waveform_->file());
  if (event_file_ && !event_file_->good()) return incomplete(*event_file_);
  if (observer_) return observer_->fault();
  return {};
}

}  // namespace gicube::emu
