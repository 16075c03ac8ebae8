// Rays that wait for blocks of a volume that the card does not store whole: sends blocks, and has the rays go on, until none waits.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "board/state.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"

namespace gicube {

std::vector<std::uint8_t> Board::State::read_pieces(const wire::MemoryRegion& region, std::uint64_t from,
                                                    std::uint64_t bytes, std::size_t record) {
  const std::size_t max_bytes = device.agreed().max_payload_bytes / record * record;
  std::vector<std::uint8_t> out;
  while (out.size() < bytes) {
    const std::uint64_t length = std::min<std::uint64_t>(max_bytes, bytes - out.size());
    const auto piece = device.read_memory(region.base + from + out.size(), length);
    out.insert(out.end(), piece.begin(), piece.end());
  }
  return out;
}

// Adds what rays have left in blocks whose words the host has, and to the ledger what became of it.
void Board::State::deposit_for_board(std::uint32_t records, wire::LightingLedger& ledger) {
  const auto bytes =
      read_pieces(wire::kHostDeposits, 0, std::uint64_t{records} * wire::kHostDepositBytes, wire::kHostDepositBytes);
  std::vector<wire::HostDeposit> deposits;
  for (std::size_t at = 0; at < bytes.size(); at += wire::kHostDepositBytes) {
    deposits.push_back(wire::decode<wire::HostDeposit>(std::span(bytes).subspan(at)));
  }
  const BrickLight::Added added = bricks->light().add(deposits);
  ledger.deposited += added.kept;
  ledger.clipped += added.clipped;
}

std::vector<wire::WaitingBlock> Board::State::take_waiting(std::span<const std::uint8_t> payload, const BrickRun& run) {
  try {
    if (!run.take_ledger) return decode_waiting(payload, bricks->count()).blocks;
    const std::uint16_t minor = device.agreed().minor;
    if (payload.size() < wire::lighting_ledger_bytes(minor)) throw std::out_of_range("size");
    wire::LightingLedger ledger = wire::decode_lighting_ledger(payload, minor);
    bricks->light().deposited();
    Waiting waiting = decode_waiting(payload.subspan(wire::lighting_ledger_bytes(minor)), bricks->count());
    if (waiting.host_deposits != 0) deposit_for_board(waiting.host_deposits, ledger);
    run.take_ledger(ledger);
    return std::move(waiting.blocks);
  } catch (const std::out_of_range& error) {
    device.give_up(std::string("a list of waiting rays with a wrong ") + error.what());
  }
}

void Board::State::run_in_bricks(std::span<const std::uint8_t> payload, const BrickRun& run) {
  CommandResult result;
  for (auto waiting = take_waiting(payload, run); !waiting.empty(); waiting = take_waiting(result.payload, run)) {
    bricks->load(device, run.order ? run.order(waiting) : bricks->by_importance(waiting, run.needs.light), run.needs);
    check_fence();
    result = device.run(wire::encoded(wire::ContinueCommand{}), {}, run.deadline);
  }
}

std::vector<CommandResult> Board::State::trace_in_bricks(std::span<const EncodedRays> parts, const BrickRun& run) {
  bricks->prepare(device, run.needs.light);
  std::vector<CommandResult> results;
  for (std::size_t first = 0, last = 0; first < parts.size(); first = last) {
    std::size_t rays = parts[first].rays;
    for (last = first + 1; last < parts.size() && rays + parts[last].rays <= kMaxTracedAtOnce; ++last) {
      rays += parts[last].rays;
    }
    trace_group(parts.subspan(first, last - first), run, results);
  }
  return results;
}

// All rays of a group wait together, so that each block is sent for all of them.
void Board::State::trace_group(std::span<const EncodedRays> parts, const BrickRun& run,
                               std::vector<CommandResult>& results) {
  const auto take = [&](std::uint32_t ticket) {
    CommandResult result = device.finish(ticket, {});
    if (result.error != wire::ErrorCode::kNone) throw_error(result.error, error_text(result.payload));
    return result;
  };
  device.write_register(wire::reg::kControl, wire::kControlDropRays);
  if (run.take_ledger) {  // what the host must deposit is read before the next command
    for (const EncodedRays& part : parts) {
      wire::LightingLedger sum;
      BrickRun of_part = run;
      of_part.take_ledger = [&sum](const wire::LightingLedger& ledger) { wire::add(ledger, sum); };
      run_in_bricks(take(device.command(part.encoded)).payload, of_part);
      results.push_back({.time_ps = device.clock().now(), .payload = wire::encoded(sum)});
      results.back().payload.resize(wire::lighting_ledger_bytes(device.agreed().minor));
    }
    return;
  }
  std::vector<std::uint32_t> tickets;
  for (const EncodedRays& part : parts) tickets.push_back(device.command(part.encoded));
  CommandResult latest;  // whose list has all rays that wait
  for (const std::uint32_t ticket : tickets) latest = take(ticket);
  run_in_bricks(latest.payload, run);
  std::uint64_t at = 0;
  for (const EncodedRays& part : parts) {
    const std::uint64_t bytes = std::uint64_t{part.rays} * wire::kRayBytes;
    auto rays = read_pieces(wire::kHostRayMemory, at, bytes, wire::kRayBytes);
    results.push_back({.time_ps = device.clock().now(), .payload = std::move(rays)});
    at += bytes;
  }
  device.write_register(wire::reg::kControl, wire::kControlDropRays);
}

}  // namespace gicube
