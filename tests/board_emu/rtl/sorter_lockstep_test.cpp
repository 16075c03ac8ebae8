// The sorter in SystemVerilog against asic/sorter, register by register.
#include <Vsorter_16x256.h>
#include <Vsorter_8x8.h>
#include <Vsorter_contribution.h>
#include <Vsorter_wait.h>

#include <algorithm>
#include <optional>

#include "asic/sorter/sorter.h"
#include "lockstep.h"
#include "queue_registers.h"
#include "token_bits.h"

namespace gicube::emu::lockstep {
namespace {

constexpr std::uint8_t kProcessor = 3;
constexpr std::uint32_t kRays = 600;     // most rays under way
constexpr std::uint64_t kReserved = 64;  // reserved slots for which the description has places; the part has no limit

// What surrounds a sorter: the bus, neighbours, the pipeline and the DSP. Rays keep the rules of slots.
struct Around {
  Twin<RayToken> returned, bus, left, right, issue, overflow;
  Twin<std::uint32_t> released;
  std::vector<RayToken> in_pipeline, with_dsp;
  std::vector<std::uint32_t> slots;  // reported for an overflowed ray
  std::uint32_t next_ray = 0, under_way = 0;

  enum Kind { kBus, kLeft, kRight, kIssue, kOverflow, kBack, kElsewhere, kEnd, kSlot, kOneQueue };

  RayToken made(Chance& chance, std::uint32_t queues) {
    RayToken token;
    token.ray = next_ray++;
    ++under_way;
    token.queue = chance.happens(kOneQueue) ? 1 : chance.below(queues);
    token.contribution = static_cast<std::uint16_t>(chance.below(4) == 0 ? 0 : chance.below(4096));
    token.processor = kProcessor;
    return token;
  }

