// Rays that wait for blocks of a volume that the card does not store whole: sends blocks, and has the rays go on, until
// none waits.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "board/state.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"
#include "take_rays.h"

namespace gicube {

std::vector<std::uint8_t> BoardState::read_pieces(const wire::MemoryRegion& region, std::uint64_t from,
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
void BoardState::deposit_for_board(std::uint32_t records, wire::LightingLedger& ledger) {
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

std::vector<wire::WaitingBlock> BoardState::take_waiting(std::span<const std::uint8_t> payload, const BrickRun& run) {
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

// Takes rays off the card if it has more than it should, for the least important blocks first.
void BoardState::queue_excess(std::vector<wire::WaitingBlock>& waiting) {
  std::size_t on_card = 0;
  for (const wire::WaitingBlock& each : waiting) on_card += each.rays;
  if (on_card <= (ray_queue.empty() ? max_waiting_rays : max_waiting_rays / 2)) return;  // queued ones need room there
  std::ranges::sort(waiting, {}, &wire::WaitingBlock::importance);
  std::size_t taken = 0;
  for (; taken < waiting.size() && on_card > max_waiting_rays / 2; ++taken) {
    const wire::WaitingBlock& from = waiting[taken];
    std::vector<std::uint8_t> records;
    take_rays<wire::ForwardedRay>(device, {}, std::span(&from.block, 1),
                                  [&](const wire::ForwardedRay& ray) { wire::append(records, ray); });
    ray_queue.add(from.block, from.importance, records);
    on_card -= from.rays;
  }
  waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(taken));
  std::ranges::sort(waiting, {}, &wire::WaitingBlock::block);
}

// Those that wait on the card, and with the host.
std::vector<wire::WaitingBlock> BoardState::with_queue(std::span<const wire::WaitingBlock> waiting) const {
  std::vector<wire::WaitingBlock> all(waiting.begin(), waiting.end()), out;
  const auto queued = ray_queue.by_block();
  all.insert(all.end(), queued.begin(), queued.end());
  std::ranges::stable_sort(all, {}, &wire::WaitingBlock::block);
  for (const wire::WaitingBlock& each : all) {
    if (out.empty() || out.back().block != each.block) {
      out.push_back(each);
    } else {
      out.back().rays += each.rays;
      out.back().importance += each.importance;
    }
  }
  return out;
}

// Gives the card the host's rays for blocks that it has, as many as it should have.
void BoardState::give_queued(std::span<const wire::WaitingBlock> waiting, const BrickRun& run) {
  std::size_t on_card = 0;
  for (const wire::WaitingBlock& each : waiting) on_card += each.rays;
  for (const wire::WaitingBlock& each : ray_queue.by_block()) {
    if (bricks->is_absent(each.block) || on_card >= max_waiting_rays) continue;
    auto records = ray_queue.take(each.block, max_waiting_rays - on_card);
    on_card += records.size() / wire::kForwardedRayBytes;
    give_rays(std::move(records), {}, run.of);
  }
}

void BoardState::run_waiting(std::vector<wire::WaitingBlock> waiting, const BrickRun& run) {
  ray_queue.clear();                       // of a call that threw
  std::vector<wire::WaitingBlock> others;  // of which other ranks have the blocks
  do {
    if (shared) others = shared->take_others(waiting);
    while (!waiting.empty() || !ray_queue.empty()) {
      queue_excess(waiting);
      const auto all = with_queue(waiting);
      auto wanted = run.order ? run.order(all) : bricks->by_importance(all, run.needs.light);
      if (shared) std::erase_if(wanted, [this](std::size_t block) { return !shared->is_own(block); });
      bricks->load(device, wanted, run.needs);
      check_fence();
      give_queued(waiting, run);
      waiting = take_waiting(device.run(wire::encoded(wire::ContinueCommand{}), {}, run.deadline).payload, run);
      if (shared) others = shared->take_others(waiting);
    }
  } while (shared && forward(others, waiting, run));
}

std::vector<CommandResult> BoardState::trace_in_bricks(std::span<const EncodedRays> parts, const BrickRun& run) {
  bricks->prepare(device, run.needs);
  std::vector<CommandResult> results;
  for (std::size_t first = 0, last = 0; any_left(parts.size() - first); first = last) {
    std::size_t rays = 0;
    for (last = first; last < parts.size() && (last == first || rays + parts[last].rays <= kMaxTracedAtOnce); ++last) {
      rays += parts[last].rays;
    }
    trace_group(parts.subspan(first, last - first), run, results);
  }
  return results;
}

CommandResult BoardState::finish(std::uint32_t ticket) {
  CommandResult result = device.finish(ticket, {});
  if (result.error != wire::ErrorCode::kNone) throw_error(result.error, error_text(result.payload));
  return result;
}

// Rays that leave energy: one command after the other, since what the host must deposit is read before the next.
std::vector<CommandResult> BoardState::deposit_in_bricks(std::span<const EncodedRays> parts, const BrickRun& run) {
  if (shared) begin_shared_light();
  bricks->prepare(device, run.needs);
  std::vector<wire::LightingLedger> ledgers(std::max<std::size_t>(parts.size(), 1));
  for (std::size_t part = 0; any_left(parts.size() - part); part = std::min(part + 1, parts.size())) {
    device.write_register(wire::reg::kControl, wire::kControlDropRays);
    wire::LightingLedger& sum = ledgers[std::min(part, ledgers.size() - 1)];
    BrickRun of_part = run;
    of_part.take_ledger = [&sum](const wire::LightingLedger& ledger) { wire::add(ledger, sum); };
    std::vector<wire::WaitingBlock> waiting;
    if (part < parts.size()) waiting = take_waiting(finish(device.command(parts[part].encoded)).payload, of_part);
    run_waiting(std::move(waiting), of_part);
  }
  if (shared) {  // the whole job's, in the first
    wire::LightingLedger sum;
    for (wire::LightingLedger& each : ledgers) wire::add(std::exchange(each, {}), sum);
    end_shared_light(sum);
    ledgers[0] = sum;
  }
  std::vector<CommandResult> results;
  for (std::size_t part = 0; part < parts.size(); ++part) {
    results.push_back({.time_ps = device.clock().now(), .payload = wire::encoded(ledgers[part])});
    results.back().payload.resize(wire::lighting_ledger_bytes(device.agreed().minor));
  }
  return results;
}

// All rays of a group wait together, so that each block is sent for all of them.
void BoardState::trace_group(std::span<const EncodedRays> parts, const BrickRun& run,
                             std::vector<CommandResult>& results) {
  device.write_register(wire::reg::kControl, wire::kControlDropRays);
  std::vector<std::uint32_t> tickets;
  for (const EncodedRays& part : parts) tickets.push_back(device.command(part.encoded));
  CommandResult latest;  // whose list has all rays that wait
  for (const std::uint32_t ticket : tickets) latest = finish(ticket);
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
