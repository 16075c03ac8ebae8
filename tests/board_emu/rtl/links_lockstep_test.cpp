// Links, ray bus and merge tree in SystemVerilog against asic/link and asic/raybus, register by register.
#include <Vmerge_tree_2.h>
#include <Vmerge_tree_8.h>
#include <Vray_bus_2.h>
#include <Vray_bus_4.h>
#include <Vring_2.h>
#include <Vring_4.h>

#include <deque>

#include "asic/link/ring.h"
#include "asic/raybus/merge_tree.h"
#include "asic/raybus/ray_bus.h"
#include "lockstep.h"
#include "token_bits.h"

namespace gicube::emu::lockstep {
namespace {

constexpr TokenBits kForm{.queue = 3, .ray = 32};

RayToken token(Chance& chance, std::uint32_t ray, std::uint32_t processors) {
  RayToken out;
  out.ray = ray;
  out.queue = chance.below(8);
  out.contribution = static_cast<std::uint16_t>(chance.below(4096));
  out.processor = static_cast<std::uint8_t>(chance.below(processors));
  return out;
}

// Appends what a Fifo lists.
void list(Numbers& out, const Register& items, std::uint64_t size, Cycle push, Cycle pop) {
  out.insert(out.end(), {size, push, pop});
  for (std::uint64_t i = 0; i < size; ++i) {
    const RayToken token = kForm.from(items.entry(0), i);
    out.insert(out.end(), {token.ray, token.queue, token.contribution, token.processor,
                           static_cast<std::uint64_t>(token.state), token.has_reserved_slot ? 1u : 0u});
  }
}
// A FIFO of the description, with the cycles in which it was pushed and popped.
struct FifoRegisters {
  Register items, size;
  Cycle push = kNoCycle, pop = kNoCycle;