  // `must_drain`: overflows are taken and no ray comes.
  void act(Cycle now, Chance& chance, std::uint32_t queues, bool must_drain) {
    // The DSP limits the rays under way, and sends none when it has to take overflows.
    const bool full = must_drain || under_way > kRays;
    if (chance.happens(kBus) && bus.can_push(now) && !(full && slots.empty())) {
      const bool slot = !slots.empty() && (full || chance.happens(kSlot));
      if (slot) {
        const auto ray = std::ranges::find(with_dsp, slots.front(), &RayToken::queue);
        ASSERT_NE(ray, with_dsp.end()) << "a slot for a queue of which no ray has overflowed";
        ray->has_reserved_slot = true;
        ray->state = TokenStatus::kUnderWay;
        bus.push(now, *ray);
        with_dsp.erase(ray);
        slots.erase(slots.begin());
      } else {
        bus.push(now, made(chance, queues));
      }
    }
    if (!full && chance.happens(kLeft) && left.can_push(now)) left.push(now, made(chance, queues));
    if (!full && chance.happens(kRight) && right.can_push(now)) right.push(now, made(chance, queues));
    if (chance.happens(kIssue) && issue.can_pop(now)) in_pipeline.push_back(issue.pop(now));
    if ((must_drain || chance.happens(kOverflow)) && overflow.can_pop(now)) {
      const RayToken token = overflow.pop(now);
      if (token.state == TokenStatus::kSlot) {
        slots.push_back(token.queue);
      } else {
        with_dsp.push_back(token);
      }
    }
    if (in_pipeline.empty() || must_drain) return;
    RayToken token = in_pipeline.front();
    if (chance.happens(kBack)) {
      if (!returned.can_push(now)) return;
      token.has_reserved_slot = true;
      token.contribution = static_cast<std::uint16_t>(chance.below(4096));
      returned.push(now, token);
    } else if (chance.happens(kElsewhere)) {
      if (!returned.can_push(now) || !released.can_push(now)) return;
      released.push(now, token.queue);
      token.queue = (token.queue + 1 + chance.below(queues - 1)) % queues;
      returned.push(now, token);
    } else if (chance.happens(kEnd)) {
      if (!released.can_push(now)) return;
      released.push(now, token.queue);
      --under_way;
    } else {
      return;
    }
    in_pipeline.erase(in_pipeline.begin());
  }
};

template <typename Model>
void run(std::uint32_t queues, std::uint32_t capacity, v1::QueuePolicy policy, unsigned seed) {
  Around around;
  const TokenBits form{.queue = static_cast<std::size_t>(std::bit_width(queues - 1)), .ray = 32};
  Sorter sorter({.processor = kProcessor, .queues = queues, .capacity = capacity, .policy = policy},
                {around.returned.part, around.bus.part, around.left.part, around.right.part, around.released.part},
                {around.issue.part, around.overflow.part});
  Clocked<Model> rtl("sorter");
  const QueueRegisters registers(rtl, queues, capacity, form);
  rtl->processor = kProcessor;
  Chance chance(seed, 10);
  SorterCounters counters;
  const std::array<Fifo<RayToken>*, 4> inputs{&around.returned.rtl, &around.bus.rtl, &around.left.rtl,
                                              &around.right.rtl};

  for (Cycle now = 0; now < cycles(); ++now) {
    chance.next_cycle(now);
    around.act(now, chance, queues, registers.reserved() > kReserved / 2);
    if (testing::Test::HasFatalFailure()) return;
    const bool moved = sorter.tick(now);

    rtl->arrives = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!inputs[i]->can_pop(now)) continue;
      rtl->arrives = static_cast<CData>(rtl->arrives | 1u << i);
      form.put(rtl->tokens, i, inputs[i]->front());
    }
    rtl->is_released = around.released.rtl.can_pop(now);
    if (rtl->is_released) rtl->released = static_cast<CData>(around.released.rtl.front());
    rtl->issue_ready = around.issue.rtl.can_push(now);
    rtl->overflow_ready = around.overflow.rtl.can_push(now);
    rtl.settle();
    ASSERT_EQ(moved, rtl->moves != 0) << now;
    if (rtl->is_released) around.released.rtl.pop(now);
    for (std::size_t i = 0; i < 4; ++i) {
      if ((rtl->pops >> i & 1) != 0) inputs[i]->pop(now);
    }
    if (rtl->issues) around.issue.rtl.push(now, form.get(rtl->issued, 0));
    if (rtl->overflows) around.overflow.rtl.push(now, form.get(rtl->overflowed, 0));
    counters.written += std::popcount(static_cast<unsigned>(rtl->pops)) - (rtl->finds_no_slot ? 1u : 0u);
    counters.conflicts += rtl->conflicts;
    counters.overflows += rtl->finds_no_slot;
    counters.reserved_slots += rtl->reports_slot;
    counters.issued += rtl->issues;
    counters.activations += rtl->activates;
    counters.inserts += rtl->inserts;
    const bool gives_up = rtl->gives_up;
    ASSERT_FALSE(rtl->loses_slot) << now;
    rtl.cycle();
    counters.peak_waiting = std::max(counters.peak_waiting, registers.most_waiting());
    if (gives_up) {
      const std::uint64_t rays = registers.issued_since_active();
      const auto bucket = static_cast<std::size_t>(std::bit_width(rays)) - 1;
      ++counters.activation_rays[bucket];
      counters.activation_issued[bucket] += rays;
    }

    const Registers part(sorter);
    ASSERT_EQ(registers.difference(part, counters), "") << "cycle " << now;
    for (const auto* fifo :
         {&around.returned, &around.bus, &around.left, &around.right, &around.issue, &around.overflow}) {
      ASSERT_TRUE(fifo->agrees()) << "cycle " << now;
    }
    ASSERT_TRUE(around.released.agrees()) << "cycle " << now;
  }
  // The run has met what it is for.
  EXPECT_GT(counters.conflicts, 0u);
  EXPECT_GT(counters.overflows, 0u);
  EXPECT_GT(counters.reserved_slots, 0u);
  EXPECT_GT(counters.activations, 100u);
}

TEST(SorterInLockstep, WithShortQueues) { run<Vsorter_8x8>(8, 8, v1::most_rays, 1); }
TEST(SorterInLockstep, WithThePapersQueues) { run<Vsorter_16x256>(16, 256, v1::most_rays, 2); }
TEST(SorterInLockstep, ByContribution) { run<Vsorter_contribution>(8, 8, v1::most_contribution, 3); }
TEST(SorterInLockstep, ByTheLongestWait) { run<Vsorter_wait>(8, 8, v1::longest_wait, 4); }

}  // namespace
}  // namespace gicube::emu::lockstep
