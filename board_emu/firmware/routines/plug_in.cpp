#include "firmware/routines/plug_in.h"

#include <algorithm>
#include <chrono>
#include <thread>

namespace gicube::emu {

static_assert(kMaxParameters == wire::kMaterialParameters);

namespace {

constexpr const char* kLost = "its process was ended; it is not called again until the board process is restarted";

// Number of checks before a side sleeps, if there is a processor for each side. chosen: tens of microseconds, within
// which most rays reach their next call.
constexpr unsigned kSpins = 1000;

void put_event(const ScatterEvent& event, CallSlot::Event& to) {
  gicube_bsdf_event out{};
  out.size = sizeof out;
  out.tag = event.tag;
  std::copy(event.position.begin(), event.position.end(), out.position);
  std::copy(event.direction.begin(), event.direction.end(), out.direction);
  std::copy(event.normal.begin(), event.normal.end(), out.normal);
  out.opacity = event.opacity;
  out.density = event.density;
  std::copy(event.random.begin(), event.random.end(), out.random);
  out.lighting = event.lighting ? 1 : 0;
  out.generation = event.generation;
  out.parameter_count = static_cast<std::uint32_t>(event.parameters.size());
  to.event = out;
  std::copy(event.parameters.begin(), event.parameters.end(), to.parameters);
}

ScatterAnswer answer_of(gicube_bsdf_answer answer) {
  return {{answer.direction[0], answer.direction[1], answer.direction[2]}, answer.passes, answer.cycles};
}

}  // namespace

// Reserves a slot for a call of this thread. A thread prefers its last slot, whose memory is still in the cache.
class PlugIn::Claim {
 public:
  explicit Claim(const PlugIn& of) : of_(of) {
    thread_local std::size_t last = 0;
    for (std::size_t tried = 0; of_.slot_states_[last].is_taken.exchange(true); last = (last + 1) % kMaxCalls) {
      if (++tried % kMaxCalls == 0) std::this_thread::yield();
    }
    index_ = last;
  }
  ~Claim() {
    if (!is_lost_) of_.slot_states_[index_].is_taken = false;
  }
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

  std::size_t index() const { return index_; }
  CallSlot& slot() const { return of_.process_.memory().slots[index_]; }
  void lose() { is_lost_ = true; }  // keeps the slot reserved, because a process that did not end may still write to it

 private:
  const PlugIn& of_;
  std::size_t index_;
  bool is_lost_ = false;
};

std::optional<std::string> fault(const RoutineDescription& description) {
  const auto expected = [](const std::string& field, const std::string& range, std::uint64_t got) {
    return field + ": expected " + range + ", got " + std::to_string(got);
  };
  if (description.abi != GICUBE_BSDF_ABI) return expected("abi", std::to_string(GICUBE_BSDF_ABI), description.abi);
  if (description.size < sizeof(gicube_bsdf)) {
    return expected("size", "at least " + std::to_string(sizeof(gicube_bsdf)), description.size);
  }
  if (description.name[0] == '\0') return "name: expected a text, got none";
  if (description.has_scatter == 0) return "scatter: expected a function, got null";
  if (description.cycle_budget < 1) return expected("cycle_budget", "at least 1", description.cycle_budget);
  if (description.cycles < 1 || description.cycles > description.cycle_budget) {
    return expected("cycles", "1.." + std::to_string(description.cycle_budget), description.cycles);
  }
  return std::nullopt;
}

std::unique_ptr<PlugIn> PlugIn::load(const std::string& file, bool is_boxed) {
  return std::unique_ptr<PlugIn>(new PlugIn(file, is_boxed));
}

PlugIn::PlugIn(const std::string& file, bool is_boxed)
    : process_(PlugInProcess::Kind::kRoutine, file, is_boxed),
      description_(process_.memory().loading.description),
      name_(printable(description_.name, kMaxName)),
      file_(file) {
  if (const auto what = emu::fault(description_)) throw PlugInFault(file + ": " + *what);
}

bool PlugIn::order(SlotOrder::Kind kind, std::size_t slot) const {
  const SlotOrder order{kind, static_cast<std::uint32_t>(slot)};
  return process_.send(&order, sizeof order);
}

std::optional<std::string> PlugIn::call(Claim& claim, CallKind kind, std::uint32_t count) const {
  using Waited = PlugInProcess::Waited;
  CallSlot& slot = claim.slot();
  slot.call = kind;
  slot.count = count;
  static const unsigned processors = std::thread::hardware_concurrency();
  const auto number = static_cast<unsigned>(claim.index() + 1);
  if (number > at_once_) at_once_ = number;  // a hint: two threads may overwrite each other's value
  const unsigned spins = 2 * at_once_ <= processors ? kSpins : 0;
  slot.spins = spins;
  if (!slot.turn.give(Party::kBoard, Party::kPlugIn)) {
    slot.turn.give(Party::kPlugIn);
    if (!order(SlotOrder::Kind::kBegin, claim.index())) {
      slot.turn.give(Party::kNobody);
      return kLost;
    }
  }
  switch (process_.wait(slot.turn, slot.process, spins, slot_states_[claim.index()].patience, count)) {
    case Waited::kAnswered: return std::nullopt;
    case Waited::kEnded: return end_of(slot.wait_status);
    case Waited::kLost: slot.turn.give(Party::kNobody); return kLost;
    case Waited::kStuck: break;
  }
  order(SlotOrder::Kind::kEnd, claim.index());
  const auto end = std::chrono::steady_clock::now() + PlugInProcess::kRoutinePatience;
  while (slot.turn.now() != Party::kNobody && !process_.has_gone()) {
    if (std::chrono::steady_clock::now() > end) {
      claim.lose();
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return stuck();
}

std::optional<std::string> PlugIn::fault(std::span<const float> parameters) const {
  if (description_.has_check == 0) return std::nullopt;
  Claim claim(*this);
  CallSlot& slot = claim.slot();
  slot.events[0].event.parameter_count = static_cast<std::uint32_t>(parameters.size());
  std::copy(parameters.begin(), parameters.end(), slot.events[0].parameters);
  if (auto what = call(claim, CallKind::kCheck, 1)) return what;
  if (slot.has_thrown != 0) return "its parameter check threw an exception";
  if (slot.verdict == 0) return std::nullopt;
  const std::string text = printable(slot.text, kMaxText);
  return text.empty() ? "it refuses its parameters without a reason" : text;
}

void PlugIn::scatter(std::span<const ScatterEvent> events, std::span<ScatterAnswer> answers) const {
  for (std::size_t first = 0; first < answers.size(); first += kMaxEvents) {
    const auto count = static_cast<std::uint32_t>(std::min(kMaxEvents, answers.size() - first));
    Claim claim(*this);
    CallSlot& slot = claim.slot();
    for (std::uint32_t i = 0; i < count; ++i) put_event(events[first + i], slot.events[i]);
    if (const auto what = call(claim, CallKind::kScatter, count)) throw RoutineFault(*what);
    for (std::uint32_t i = 0; i < count; ++i) answers[first + i] = answer_of(slot.answers[i]);
    if (slot.has_thrown == 0) continue;
    const std::string text = printable(slot.text, kMaxText);
    throw RoutineFault(text.empty() ? "threw an exception" : "threw an exception: " + text);
  }
  const std::uint32_t budget = description_.cycle_budget;
  for (const ScatterAnswer& answer : answers) {
    if (answer.cycles >= 1 && answer.cycles <= budget) continue;
    throw RoutineFault("cycles: expected 1.." + std::to_string(budget) + ", got " + std::to_string(answer.cycles));
  }
}

}  // namespace gicube::emu