  void list_in(Numbers& out) const { list(out, items, size(), push, pop); }
};
template <typename Rtl>
FifoRegisters fifo(const Rtl& rtl, const std::string& path) {
  return {rtl.find(path + ".items"), rtl.find(path + ".size")};
}

template <typename Model>
void run_ring(std::uint32_t processors, std::uint32_t link_bits, std::uint32_t rays, unsigned seed) {
  std::vector<Twin<RayToken>> out(processors), left(processors), right(processors);
  std::vector<Ring::Port> ports;
  for (std::uint32_t i = 0; i < processors; ++i) ports.push_back({&out[i].part, &left[i].part, &right[i].part});
  Ring ring(link_bits, rays, ports);
  Clocked<Model> rtl("ring");
  std::vector<FifoRegisters> entries;  // to the right, then to the left
  std::vector<Register> sent;
  for (const char* way : {"to_right", "to_left"}) {
    for (std::uint32_t i = 0; i < processors; ++i) {
      const std::string link = "gen_processor[" + std::to_string(i) + "]." + way;
      entries.push_back(fifo(rtl, link + ".entry"));
      sent.push_back(rtl.find(link + ".sent"));
    }
  }
  Chance chance(seed, 3 * processors);
  std::vector<RingCounters> counters(processors);
  std::uint32_t next_ray = 0;
  for (Cycle now = 0; now < cycles(); ++now) {
    chance.next_cycle(now);
    for (std::uint32_t i = 0; i < processors; ++i) {
      if (chance.happens(i) && out[i].can_push(now)) {
        RayToken leaving = token(chance, next_ray++, processors - 1);
        leaving.processor = static_cast<std::uint8_t>((i + 1 + leaving.processor) % processors);
        out[i].push(now, leaving);
      }
      if (chance.happens(processors + i) && left[i].can_pop(now)) left[i].pop(now);
      if (chance.happens(2 * processors + i) && right[i].can_pop(now)) right[i].pop(now);
    }
    ring.tick(now);

    rtl->leaves = rtl->left_ready = rtl->right_ready = 0;
    for (std::uint32_t i = 0; i < processors; ++i) {
      if (out[i].rtl.can_pop(now)) {
        put(rtl->leaves, i, 1, 1);
        kForm.put(rtl->leaving, i, out[i].rtl.front());
      }
      put(rtl->left_ready, i, 1, left[i].rtl.can_push(now));
      put(rtl->right_ready, i, 1, right[i].rtl.can_push(now));
    }
    rtl.settle();
    std::vector<std::uint32_t> pushes;
    for (std::uint32_t i = 0; i < processors; ++i) {
      const std::uint32_t to_right = (i + 1) % processors, to_left = (i + processors - 1) % processors;
      if (bits(rtl->enters, i, 1) != 0) {
        const std::uint32_t distance = (out[i].rtl.pop(now).processor + processors - i) % processors;
        pushes.push_back(distance <= processors - distance ? i : processors + i);
        ++counters[i].sent;
      }
      counters[i].entry_waits += bits(rtl->waits, i, 1);
      const bool from_left = bits(rtl->from_left, i, 1) != 0, from_right = bits(rtl->from_right, i, 1) != 0;
      if (from_left) left[i].rtl.push(now, kForm.get(rtl->from_left_token, i));
      if (from_right) right[i].rtl.push(now, kForm.get(rtl->from_right_token, i));
      for (const std::uint32_t way : {0u, 1u}) {
        const std::uint32_t link = way * processors + i;
        counters[i].busy += bits(rtl->busy, link, 1);
        counters[i].blocked += bits(rtl->blocked, link, 1);
        if (bits(rtl->hops, link, 1) == 0) continue;
        ++counters[i].rays[way];
        entries[link].pop = now;
        const std::uint32_t end = way == 0 ? to_right : to_left;
        if (bits(way == 0 ? rtl->from_left : rtl->from_right, end, 1) == 0) pushes.push_back(way * processors + end);
      }
    }
    for (const std::uint32_t link : pushes) entries[link].push = now;
    rtl.cycle();

    const Registers part(std::ref(ring));
    Numbers links, counted;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      entries[i].list_in(links);
      links.push_back(sent[i]());
    }
    for (const RingCounters& all : counters) {
      counted.insert(counted.end(), {all.sent, all.rays[0], all.rays[1], all.busy, all.blocked, all.entry_waits});
    }
    ASSERT_EQ(part["links"], links) << "cycle " << now;
    ASSERT_EQ(part["counters"], counted) << "cycle " << now;
    for (std::uint32_t i = 0; i < processors; ++i) {
      ASSERT_TRUE(out[i].agrees() && left[i].agrees() && right[i].agrees()) << "cycle " << now;
    }
  }
  EXPECT_GT(counters[0].blocked, 0u);
  EXPECT_GT(counters[0].entry_waits, 0u);
}

TEST(RingInLockstep, OfTwoProcessors) { run_ring<Vring_2>(2, 256, 2, 1); }
TEST(RingInLockstep, OfFourProcessorsAndNarrowLinks) { run_ring<Vring_4>(4, 32, 4, 2); }

template <typename Model>
void run_merge_tree(std::uint32_t leaves, unsigned seed) {
  std::vector<Twin<RayToken>> inputs(leaves);
  Twin<RayToken> output;
  std::vector<Fifo<RayToken>*> fifos;
  for (auto& input : inputs) fifos.push_back(&input.part);
  MergeTree tree(fifos, output.part);
  Clocked<Model> rtl("merge_tree");
  // The part lists nodes by level from the leaves on; `node`: the heap's number.
  std::vector<std::uint32_t> order;
  for (std::uint32_t first = leaves / 2; first > 0; first /= 2) {
    for (std::uint32_t node = first; node < 2 * first; ++node) order.push_back(node);
  }
  std::map<std::uint32_t, FifoRegisters> between;
  std::map<std::uint32_t, Register> turns;
  for (const std::uint32_t node : order) {
    const std::string path = "gen_node[" + std::to_string(node) + "].";
    turns[node] = rtl.find(path + "merge.turn");
    if (node > 1) between[node] = fifo(rtl, path + "gen_between.between");
  }
  Chance chance(seed, leaves + 1);
  std::uint64_t rays = 0, waits = 0;
  std::uint32_t next_ray = 0;
  for (Cycle now = 0; now < cycles(); ++now) {
    chance.next_cycle(now);
    for (std::uint32_t i = 0; i < leaves; ++i) {
      if (chance.happens(i) && inputs[i].can_push(now)) inputs[i].push(now, token(chance, next_ray++, 4));
    }
    if (chance.happens(leaves) && output.can_pop(now)) output.pop(now);
    tree.tick(now);

    rtl->comes = 0;
    for (std::uint32_t i = 0; i < leaves; ++i) {
      if (!inputs[i].rtl.can_pop(now)) continue;
      put(rtl->comes, i, 1, 1);
      kForm.put(rtl->leaves, i, inputs[i].rtl.front());
    }
    rtl->ready = output.rtl.can_push(now);
    rtl.settle();
    for (std::uint32_t i = 0; i < leaves; ++i) {
      if (bits(rtl->takes, i, 1) != 0) inputs[i].rtl.pop(now);
    }
    if (rtl->push) output.rtl.push(now, kForm.get(rtl->token, 0));
    rays += rtl->push;
    waits += rtl->waits;
    std::map<std::uint32_t, std::pair<std::uint64_t, RayToken>> before;
    for (const auto& [node, entry] : between) before[node] = {entry.size(), kForm.from(entry.items.entry(0))};
    rtl.cycle();
    // A pop changes the front; rays have numbers of their own. The size then says whether there was a push.
    for (auto& [node, entry] : between) {
      const auto& [size, front] = before[node];
      const bool is_front = entry.size() > 0 && same(kForm.from(entry.items.entry(0)), front);
      const bool popped = size > 0 && !is_front;
      if (popped) entry.pop = now;
      if (entry.size() + (popped ? 1 : 0) > size) entry.push = now;
    }

    const Registers part(std::ref(tree));
    Numbers turned, inside;
    for (const std::uint32_t node : order) {
      turned.push_back(turns[node]());
      if (node > 1) between[node].list_in(inside);
    }
    ASSERT_EQ(part["turns"], turned) << "cycle " << now;
    ASSERT_EQ(part["between"], inside) << "cycle " << now;
    ASSERT_EQ(part["counters"], (Numbers{rays, waits})) << "cycle " << now;
    for (const auto& input : inputs) ASSERT_TRUE(input.agrees()) << "cycle " << now;
    ASSERT_TRUE(output.agrees()) << "cycle " << now;
  }
  EXPECT_GT(rays, 0u);
  EXPECT_GT(waits, 0u);
}

TEST(MergeTreeInLockstep, OfOneProcessor) { run_merge_tree<Vmerge_tree_2>(2, 1); }
TEST(MergeTreeInLockstep, OfFourProcessors) { run_merge_tree<Vmerge_tree_8>(8, 2); }

template <typename Model>
void run_ray_bus(std::uint32_t processors, unsigned seed) {
  constexpr std::uint32_t kRunRays = 16;
  Twin<RayToken> down;
  Twin<RunPool::Run> runs;
  std::vector<Twin<RayToken>> to(processors);
  std::vector<Fifo<RayToken>*> fifos;
  for (auto& one : to) fifos.push_back(&one.part);
  RunPool pool(processors);
  RayBus bus(down.part, runs.part, pool, fifos);
  Clocked<Model> rtl("ray_bus");
  const Register sending = rtl.find("sending"), run_next = rtl.find("run_next"), sent_run = rtl.find("sent_run");
  std::vector<std::array<Register, 4>> buffers;
  for (std::uint32_t i = 0; i < processors; ++i) {
    const std::string path = "gen_processor[" + std::to_string(i) + "].buffer.";
    buffers.push_back(
        {rtl.find(path + "count"), rtl.find(path + "runs"), rtl.find(path + "rests"), rtl.find(path + "run_had_turn")});
  }
  std::map<RunPool::Run, std::vector<RayToken>> rays_of;  // the pool may free a run in the cycle of its last ray
  Chance chance(seed, 3 + processors);
  RayBusCounters counters;
  std::uint32_t next_ray = 0;
  for (Cycle now = 0; now < cycles(); ++now) {
    chance.next_cycle(now);
    if (chance.happens(0) && down.can_push(now)) down.push(now, token(chance, next_ray++, processors));
    if (chance.happens(1) && runs.can_push(now)) {
      std::vector<RayToken> rays;
      for (std::uint32_t count = 1 + chance.below(kRunRays); count > 0; --count) {
        rays.push_back(token(chance, next_ray++, chance.happens(2) ? 1 : processors));
      }
      const RunPool::Run run = pool.add(rays);
      rays_of[run] = rays;
      runs.push(now, run);
    }
    for (std::uint32_t i = 0; i < processors; ++i) {
      if (chance.happens(3 + i) && to[i].can_pop(now)) to[i].pop(now);
    }
    bus.tick(now);

    rtl->has_ray = down.rtl.can_pop(now);
    if (rtl->has_ray) rtl->destination = down.rtl.front().processor;
    rtl->has_run = runs.rtl.can_pop(now);
    if (rtl->has_run) {
      rtl->run = static_cast<CData>(runs.rtl.front());
      const std::vector<RayToken>& rays = rays_of[runs.rtl.front()];
      for (std::uint32_t i = 0; i < processors; ++i) {
        for (std::uint32_t k = 0; k < kRunRays; ++k) {
          put(rtl->own, i * kRunRays + k, 1, k < rays.size() && rays[k].processor == i ? 1 : 0);
        }
      }
    }
    rtl->ready = 0;
    for (std::uint32_t i = 0; i < processors; ++i) put(rtl->ready, i, 1, to[i].rtl.can_push(now));
    rtl.settle();
    for (std::uint32_t i = 0; i < processors; ++i) {
      if (bits(rtl->push_ray, i, 1) != 0) to[i].rtl.push(now, down.rtl.front());
      if (bits(rtl->push_run_ray, i, 1) == 0) continue;
      const auto run = static_cast<RunPool::Run>(bits(rtl->push_run, 8 * i, 8));
      to[i].rtl.push(now, rays_of[run].at(bits(rtl->index, 4 * i, 4)));
      ++counters.run_rays;
    }
    counters.rays += rtl->takes_ray;
    counters.runs += rtl->takes_run;
    counters.busy += rtl->busy;
    counters.waits += rtl->waits;
    if (rtl->takes_ray) down.rtl.pop(now);
    if (rtl->takes_run) runs.rtl.pop(now);
    rtl.cycle();

    const Registers part(std::ref(bus));
    Numbers turns, inside{sending()};
    if (sending() != 0) inside.push_back(sent_run());
    for (const auto& [count, numbers, rests, had_turn] : buffers) {
      turns.push_back(had_turn());
      inside.push_back(count());
      for (std::uint64_t k = 0; k < count(); ++k) {
        inside.insert(inside.end(),
                      {numbers(8 * k, 8), static_cast<std::uint64_t>(std::countr_zero(rests(kRunRays * k, kRunRays)))});
      }
    }
    ASSERT_EQ(part["turns"], turns) << "cycle " << now;
    ASSERT_EQ(part["runs"], inside) << "cycle " << now;
    ASSERT_EQ(part.number("run_next"), run_next()) << "cycle " << now;
    ASSERT_EQ(part["counters"],
              (Numbers{counters.rays, counters.runs, counters.run_rays, counters.busy, counters.waits}))
        << "cycle " << now;
    ASSERT_TRUE(down.agrees() && runs.agrees()) << "cycle " << now;
    for (const auto& one : to) ASSERT_TRUE(one.agrees()) << "cycle " << now;
  }
  EXPECT_GT(counters.waits, 0u);
  EXPECT_GT(counters.run_rays, counters.runs);
}

TEST(RayBusInLockstep, OfTwoProcessors) { run_ray_bus<Vray_bus_2>(2, 1); }
TEST(RayBusInLockstep, OfFourProcessors) { run_ray_bus<Vray_bus_4>(4, 2); }

}  // namespace
}  // namespace gicube::emu::lockstep
