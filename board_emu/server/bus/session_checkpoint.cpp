// kCheckpoint frames: a client reads a checkpoint of its board, or continues from one (docs/reference/protocol.md). All
// data is sent over the connection, so clients cannot make this process read or write files.
#include <fmt/format.h>

#include <new>

#include "session.h"

namespace gicube::emu {

using wire::CheckpointStep;
using wire::ErrorCode;

awaitable<TransactionResult> Session::checkpoint(const Frame& frame) {
  TransactionResult result;
  Reply& reply = result.reply.emplace();
  std::string refusal;
  std::function<void()> job = [this, &frame, &reply, &refusal] {
    try {
      checkpoint_step(frame.payload, reply);
    } catch (const std::bad_alloc&) {
      refusal = "checkpoint: the system has no memory left for it";
    } catch (const CheckpointFault& fault) {
      refusal = fault.what();
    }
  };
  co_await run_on_compute(std::move(job), false, options_.max_command_time);
  reply.time_ps = frame.header.time_ps;
  if (!refusal.empty()) {
    reply.error = ErrorCode::kBadValue;
    reply.payload.assign(refusal.begin(), refusal.end());
  }
  co_return result;
}

// Throws CheckpointFault; the board is then unchanged and the buffer empty.
void Session::checkpoint_step(std::span<const std::uint8_t> payload, Reply& reply) {
  const std::uint64_t max_bytes = options_.max_held_bytes;
  const auto limit = [max_bytes] { return fmt::format("at most {} bytes (gicube-board --max-results)", max_bytes); };
  std::string buffer = std::move(checkpoint_);
  checkpoint_.clear();
  if (agreed_.minor < wire::kCheckpointMinor) {
    throw CheckpointFault("version", fmt::format("a session of 2.{}", wire::kCheckpointMinor),
                          fmt::format("2.{}", agreed_.minor));
  }
  const auto step = static_cast<CheckpointStep>(payload.size() < 4 ? 0 : wire::load<std::uint32_t>(payload, 0));
  const auto rest = payload.subspan(std::min<std::size_t>(payload.size(), 4));
  const bool has_size = step == CheckpointStep::kWrite || rest.size() == (step == CheckpointStep::kRead ? 16 : 0);
  if (!has_size) throw CheckpointFault("payload", "that of its step", fmt::format("{} bytes", payload.size()));
  switch (step) {
    case CheckpointStep::kBegin: return;
    case CheckpointStep::kWrite: {
      if (rest.size() > max_bytes - buffer.size()) throw CheckpointFault("size", limit(), "more");
      buffer.append(rest.begin(), rest.end());
      break;
    }
    case CheckpointStep::kTake: {
      std::string taken;
      slot_.save({buffer.begin(), buffer.end()}, [&](std::string_view bytes) {
        if (bytes.size() > max_bytes - taken.size()) throw CheckpointFault("size", limit(), "more");
        taken += bytes;
      });
      buffer = std::move(taken);
      reply.payload.resize(8);
      wire::store(std::span(reply.payload), 0, std::uint64_t{buffer.size()});
      break;
    }
    case CheckpointStep::kRead: {
      const auto offset = wire::load<std::uint64_t>(rest, 0), length = wire::load<std::uint64_t>(rest, 8);
      const std::uint64_t max_length = std::min<std::uint64_t>(
          agreed_.max_payload_bytes, buffer.size() - std::min<std::uint64_t>(offset, buffer.size()));
      if (length > max_length)
        throw CheckpointFault("length", fmt::format("at most {}", max_length), std::to_string(length));
      const auto first = buffer.begin() + static_cast<std::ptrdiff_t>(offset);
      reply.payload.assign(first, first + static_cast<std::ptrdiff_t>(length));
      break;
    }
    case CheckpointStep::kGoOn: {
      checkpoint_ = std::move(buffer);
      reply.payload = wire::encoded(go_on());
      return;
    }
    default: throw CheckpointFault("step", "1 to 5", std::to_string(static_cast<std::uint32_t>(step)));
  }
  checkpoint_ = std::move(buffer);
}

wire::WentOn Session::go_on() {
  std::string buffer = std::move(checkpoint_);
  checkpoint_.clear();
  std::vector<std::uint8_t> driver;
  if (!buffer.empty()) {
    driver = slot_.restore(Checkpoint(std::move(buffer)), is_private_);
  } else {
    if (!slot_.has_start())
      throw CheckpointFault("restore", "a board process with --restore, or a checkpoint's bytes", "neither");
    driver = slot_.restore_start(!has_worked_);
  }
  Board& board = slot_.board();
  board.set_minor_version(agreed_.minor);
  begin_ = std::chrono::steady_clock::now() - std::chrono::nanoseconds(board.simulated_ps() / 1000);
  checkpoint_.assign(driver.begin(), driver.end());
  return {driver.size(), config_hash(board.config()), static_cast<std::uint32_t>(board.config().fidelity()),
          board.config().bus().model() == v1::pci33 ? 0u : 1u};
}

}  // namespace gicube::emu
