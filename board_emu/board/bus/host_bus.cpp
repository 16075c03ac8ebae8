#include "board/bus/host_bus.h"

namespace gicube::emu {

namespace {

constexpr BusDirection other(BusDirection direction) {
  return direction == BusDirection::kDown ? BusDirection::kUp : BusDirection::kDown;
}

constexpr std::uint64_t to_dwords(std::uint64_t bytes) { return (bytes + 3) / 4; }

}  // namespace

void HostBus::enqueue(BusDirection direction, const BusTransfer& transfer) {
  Side& to = side(direction);
  to.queue.push_back(transfer);
  if (to.queue.size() == 1) to.dwords_left = to_dwords(transfer.bytes);
}

// Number of full-length bursts that the head can send before `limit`, except its last. So a long transfer without
// contention takes one step.
std::uint64_t HostBus::bursts_alone(BusDirection direction, Picoseconds start, Picoseconds limit) const {
  const Side& from = side(direction);
  const TransferKind kind = from.queue.front().kind;
  const std::uint64_t longest = timing_.longest_burst(direction, kind);
  const std::uint64_t whole = (from.dwords_left - 1) / longest;
  const Picoseconds burst_ps =
      timing_.burst_clocks(direction, kind, static_cast<std::uint32_t>(longest)) * timing_.clock_ps;
  const std::uint64_t fitting = limit == kNever ? whole : (limit > start ? (limit - start) / burst_ps : 0);
  return std::min(whole, fitting);
}

std::optional<BusDelivery> HostBus::next_delivery(Picoseconds horizon) {
  for (;;) {
    const Picoseconds down_ready = head_ready(BusDirection::kDown), up_ready = head_ready(BusDirection::kUp);
    if (down_ready == kNever && up_ready == kNever) return std::nullopt;

    const Picoseconds start = std::max(free_ps_, std::min(down_ready, up_ready));
    if (start > horizon) return std::nullopt;
    const bool contended = down_ready <= start && up_ready <= start;
    const BusDirection turn =
        contended ? other(last_) : (down_ready <= start ? BusDirection::kDown : BusDirection::kUp);
    Side& from = side(turn);
    const BusTransfer head = from.queue.front();
    const Picoseconds rival_ps = head_ready(other(turn));

    Picoseconds end = start;
    if (from.dwords_left > 0) {
      const Picoseconds alone_until = std::min(rival_ps, horizon);
      const std::uint64_t alone = bursts_alone(turn, start, alone_until);
      const std::uint32_t longest = timing_.longest_burst(turn, head.kind);
      auto burst = static_cast<std::uint32_t>(std::min<std::uint64_t>(from.dwords_left, longest));
      std::uint64_t count = 1;
      if (alone > 0) {
        burst = longest;
        count = alone;
      } else if (rival_ps != kNever) {
        const std::uint64_t asked_after =
            rival_ps > start ? (rival_ps - start + timing_.clock_ps - 1) / timing_.clock_ps : 0;
        const std::uint64_t allowed = std::max<std::uint64_t>(timing_.latency_timer_clocks, asked_after);
        burst = std::min(burst, timing_.dwords_within(turn, head.kind, allowed));
      }
      end = start + count * timing_.burst_clocks(turn, head.kind, burst) * timing_.clock_ps;
      if (end > horizon) return std::nullopt;
      from.dwords_left -= count * burst;
      from.counters.bursts += count;
      from.counters.busy_ps += end - start;
    }
    if (!from.head_started) {
      from.counters.wait_ps += start - std::max(head.ready_ps, from.last_delivery_ps);
      from.head_started = true;
      from.head_begin_ps = start;
    }
    free_ps_ = end;
    last_ = turn;
    if (from.dwords_left > 0) continue;

    from.queue.pop_front();
    from.head_started = false;
    from.dwords_left = from.queue.empty() ? 0 : to_dwords(from.queue.front().bytes);
    CargoCounters& cargo = cargoes_[static_cast<std::size_t>(head.cargo)];
    cargo.time_ps += end - std::max(head.ready_ps, from.last_delivery_ps);
    cargo.bytes += head.bytes;
    ++cargo.transfers;
    from.last_delivery_ps = end;
    from.counters.bytes += head.bytes;
    ++from.counters.transfers;
    return BusDelivery{head.id, turn, end, from.head_begin_ps, head.cargo, head.bytes};
  }
}

}  // namespace gicube::emu
