#include "audit.h"

#include <fmt/format.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace gicube::emu {
namespace {

constexpr std::array kNames{"connected", "refused", "unknown",    "forbidden",  "opened",
                            "resumed",   "forced",  "closed",     "configured", "reset",
                            "traced",    "saved",   "faults_set", "debugged",   "limit_reached"};

// Shortens the text to one printable line.
std::string printable(std::string_view text) {
  constexpr std::size_t kLongest = 300;  // chosen: length of a refusal message
  std::string out;
  for (const char c : text.substr(0, kLongest)) out += c < ' ' || c > '~' ? '?' : c;
  return out;
}

}  // namespace

Audit::Audit() : Audit(Options()) {}

Audit::Audit(const Options& options) : options_(options) {
  static_assert(kNames.size() == kEvents);
  for (Kind& kind : kinds_) kind = {.lines = options_.burst, .since = Clock::now()};
  if (options_.file.empty()) return;
  try {
    auto sink = std::make_shared<spdlog::sinks::rotating_file_sink_mt>(options_.file, options_.max_file_bytes, 1);
    file_ = std::make_shared<spdlog::logger>("audit", std::move(sink));
    file_->set_pattern("%Y-%m-%dT%H:%M:%S.%eZ %v", spdlog::pattern_time_type::utc);
    file_->flush_on(spdlog::level::info);
  } catch (const spdlog::spdlog_ex& error) {
    throw std::runtime_error(fmt::format("--audit-log: {}", error.what()));
  }
}

Audit::~Audit() = default;

// A token bucket: lines are refilled one by one, up to the burst.
bool Audit::takes_line(Kind& kind) const {
  const auto now = Clock::now();
  const auto earned = options_.refill.count() > 0 ? (now - kind.since) / options_.refill : 0;
  if (earned > 0) {
    kind.lines = static_cast<unsigned>(std::min<long>(options_.burst, earned + kind.lines));
    kind.since = now;
  }
  if (kind.lines == 0) return false;
  --kind.lines;
  return true;
}

void Audit::note(AuditEvent event, std::string_view who, std::string_view what) {
  const auto index = static_cast<std::size_t>(event);
  const std::lock_guard lock(mutex_);
  Kind& kind = kinds_[index];
  ++kind.count;
  if (!takes_line(kind)) {
    ++kind.left_out;
    return;
  }
  std::string line = fmt::format("{}: {}", kNames[index], printable(who));
  if (!what.empty()) line += ": " + printable(what);
  if (kind.left_out > 0) line += fmt::format(" ({} more left out)", std::exchange(kind.left_out, 0));
  if (file_) return file_->info(line);
  using enum AuditEvent;
  const bool is_worrying = event == kUnknown || event == kForbidden || event == kForced || event == kLimitReached;
  spdlog::log(is_worrying ? spdlog::level::warn : spdlog::level::info, line);
}

std::vector<Audit::Count> Audit::counts() const {
  std::vector<Count> counts;
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < kEvents; ++i) counts.push_back({kNames[i], kinds_[i].count});
  return counts;
}

}  // namespace gicube::emu
