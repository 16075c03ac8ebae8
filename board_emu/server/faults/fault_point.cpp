#include "fault_point.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <tuple>
#include <utility>

#include <spdlog/spdlog.h>

namespace gicube::emu {

using v1::PlannedFault;

std::vector<Diagnostic> FaultPoint::set_plan(std::string_view text) {
  ParsedFaultPlan parsed = parse_fault_plan(text);
  if (!parsed.diagnostics.empty()) return std::move(parsed.diagnostics);
  const std::lock_guard lock(mutex_);
  plan_text_ = text;
  engine_ = FaultEngine(parsed.plan);
  slow_ = {};
  faults_ = 0;
  log_ = {};
  has_plan_ = parsed.plan.fault_size() > 0 || parsed.plan.random_size() > 0;
  return {};
}

void SavedFaults::state(Archive& archive) {
  std::vector<std::string> plan{plan_text};
  archive.texts("plan", plan);
  if (archive.loads()) {
    archive.expect(plan.size() == 1, "plan", "one text", plan.size());
    plan_text = plan.front();
  }
  archive("messages", counts.messages);
  archive.list("hits", counts.hits);
  archive("slow", slow);
  archive("faults", faults);
}

void FaultPoint::restore(const SavedFaults& saved) {
  const ParsedFaultPlan parsed = parse_fault_plan(saved.plan_text);
  if (!parsed.diagnostics.empty()) throw CheckpointFault("host.faults.plan: " + to_string(parsed.diagnostics));
  FaultEngine engine(parsed.plan);
  if (!engine.set_counts(saved.counts)) {
    throw CheckpointFault("host.faults.hits", "one number for each random part of the plan and direction",
                          std::to_string(saved.counts.hits.size()));
  }
  for (const SavedFaults::Slow& each : saved.slow) {
    if (each.messages > 0 && each.bytes_per_second == 0) {
      throw CheckpointFault("host.faults.slow", "1 or more bytes a second", "0");
    }
  }
  const std::lock_guard lock(mutex_);
  plan_text_ = saved.plan_text;
  engine_ = std::move(engine);
  slow_ = saved.slow;
  faults_ = saved.faults;
  has_plan_ = parsed.plan.fault_size() > 0 || parsed.plan.random_size() > 0;
}

FaultPoint::Log FaultPoint::log(bool clear) {
  Log sorted;
  {
    const std::lock_guard lock(mutex_);
    sorted = log_;
    if (clear) log_ = {};
  }
  std::ranges::sort(sorted.faults, {},
                    [](const PlannedFault& each) { return std::tuple(each.direction(), each.message()); });
  return sorted;
}

void FaultPoint::append_log_to(const std::string& path) {
  std::ofstream file;
  file.rdbuf()->pubsetbuf(nullptr, 0);  // unbuffered, so that lines written before a SIGKILL are in the file
  file.open(path, std::ios::app);
  if (!file) throw std::runtime_error(fmt::format("{}: {}", path, std::generic_category().message(errno)));
  const std::lock_guard lock(mutex_);
  file_ = std::move(file);
  file_name_ = path;
}

FaultAction FaultPoint::next(PlannedFault::Direction direction, std::size_t frame_bytes) {
  if (!has_plan_) return {};
  const std::lock_guard lock(mutex_);
  const auto fault = engine_.next(direction, frame_bytes);
  FaultAction action;
  if (fault) {
    ++faults_;
    log_one(*fault);
    action = act(*fault);
  }
  SavedFaults::Slow& slow = slow_[FaultEngine::lane(direction)];
  if (slow.messages > 0) {
    --slow.messages;
    action.pause += std::chrono::microseconds(frame_bytes * 1'000'000 / slow.bytes_per_second);
  }
  return action;
}

void FaultPoint::log_one(const PlannedFault& fault) {
  if (log_.faults.size() < max_logged_) {
    log_.faults.push_back(fault);
  } else {
    ++log_.left_out;
  }
  if (!file_.is_open() || !file_ || lines_ > max_lines_) return;
  const std::string line = lines_++ < max_lines_
                               ? to_text(fault)
                               : fmt::format("# more than {} faults: those from here on are missing", max_lines_);
  if (file_ << line + "\n") return;
  spdlog::error("{}: {}: faults from here on are missing", file_name_, std::generic_category().message(errno));
}

FaultAction FaultPoint::act(const PlannedFault& fault) {
  FaultAction action;
  switch (fault.kind()) {
    case PlannedFault::drop: action.drop = true; break;
    case PlannedFault::delay: action.pause = std::chrono::milliseconds(fault.delay_ms()); break;
    case PlannedFault::corrupt: action.flipped_bit = fault.bit(); break;
    case PlannedFault::duplicate: action.twice = true; break;
    case PlannedFault::hang: action.hang = true; break;
    case PlannedFault::link_loss: action.cut = true; break;
    case PlannedFault::kill: action.kill = true; break;
    case PlannedFault::slow:
      slow_[FaultEngine::lane(fault.direction())] = {fault.bytes_per_second(), fault.messages()};
      break;
    case PlannedFault::memory_detected: action.memory_error = MemoryError{fault.block(), fault.bit(), true}; break;
    case PlannedFault::memory_silent: action.memory_error = MemoryError{fault.block(), fault.bit(), false}; break;
    case PlannedFault::kind_unspecified: break;
  }
  return action;
}

}  // namespace gicube::emu
