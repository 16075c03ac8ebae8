#include "scene/program/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <string_view>

namespace gicube::samples {
namespace {

constexpr const char* kEraseLine = "\r\x1b[K";

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

}  // namespace

std::string time_left(double elapsed_seconds, std::uint32_t done, std::uint32_t all) {
  if (done == 0 || done >= all || elapsed_seconds < 2) return {};
  const auto seconds = std::llround(elapsed_seconds * (all - done) / done);
  if (seconds < 60) return fmt::format(", {} s left", seconds);
  if (seconds < 3600) return fmt::format(", {} min {} s left", seconds / 60, seconds % 60);
  return fmt::format(", {} h {} min left", seconds / 3600, seconds % 3600 / 60);
}

bool can_erase_lines(std::FILE* stream) {
  const char* const terminal = std::getenv("TERM");
  return ::isatty(::fileno(stream)) != 0 && terminal != nullptr && std::string_view(terminal) != "dumb";
}

void print_warning(const char* program, const std::string& text) {
  fmt::print(stderr, "{}{}: warning: {}\n", can_erase_lines(stderr) ? kEraseLine : "", program, text);
}

ProgressLine::ProgressLine(bool shown, std::FILE* stream) : stream_(stream), shown_(shown && can_erase_lines(stream)) {}

ProgressLine::~ProgressLine() { clear(); }

void ProgressLine::show(const std::string& what) {
  if (!shown_) return;
  std::fprintf(stream_, "%s%s", kEraseLine, what.c_str());
  std::fflush(stream_);
  dirty_ = true;
  percent_ = -1;
}

Progress ProgressLine::parts(const std::string& what) {
  if (!shown_) return {};
  show(what);
  return [this, what, start = Clock::now()](std::uint32_t done, std::uint32_t all) {
    const int percent = all == 0 ? 100 : static_cast<int>(std::uint64_t{done} * 100 / all);
    if (percent == percent_ && seconds_since(shown_at_) < 1) return;
    show(fmt::format("{} {}%{}", what, percent, time_left(seconds_since(start), done, all)));
    percent_ = percent;
    shown_at_ = Clock::now();
  };
}

void ProgressLine::clear() {
  if (!dirty_) return;
  std::fprintf(stream_, "%s", kEraseLine);
  std::fflush(stream_);
  dirty_ = false;
}

}  // namespace gicube::samples
