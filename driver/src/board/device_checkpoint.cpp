// Transfers a board's checkpoint over the data plane; lists the device's own state.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "board/saved/saved_records.h"
#include "device.h"

namespace gicube {

using wire::CheckpointStep;

namespace {

// chosen: a frame in which the connection breaks is sent again from its begin, so a connection that breaks each
// megabyte must still carry some whole frames.
constexpr std::uint32_t kPieceBytes = 256u << 10;

}  // namespace

std::vector<std::uint8_t> Device::checkpoint_step(CheckpointStep step, std::span<const std::uint8_t> what) {
  need_minor(wire::kCheckpointMinor, "checkpoints need");
  std::vector<std::uint8_t> payload(4 + what.size());
  wire::store(std::span(payload), 0, static_cast<std::uint32_t>(step));
  std::ranges::copy(what, payload.begin() + 4);
  return request(wire::FrameType::kCheckpoint, std::move(payload));
}

void Device::write_checkpoint(std::span<const std::uint8_t> bytes) {
  const std::size_t piece = std::min(agreed().max_payload_bytes, kPieceBytes) - 4;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    checkpoint_step(CheckpointStep::kWrite, bytes.subspan(at, std::min(piece, bytes.size() - at)));
  }
}

void Device::read_checkpoint(std::uint64_t bytes, const std::function<void(std::span<const std::uint8_t>)>& sink) {
  std::vector<std::uint8_t> place(16);
  for (std::uint64_t at = 0; at < bytes;) {
    const std::uint64_t piece = std::min<std::uint64_t>({agreed().max_payload_bytes, kPieceBytes, bytes - at});
    wire::store(std::span(place), 0, at);
    wire::store(std::span(place), 8, piece);
    const auto got = checkpoint_step(CheckpointStep::kRead, place);
    if (got.size() != piece)
      give_up(fmt::format("the board answered a read of {} bytes of a checkpoint with {}", piece, got.size()));
    sink(got);
    at += piece;
  }
}

void Device::take_checkpoint(std::span<const std::uint8_t> driver,
                             const std::function<void(std::span<const std::uint8_t>)>& sink) {
  begin_checkpoint();
  write_checkpoint(driver);
  const auto answer = checkpoint_step(CheckpointStep::kTake, {});
  if (answer.size() != 8) give_up(fmt::format("the board answered a checkpoint's size in {} bytes", answer.size()));
  read_checkpoint(wire::load<std::uint64_t>(answer, 0), sink);
  begin_checkpoint();  // frees the board's memory
}

wire::WentOn Device::go_on(std::span<const std::uint8_t> checkpoint) {
  begin_checkpoint();
  write_checkpoint(checkpoint);
  std::vector<std::uint8_t> answer;
  try {
    answer = checkpoint_step(CheckpointStep::kGoOn, {});
  } catch (const Error&) {
    throw;
  } catch (...) {  // of while_waiting: the board has continued, this device has not
    close();
    throw;
  }
  if (answer.size() != wire::bytes_of<wire::WentOn>()) {
    give_up(fmt::format("the board answered the restoring of a checkpoint with {} bytes", answer.size()));
  }
  return wire::decode<wire::WentOn>(answer);
}

std::vector<std::uint8_t> Device::read_driver_part(std::uint64_t bytes) {
  std::vector<std::uint8_t> part;
  read_checkpoint(bytes,
                  [&part](std::span<const std::uint8_t> more) { part.insert(part.end(), more.begin(), more.end()); });
  begin_checkpoint();
  return part;
}

void Device::Remembered::state(Archive& archive) {
  archive("now", now);
  archive("last_id", last_id);
  archive.expect(now <= kNoDeadline / 4, "now", "at most 2^62 ps", now);
  state_of(archive, "registers", registers, [&archive](std::uint32_t& value) { archive("value", value); });
  state_of(archive, "commands", commands, [&archive](Link::Command& command) {
    archive("forgotten", command.forgotten);
    state_of(archive, "result", command.result);
  });
}

}  // namespace gicube
