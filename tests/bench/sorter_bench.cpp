// Time that the cycle level's parts between pipelines take: a sorter under recirculation load, and what idles.
#include "asic/sorter/sorter.h"

#include <benchmark/benchmark.h>

#include <array>
#include <vector>

#include "asic/link/ring.h"
#include "asic/raybus/merge_tree.h"
#include "asic/raybus/ray_bus.h"

namespace gicube::emu {
namespace {

// A pipeline of 32 stages in which a ray stays for 32 samples in a block, then goes to another of the same processor or
// is done; the bus brings a new ray every four cycles while less than `waiting` rays are in the sorter.
class Recirculation {
 public:
  Recirculation(std::uint32_t queues, std::uint64_t waiting)
      : queues_(queues),
        most_(waiting),
        sorter_({.queues = queues}, {returned_, bus_, none_, none_too_, released_}, {issue_, overflow_}) {}

  void tick() {
    ++now_;
    sorter_.tick(now_);
    Stage& stage = stages_[now_ % 32];
    if (stage.used) leave(stage.token);
    stage.used = issue_.can_pop(now_);
    if (stage.used) stage.token = issue_.pop(now_);
    if (now_ % 4 == 0 && sorter_.waiting() < most_ && bus_.can_push(now_)) {
      bus_.push(now_, {.ray = 0, .queue = next_queue(), .contribution = 4000});
    }
    if (overflow_.can_pop(now_)) overflow_.pop(now_);
  }
  const SorterCounters& counters() const { return sorter_.counters(); }

 private:
  struct Stage {
    RayToken token;
    bool used = false;
  };

  void leave(RayToken token) {  // always finds room: the sorter takes `returned` first
    if (++token.ray % 32 != 0) {
      token.has_reserved_slot = true;
      returned_.push(now_, token);
      return;
    }
    released_.push(now_, token.queue);
    if (token.ray == 32 * 8) return;  // done
    token.queue = next_queue();
    returned_.push(now_, token);
  }
  std::uint32_t next_queue() {
    random_ = random_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint32_t>(random_ >> 33) & (queues_ - 1);
  }

  std::uint32_t queues_;
  std::uint64_t most_;
  std::uint64_t random_ = 1;
  Cycle now_ = 0;
  Fifo<RayToken> returned_{4}, bus_{4}, none_{2}, none_too_{2}, issue_{2}, overflow_{2};
  Fifo<std::uint32_t> released_{4};
  std::array<Stage, 32> stages_;
  Sorter sorter_;
};

void sorter_recirculating(benchmark::State& state) {
  Recirculation loop(static_cast<std::uint32_t>(state.range(0)), static_cast<std::uint64_t>(state.range(1)));
  for (int i = 0; i < 100'000; ++i) loop.tick();
  const SorterCounters before = loop.counters();
  for (auto _ : state) loop.tick();
  const auto per_tick = [&](std::uint64_t count) {
    return benchmark::Counter(static_cast<double>(count), benchmark::Counter::kAvgIterations);
  };
  state.counters["issued"] = per_tick(loop.counters().issued - before.issued);
  state.counters["inserts"] = per_tick(loop.counters().inserts - before.inserts);
  state.counters["activations"] = per_tick(loop.counters().activations - before.activations);
}
// Queues, rays that wait: the design point half full and sparse, and one processor alone.
BENCHMARK(sorter_recirculating)->Args({128, 8192})->Args({128, 1024})->Args({128, 64})->Args({512, 16384});

void idle_board_between_pipelines(benchmark::State& state) {
  Fifo<RayToken> returned(2), bus_end(2), left(2), right(2), issue(2), overflow(2), down(2), up(2);
  Fifo<std::uint32_t> released(2), runs(2);
  Sorter sorter({}, {returned, bus_end, left, right, released}, {issue, overflow});
  std::vector<Fifo<RayToken>> fifos(24, Fifo<RayToken>(2));
  std::vector<Fifo<RayToken>*> ends, leaves;
  std::vector<Ring::Port> ports;
  for (std::size_t i = 0; i < 4; ++i) {
    ends.push_back(&fifos[i]);
    leaves.insert(leaves.end(), {&fifos[4 + i], &fifos[8 + i]});
    ports.push_back({&fifos[12 + i], &fifos[16 + i], &fifos[20 + i]});
  }
  RunPool pool(4);
  RayBus bus(down, runs, pool, ends);
  MergeTree tree(leaves, up);
  Ring ring(32, 4, ports);
  Cycle now = 0;
  for (auto _ : state) {
    ++now;
    benchmark::DoNotOptimize(sorter.tick(now));
    benchmark::DoNotOptimize(bus.tick(now));
    benchmark::DoNotOptimize(tree.tick(now));
    benchmark::DoNotOptimize(ring.tick(now));
  }
}
BENCHMARK(idle_board_between_pipelines);

// Four processors whose rays go to a neighbour: a ring that is never idle.
void ring_busy(benchmark::State& state) {
  std::vector<Fifo<RayToken>> fifos(12, Fifo<RayToken>(2));
  std::vector<Ring::Port> ports;
  for (std::size_t i = 0; i < 4; ++i) ports.push_back({&fifos[i], &fifos[4 + i], &fifos[8 + i]});
  Ring ring(32, 4, ports);
  Cycle now = 0;
  for (auto _ : state) {
    ++now;
    for (std::size_t i = 0; i < 4; ++i) {
      if (now % 16 == 0 && fifos[i].can_push(now)) {
        fifos[i].push(now, {.processor = static_cast<std::uint8_t>((i + 1 + now / 16 % 3) % 4)});
      }
      for (const std::size_t end : {4 + i, 8 + i}) {
        if (fifos[end].can_pop(now)) fifos[end].pop(now);
      }
    }
    benchmark::DoNotOptimize(ring.tick(now));
  }
}
BENCHMARK(ring_busy);

void merge_tree_busy(benchmark::State& state) {
  std::vector<Fifo<RayToken>> fifos(8, Fifo<RayToken>(2));
  std::vector<Fifo<RayToken>*> leaves;
  for (Fifo<RayToken>& fifo : fifos) leaves.push_back(&fifo);
  Fifo<RayToken> up(2);
  MergeTree tree(leaves, up);
  Cycle now = 0;
  for (auto _ : state) {
    ++now;
    Fifo<RayToken>& leaf = fifos[now % 8];
    if (now % 16 < 8 && leaf.can_push(now)) leaf.push(now, {});
    benchmark::DoNotOptimize(tree.tick(now));
    if (up.can_pop(now)) up.pop(now);
  }
}
BENCHMARK(merge_tree_busy);

}  // namespace
}  // namespace gicube::emu
