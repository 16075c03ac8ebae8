#include "board/board.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "board/parts.h"
#include "firmware/routines/routine_table.h"
#include "words/scope_exit.h"

namespace gicube::emu {

namespace {

using wire::ErrorCode;
using wire::FrameType;

bool posted(FrameType type) {
  return type == FrameType::kRegisterWrite || type == FrameType::kMemoryWrite || type == FrameType::kCommand;
}

const char* wait_name(FrameType type) {
  if (type == FrameType::kMemoryRead) return kReadMemory;
  return type == FrameType::kWait ? "wait" : "access register";
}

}  // namespace

Board::Board(const v1::BoardConfig& config, std::uint64_t config_hash, BoardObserver* observer,
             const Routines* routines, std::uint64_t max_memory_bytes)
    : parts_(std::make_unique<Parts>(config, config_hash, observer,
                                     routines != nullptr ? routines : &built_in_routines(), max_memory_bytes)) {
  publish(false);
}

Board::~Board() = default;

const v1::BoardConfig& Board::config() const { return parts_->config; }

void Board::state(Archive& archive, bool with_level) {
  if (archive.loads() && parts_->next_transaction != 1) {
    throw std::logic_error("checkpoint: expected a board on which nothing was done");
  }
  parts_->state(archive, with_level);
  if (archive.loads()) publish(false);
}

bool Board::in_command() const { return parts_->carried.has_value(); }

void Board::at_next_moment(std::function<void()> job) {
  const std::lock_guard lock(jobs_mutex_);
  jobs_.push_back(std::move(job));
  has_jobs_ = true;
}

void Board::do_jobs() {
  if (!has_jobs_.load(std::memory_order_relaxed)) return;
  std::vector<std::function<void()>> jobs;
  {
    const std::lock_guard lock(jobs_mutex_);
    jobs.swap(jobs_);
    has_jobs_ = false;
  }
  for (const auto& job : jobs) job();
}

bool Board::carry_out(const wire::FrameHeader& header, std::span<const std::uint8_t> payload, Progress& work) {
  work.may_count = [this] {
    if (parts_->power.is_due()) parts_->power.see(parts_->count());
    do_jobs();
    publish_if_asked();
  };
  const ScopeExit no_more{[&work] { work.may_count = nullptr; }};
  return parts_->command(header, payload, work);
}

void Board::set_minor_version(std::uint16_t minor) { parts_->card.minor_version = minor; }

void Board::go_on(Progress& work) {
  if (!parts_->carried) return;
  const auto rest = *std::exchange(parts_->carried, std::nullopt);
  carry_out(rest.header, rest.payload, work);
  publish(false);
}

void Board::add_memory_error(const MemoryError& error) {
  Progress work;
  go_on(work);
  parts_->card.add_memory_error(error);
}

std::uint64_t Board::held_bytes() const { return parts_->held_bytes(); }

TransactionResult Board::transact(const wire::FrameHeader& header, std::span<const std::uint8_t> payload,
                                  Progress& work) {
  go_on(work);
  TransactionResult outcome;
  if (header.time_ps > kEndOfTime) {
    parts_->registers.raise(wire::kStatusBadCommand, 0);
    outcome.reply =
        refusal_of(ErrorCode::kBadValue, fmt::format("time_ps: expected at most 2^62, got {}", header.time_ps));
    outcome.reply->time_ps = parts_->timeline.now();
    if (posted(header.type)) outcome.reply.reset();
    return outcome;
  }
  switch (header.type) {
    case FrameType::kConfigRead:
    case FrameType::kConfigWrite:
    case FrameType::kRegisterRead: outcome.reply = parts_->transact_word(header, payload); break;
    case FrameType::kRegisterWrite: parts_->transact_word(header, payload); return outcome;
    case FrameType::kMemoryWrite: parts_->write_memory(header, payload); return outcome;
    case FrameType::kMemoryRead: outcome.reply = parts_->read_memory(header, payload); break;
    case FrameType::kCommand: outcome.ticket_in_use = !carry_out(header, payload, work); break;
    case FrameType::kWait: outcome.reply = parts_->wait(payload); break;
    case FrameType::kCancel: outcome.reply = parts_->cancel(header, payload); break;
    case FrameType::kPoll:
    case FrameType::kCounters: {
      parts_->timeline.advance(header.time_ps);
      outcome.reply = Reply{.time_ps = header.time_ps};
      if (header.type == FrameType::kCounters) outcome.reply->payload = wire::encode(parts_->count_with_energy());
      break;
    }
    default: outcome.reply = refusal_of(ErrorCode::kUnsupported, "no such transaction"); break;
  }
  if (outcome.reply) {
    outcome.completions = parts_->take_completions();
    const bool passed = outcome.reply->error == ErrorCode::kDeadline;
    if (outcome.reply->error != ErrorCode::kNone && !passed) outcome.reply->time_ps = header.time_ps;
    if (parts_->observer != nullptr) {
      parts_->observer->host_waited(wait_name(header.type), header.time_ps, outcome.reply->time_ps);
    }
  }
  publish(is_asked_.exchange(false) || is_watched_);
  is_watched_ = false;
  return outcome;
}

Board::Snapshot Board::snapshot() const {
  is_asked_.store(true, std::memory_order_relaxed);
  Snapshot found;
  {
    const std::lock_guard lock(published_mutex_);
    found = published_;
  }
  parts_->energy.count(found.counters, found.simulated_ps);
  return found;
}

void Board::publish(bool with_machine) {
  auto counters = parts_->count();
  parts_->power.count(counters);
  MachineLook machine;
  if (with_machine) machine = parts_->level->look();
  const std::lock_guard lock(published_mutex_);
  published_.simulated_ps = parts_->timeline.now();
  published_.counters = std::move(counters);
  if (with_machine) published_.machine = std::move(machine);
  published_memory_ = parts_->card.limited_memory();
}

}  // namespace gicube::emu
