#include "observe/debugger.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "cycle/machine_counters.h"
#include "observe/machine_view.h"

namespace gicube::emu {

namespace {

constexpr std::chrono::milliseconds kCancelCheck{50};           // chosen: delay until a client that has left is noticed
constexpr std::size_t kMaxHistory = 200, kMaxHistories = 1000;  // chosen: lines per ray; rays

constexpr const char* kHelp =
    "break cycle N | time 12.5us | ray N | pixel X Y | voxel X Y Z | block X Y Z | queue P Q RAYS | overflow | trap |\n"
    "      conflict | counter NAME VALUE | command        breaks: lists them; delete N\n"
    "watch ray N | pixel X Y        keeps the history of rays that are made after this; a ray is also TICKET:N\n"
    "continue [SECONDS], step [cycle | sample | ray | command] [N], stop [SECONDS], detach\n"
    "where, why, parts, queue P [Q], cache P X Y Z, cache P set S, bank MEMORY DEVICE BANK, link, counters [BEGIN]\n"
    "ray N, history N, set ray N colour R G B | opacity N, checkpoint FILE\n";

// Error at levels where only the start and the end of a command can be observed.
constexpr const char* kNoCycles =
    "expected break command, step command, or break counter, which is checked at the end of a command: this level has "
    "no cycles";

// The time limit of `continue` or `stop`, at most a day.
std::chrono::seconds seconds_of(const std::vector<std::string>& words, std::chrono::seconds usual) {
  if (words.size() < 2) return usual;
  return std::chrono::seconds(std::min<std::uint64_t>(number_at(words, 1, "seconds"), 86'400));
}

}  // namespace

bool Debugger::attach() {
  const std::lock_guard lock(mutex_);
  return !is_attached_.exchange(true);
}

void Debugger::detach() {
  const std::lock_guard lock(mutex_);
  breakpoints_.clear();
  watched_.clear();
  histories_.clear();
  step_.reset();
  stops_soon_ = stops_at_command_ = pauses_at_cycle_end_ = false;
  goes_ = true;
  is_attached_ = false;
  changed_.notify_all();
}

void Debugger::let_go() {
  const std::lock_guard lock(mutex_);
  step_.reset();
  stops_soon_ = stops_at_command_ = false;
  goes_ = is_let_go_ = true;
  pauses_at_cycle_end_ = false;
  changed_.notify_all();
}

void Debugger::power_up(std::uint64_t core_khz, bool has_cycles) {
  const std::lock_guard lock(mutex_);
  has_cycles_ = has_cycles;
  clock_ = {0, 0, core_khz};
  commands_ = 0;
  machine_ = nullptr;
}

bool Debugger::offer(std::function<void()> job) {
  const std::lock_guard lock(mutex_);
  if (!is_paused_) return false;
  last_activity_ = std::chrono::steady_clock::now();
  job_ = std::move(job);
  changed_.notify_all();
  return true;
}

void Debugger::begin_command(Picoseconds begin, std::uint32_t ticket) {
  if (!is_attached()) return;
  Lock lock(mutex_);
  clock_.begin_ps = begin;
  clock_.begin_cycle = now_;
  is_first_run_ = true;
  is_let_go_ = false;
  machine_ = nullptr;
  ticket_ = ticket;
  ++commands_;
  const bool is_break = std::ranges::any_of(breakpoints_, &Breakpoint::on_command);
  if (!is_break && !std::exchange(stops_at_command_, false) && !(stops_soon_ && !has_cycles_)) return;
  pause(lock, now_, fmt::format("command {} begins, ticket {}", commands_, ticket));
}

void Debugger::counted(const std::vector<wire::Counter>& counters) {
  if (!is_attached() || has_cycles_) return;
  Lock lock(mutex_);
  machine_ = nullptr;
  for (Breakpoint& each : breakpoints_) {
    const auto why = each.on_counters ? each.on_counters(counters) : std::nullopt;
    if (!why) continue;
    each.on_counters = nullptr;  // its counter stays above the threshold
    return pause(lock, now_, fmt::format("break {} ({}): {}", each.number, each.text, *why));
  }
}

void Debugger::begins(Cycle now, Machine& machine) {
  const std::lock_guard lock(mutex_);
  machine_ = &machine;
  now_ = now;
  if (is_first_run_) clock_.begin_cycle = now;
  if (std::exchange(is_first_run_, false)) histories_.clear();  // ray numbers are those of the command
}

Cycle Debugger::next(Cycle from) {
  if (!is_attached()) return kNoCycle;
  const std::lock_guard lock(mutex_);
  if (stops_soon_ || pauses_at_cycle_end_) return from;
  Cycle first = kNoCycle;
  const auto check = [&](const Breakpoint& each) {
    if (each.on_cycle) first = std::min(first, std::max(from, each.cycle.value_or(from)));
  };
  if (step_) check(*step_);
  std::ranges::for_each(breakpoints_, check);
  return first;
}

void Debugger::see(Cycle now, const Machine& machine) {
  Lock lock(mutex_);
  now_ = now;
  if (!is_attached_) return;
  if (pauses_at_cycle_end_) return wait_while_paused(lock, Moment::kEndOfCycle);
  if (step_) {
    if (const auto why = step_->on_cycle(now, machine)) return pause(lock, now, *why);
  }
  for (Breakpoint& each : breakpoints_) {
    if (!each.on_cycle || (each.cycle && now < *each.cycle)) continue;
    const auto why = each.on_cycle(now, machine);
    if (!why) continue;
    // A counter above its threshold and a time in the past would be met in each further cycle.
    if (each.cycle || each.on_counters) each.on_cycle = nullptr;
    return pause(lock, now, fmt::format("break {} ({}): {}", each.number, each.text, *why));
  }
  if (stops_soon_) pause(lock, now, "stopped");
}

bool Debugger::watches(std::uint64_t ray, const wire::Ray& made) {
  if (!is_attached()) return false;
  const std::lock_guard lock(mutex_);
  const auto has_it = [&](const Breakpoint& each) {
    return each.watches && each.ticket.value_or(ticket_) == ticket_ && each.watches(ray, made);
  };
  return std::ranges::any_of(watched_, has_it) || std::ranges::any_of(breakpoints_, has_it);
}

void Debugger::happened(const RayEvent& event, const Machine& machine) {
  Lock lock(mutex_);
  if (!is_attached_) return;
  now_ = event.cycle;
  if (!histories_.contains(event.ray) && histories_.size() >= kMaxHistories) {
    const auto ended = std::ranges::find_if(histories_, [](const auto& each) { return !each.second.is_under_way; });
    if (ended != histories_.end()) histories_.erase(ended);
  }
  History& history = histories_[event.ray];
  history.lines.push_back(line_of(event));
  if (history.lines.size() > kMaxHistory) history.lines.pop_front();
  if (!event.is_carrier) {
    history.handle = event.handle;
    history.is_under_way = event.step != RayStep::kTaken && event.step != RayStep::kWaits;
  }
  for (const Breakpoint& each : breakpoints_) {
    if (!each.on_ray || each.ticket.value_or(ticket_) != ticket_) continue;
    if (const auto why = each.on_ray(event, machine)) {
      const std::string text = fmt::format("break {} ({}): {}", each.number, each.text, *why);
      return pause(lock, event.cycle, text, Moment::kInCycle);
    }
  }
}

void Debugger::pause(Lock& lock, Cycle now, const std::string& why, Moment moment) {
  if (is_let_go_) return;
  step_.reset();
  stops_soon_ = false;
  now_ = now;
  why_ = why;
  ++stops_;
  last_activity_ = std::chrono::steady_clock::now();
  wait_while_paused(lock, moment);
}

// Blocks the command's thread until the board is resumed.
void Debugger::wait_while_paused(Lock& lock, Moment moment) {
  is_paused_ = true;
  goes_ = pauses_at_cycle_end_ = false;
  changed_.notify_all();
  while (!goes_ && is_attached_ && std::chrono::steady_clock::now() < last_activity_ + max_pause_) {
    if (job_ && moment == Moment::kInCycle) {
      pauses_at_cycle_end_ = true;  // not all parts have ticked
      break;
    }
    if (job_) {
      std::exchange(job_, nullptr)();
    } else {
      changed_.wait_until(lock, last_activity_ + max_pause_);
    }
  }
  if (!pauses_at_cycle_end_) job_ = nullptr;
  is_paused_ = false;
  changed_.notify_all();
}

std::string Debugger::where() {
  reported_stops_ = stops_;
  if (!is_paused_) return "the board is not paused\n";
  const std::string at = machine_ == nullptr ? fmt::format("{} ps", clock_.begin_ps)
                                             : fmt::format("cycle {}, {} ps", now_, clock_.time(now_));
  return fmt::format("command {}, {}: {}\n", commands_, at, why_);
}

// `before`: number of stops before the wait.
std::string Debugger::wait_for_stop(Lock& lock, std::uint64_t before, std::chrono::seconds limit,
                                    const Cancelled& cancelled) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (stops_ == before && !cancelled() && std::chrono::steady_clock::now() < end) {
    changed_.wait_for(lock, kCancelCheck);
  }
  return stops_ != before ? where() : fmt::format("nothing has stopped the board for {} s\n", limit.count());
}

std::string Debugger::go(const Words& words, Lock& lock, const Cancelled& cancelled) {
  if (is_paused_ && reported_stops_ != stops_) return where();  // it paused by itself after the client's previous line
  std::chrono::seconds limit = kMaxContinue;
  const std::uint64_t before = stops_;
  if (words[0] == "step") {
    if (!is_paused_) throw std::invalid_argument("step: expected a paused board; use break or stop first");
    const std::string unit = words.size() > 1 ? words[1] : "cycle";
    const std::uint64_t count = words.size() > 2 ? number_at(words, 2, "a number of steps") : 1;
    if (unit == "command") {
      stops_at_command_ = true;
    } else {
      if (machine_ == nullptr) throw std::invalid_argument("step: expected a command in progress, or step command");
      step_ = step_of(unit, count, now_, *machine_);
    }
  } else {
    limit = seconds_of(words, kMaxContinue);
  }
  goes_ = true;
  changed_.notify_all();
  return wait_for_stop(lock, before, limit, cancelled);
}

const Debugger::History& Debugger::history_of(const Words& words, std::size_t at) const {
  const auto [ticket, ray] = ray_at(words, at);
  if (ticket.value_or(ticket_) != ticket_) {
    throw std::invalid_argument(
        fmt::format("ticket: expected that of the latest command, {}, got {}", ticket_, *ticket));
  }
  const auto found = histories_.find(ray);
  if (found != histories_.end()) return found->second;
  throw std::invalid_argument(fmt::format("ray {}: expected one that break or watch selected before it was made", ray));
}

void Debugger::add(Breakpoint breakpoint) {
  if (!has_cycles_ && !breakpoint.on_command && !breakpoint.on_counters) throw std::invalid_argument(kNoCycles);
  breakpoint.number = ++last_number_;
  breakpoints_.push_back(std::move(breakpoint));
}

std::string Debugger::answer_paused(const Words& words) {
  const std::string& what = words[0];
  if (machine_ == nullptr) throw std::invalid_argument(what + ": expected a command in progress at fidelity=cycle");
  if (what == "why") return why_nothing_moves(now_, *machine_);
  if (what == "counters") {
    std::vector<wire::Counter> counters;
    count(*machine_, counters);
    std::string out;
    for (const wire::Counter& each : counters) {
      if (words.size() < 2 || each.name.starts_with(words[1])) out += fmt::format("  {} {}\n", each.name, each.value);
    }
    return out;
  }
  if (what == "ray") {
    const History& history = history_of(words, 1);
    if (!history.is_under_way) return "  has ended\n";
    return words_of(machine_->rays()[history.handle]);
  }
  if (what == "set") {
    const History& history = history_of(words, 2);
    if (!history.is_under_way) throw std::invalid_argument("expected a ray in progress, got one that has ended");
    RayUnderWay& ray = machine_->rays()[history.handle];
    set_word(words, 3, ray);
    return words_of(ray);
  }
  return view_of(words, *machine_);
}

std::string Debugger::answer(const Words& words, Lock& lock, const Cancelled& cancelled) {
  const std::string& what = words[0];
  const Words rest(words.begin() + 1, words.end());
  if (what == "help") return kHelp;
  if (what == "where") return where();
  if (what == "continue" || what == "step") return go(words, lock, cancelled);
  if (what == "stop") {
    if (is_paused_) return where();
    stops_soon_ = stops_at_command_ = true;
    const std::string text = wait_for_stop(lock, stops_, seconds_of(words, std::chrono::seconds(5)), cancelled);
    if (is_paused_) stops_at_command_ = false;
    return is_paused_ ? text : "no command is in progress; the board will stop at the next one\n";
  }
  if (what == "break") {
    // The start of the command is needed to convert a time to a cycle.
    if (!rest.empty() && rest[0] == "time" && !is_paused_) {
      throw std::invalid_argument(
          "time: expected a board that is paused in a command; use break command or stop first");
    }
    add(parse_breakpoint(rest, clock_));
    return fmt::format("break {}: {}\n", breakpoints_.back().number, breakpoints_.back().text);
  }
  if (what == "watch") {
    Breakpoint watched = parse_breakpoint(rest, clock_);
    if (!watched.watches) throw std::invalid_argument("watch: expected ray N or pixel X Y");
    if (!has_cycles_) throw std::invalid_argument(kNoCycles);
    watched_.push_back(std::move(watched));
    return "watching " + watched_.back().text + '\n';
  }
  if (what == "breaks") {
    std::string out;
    for (const Breakpoint& each : breakpoints_) out += fmt::format("break {}: {}\n", each.number, each.text);
    return out.empty() ? "no breaks\n" : out;
  }
  if (what == "delete") {
    const std::uint64_t number = number_at(words, 1, "the number of a break");
    if (std::erase_if(breakpoints_, [number](const Breakpoint& each) { return each.number == number; }) > 0)
      return "\n";
    throw std::invalid_argument(fmt::format("expected the number of a break, got {}", number));
  }
  if (what == "history") {
    std::string out;
    for (const std::string& line : history_of(words, 1).lines) out += line;
    return out;
  }
  constexpr std::array kOfMachine{"why", "parts", "queue", "cache", "bank", "link", "counters", "ray", "set"};
  if (std::ranges::find(kOfMachine, what) == kOfMachine.end()) {
    throw std::invalid_argument(fmt::format("expected a command that help lists, got \"{}\"", what));
  }
  if (!is_paused_) throw std::invalid_argument(what + ": expected a paused board; use break or stop first");
  return answer_paused(words);
}

Debugger::Answer Debugger::carry_out(const std::string& line, const Cancelled& cancelled) {
  std::istringstream text(line.substr(0, line.find('#')));
  Words words;
  for (std::string word; text >> word;) words.push_back(word);
  Lock lock(mutex_);
  last_activity_ = std::chrono::steady_clock::now();
  if (words.empty()) return {"", false, is_paused_};
  try {
    std::string reply = answer(words, lock, cancelled);
    return {std::move(reply), false, is_paused_};
  } catch (const std::exception& error) {
    return {std::string(error.what()) + '\n', true, is_paused_};
  }
}

}  // namespace gicube::emu
