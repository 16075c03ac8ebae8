// Runs commands on a volume that the card does not store whole: sends blocks that rays wait for and resumes the rays,
// until none waits.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "board/state.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"
#include "take_rays.h"

namespace gicube {

// Adds the energy that rays deposited in blocks whose words the host has, to these words and to the ledger.
void BoardState::deposit_for_board(std::uint32_t records, wire::LightingLedger& ledger) {
  const auto bytes = device.read_memory(wire::kHostDeposits.base, std::uint64_t{records} * wire::kHostDepositBytes,
                                        wire::kHostDepositBytes);
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

// Moves waiting rays from the card to the host if there are more than the limit, those of the least important blocks
// first.
void BoardState::queue_excess(std::vector<wire::WaitingBlock>& waiting) {
  std::size_t on_card = 0;
  for (const wire::WaitingBlock& each : waiting) on_card += each.rays;
  if (on_card <= (ray_queue.empty() ? max_waiting_rays : max_waiting_rays / 2)) return;  // queued rays need room there
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

// The blocks that rays wait for on the card and in the host's queue.
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

// Returns queued rays to the card for blocks that it has, up to the limit.
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
  ray_queue.clear();                       // left by a call that threw
  std::vector<wire::WaitingBlock> others;  // blocks of other ranks
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

// For rays that deposit: one command after the other, because the host's deposits must be read before the next command.
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
    if (part < parts.size())
      waiting = take_waiting(device.finish_or_throw(device.command(parts[part].encoded)).payload, of_part);
    run_waiting(std::move(waiting), of_part);
  }
  if (shared) {  // the first ledger is that of the whole job
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

// Traces a group of commands together, so that each block is sent once for all of their rays.
void BoardState::trace_group(std::span<const EncodedRays> parts, const BrickRun& run,
                             std::vector<CommandResult>& results) {
  device.write_register(wire::reg::kControl, wire::kControlDropRays);
  std::vector<std::uint32_t> tickets;
  for (const EncodedRays& part : parts) tickets.push_back(device.command(part.encoded));
  CommandResult latest;  // its list has all waiting rays
  for (const std::uint32_t ticket : tickets) latest = device.finish_or_throw(ticket);
  run_in_bricks(latest.payload, run);
  std::uint64_t at = 0;
  for (const EncodedRays& part : parts) {
    const std::uint64_t bytes = std::uint64_t{part.rays} * wire::kRayBytes;
    auto rays = device.read_memory(wire::kHostRayMemory.base + at, bytes, wire::kRayBytes);
    results.push_back({.time_ps = device.clock().now(), .payload = std::move(rays)});
    at += bytes;
  }
  device.write_register(wire::reg::kControl, wire::kControlDropRays);
}

}  // namespace gicube
