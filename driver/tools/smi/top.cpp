#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <string_view>

#include "client.h"
#include "output.h"

namespace gicube::smi {
namespace {

volatile std::sig_atomic_t interrupted = 0;

constexpr int kFewLines = 24;  // for a terminal of unknown height

int terminal_lines() {
  winsize size{};
  return ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0 ? size.ws_row : kFewLines;
}

// Changes between two samples; before the first one: since the board's reset.
class Window {
 public:
  Window(const v1::CounterSnapshot* before, const v1::CounterSnapshot& now) : now_(now) {
    // A board that was reset between the samples counts from 0 again.
    if (before != nullptr && before->simulated_ps() <= now.simulated_ps()) {
      begin_ps_ = before->simulated_ps();
      for (const v1::Counter& counter : before->counters()) begin_[counter.name()] = counter.value();
    }
  }

  double simulated_ps() const { return static_cast<double>(now_.simulated_ps() - begin_ps_); }
  std::uint64_t delta(const v1::Counter& counter) const {
    const auto found = begin_.find(counter.name());
    return found == begin_.end() || found->second > counter.value() ? counter.value() : counter.value() - found->second;
  }
  double delta(std::string_view name) const {
    for (const v1::Counter& counter : now_.counters()) {
      if (counter.name() == name) return static_cast<double>(delta(counter));
    }
    return 0;
  }
  double a_second(double count) const { return simulated_ps() > 0 ? count / (simulated_ps() * 1e-12) : 0; }
  std::string share(std::string_view busy) const {
    if (simulated_ps() <= 0) return "-";
    return fmt::format("{:.1f}%", std::min(100.0, 100 * delta(busy) / simulated_ps()));
  }

 private:
  const v1::CounterSnapshot& now_;
  std::uint64_t begin_ps_ = 0;
  std::map<std::string, std::uint64_t> begin_;
};

std::string summary(const v1::CounterSnapshot& now, const Window& window, bool is_first, double wall_seconds) {
  const double simulated = window.simulated_ps();
  std::string text = fmt::format("board {}: {} simulated since its reset", now.board(),
                                 time_text(static_cast<double>(now.simulated_ps())));
  if (!is_first) {
    text += fmt::format("; {} of that in the last {:.1f} s", time_text(simulated), wall_seconds);
  }
  const auto rate = [&](const char* bytes) { return bytes_text(window.a_second(window.delta(bytes))) + "/s"; };
  text += '\n';
  Table table({{""}, {"BUSY", Align::kRight}, {"RATE", Align::kRight}, {"AMOUNT", Align::kRight}});
  const auto bytes = [&](const char* name) { return bytes_text(window.delta(name)); };
  table.add({"bus down", window.share("bus.down.busy_ps"), rate("bus.down.bytes"), bytes("bus.down.bytes")});
  table.add({"bus up", window.share("bus.up.busy_ps"), rate("bus.up.bytes"), bytes("bus.up.bytes")});
  const double rays = window.delta("pipeline.rays");
  table.add({"DSP", window.share("dsp.busy_ps"), "", ""});
  table.add({"rays", "", fmt::format("{:.0f}/s", window.a_second(rays)), fmt::format("{:.0f}", rays)});
  const double samples = window.delta("pipeline.samples");
  table.add({"samples", "", fmt::format("{:.0f}/s", window.a_second(samples)), fmt::format("{:.0f}", samples)});
  return text + table.text();
}

std::string counters(const v1::CounterSnapshot& now, const Window& window, bool all, std::size_t max_lines) {
  Table table({{"COUNTER"},
               {"VALUE", Align::kRight},
               {"SINCE THEN", Align::kRight},
               {"PER SIMULATED SECOND", Align::kRight},
               {"UNIT"}});
  std::size_t lines = 0, left_out = 0;
  for (const v1::Counter& counter : now.counters()) {
    const std::uint64_t delta = window.delta(counter);
    if (delta == 0 && !all) continue;
    if (++lines > max_lines) {
      ++left_out;
      continue;
    }
    table.add({counter.name(), std::to_string(counter.value()), std::to_string(delta),
               fmt::format("{:.0f}", window.a_second(static_cast<double>(delta))), counter.unit()});
  }
  if (lines == 0) return "no counter has changed\n";
  return table.text() + (left_out > 0 ? fmt::format("... and {} more\n", left_out) : "");
}

}  // namespace

int top(const Options& options) {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  Client client(options);
  const char* const terminal = std::getenv("TERM");
  const bool has_codes = terminal != nullptr && std::string_view(terminal) != "dumb";
  const bool redraws = !options.json && options.count == 0 && ::isatty(STDOUT_FILENO) == 1 && has_codes;
  auto last = std::chrono::steady_clock::now();
  std::optional<v1::CounterSnapshot> before;
  std::uint32_t shown = 0;
  client.watch(options.interval_ms, [&](const v1::CounterSnapshot& now) {
    const auto time = std::chrono::steady_clock::now();
    if (options.json) {
      fmt::print("{}\n", to_json(now).dump());
    } else {
      const Window window(before ? &*before : nullptr, now);
      const std::string head = summary(now, window, !before, std::chrono::duration<double>(time - last).count());
      constexpr int kOtherLines = 10;
      const auto max_lines = redraws ? static_cast<std::size_t>(std::max(1, terminal_lines() - kOtherLines)) : 1000;
      // Moves to the first line and clears the rest, which does not flicker.
      fmt::print("{}{}\n{}",
                 redraws     ? "\033[H\033[J"
                 : shown > 0 ? "\n"
                             : "",
                 head, counters(now, window, options.all_counters, max_lines));
    }
    std::fflush(stdout);
    last = time;
    before = now;
    return ++shown != options.count && interrupted == 0;
  });
  return 0;
}

}  // namespace gicube::smi
