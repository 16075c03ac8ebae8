// Packet requests a second of the memory model on one core: where a tile lies, and all commands of its packet.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "asic/rdram/channel.h"
#include "asic/rdram/layout.h"

namespace gicube::emu::rdram {
namespace {

constexpr std::uint32_t kBlock = 32;
constexpr std::uint32_t kMbit = 288;
constexpr std::size_t kRequests = std::size_t{1} << 16;
constexpr std::size_t kOutstanding = 32;  // packets asked for whose data have not come

struct Request {
  std::uint32_t block, tile;
};

std::vector<Request> random_requests(std::uint32_t blocks, std::uint32_t tiles) {
  std::vector<Request> requests;
  std::uint64_t state = 1;
  const auto draw = [&state](std::uint32_t limit) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint32_t>((state >> 33) % limit);
  };
  for (std::size_t i = 0; i < kRequests; ++i) requests.push_back({draw(blocks), draw(tiles)});
  return requests;
}

std::vector<Request> sequential_requests(std::uint32_t blocks, std::uint32_t tiles) {
  std::vector<Request> requests;
  for (std::uint32_t i = 0; i < kRequests; ++i) requests.push_back({i / tiles % blocks, i % tiles});
  return requests;
}

void serve(benchmark::State& state, const Layout& layout, const std::vector<Request>& requests) {
  Channel channel(v1::RdramConfig(), layout.devices());
  Tcycle returned[kOutstanding] = {};
  Tcycle now = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < requests.size(); ++i) {
      Tcycle& slot = returned[i % kOutstanding];
      now = std::max(now, slot);
      slot = channel.read(layout.locate(requests[i].block, requests[i].tile), now).data_end;
    }
  }
  benchmark::DoNotOptimize(now);
  const ChannelCounters counters = channel.counters();
  state.SetItemsProcessed(static_cast<std::int64_t>(counters.packets_read));
  const double packets = static_cast<double>(counters.packets_read);
  state.counters["dq_use"] = static_cast<double>(counters.dq_busy) / static_cast<double>(now);
  state.counters["row_hits"] = static_cast<double>(counters.row_hits) / packets;
}

// range(0): blocks in the channel.
void rdram_random(benchmark::State& state) {
  const auto blocks = static_cast<std::uint32_t>(state.range(0));
  const Layout layout(blocks, kBlock, kMbit);
  serve(state, layout, random_requests(blocks, layout.tiles()));
}
BENCHMARK(rdram_random)->ArgName("blocks")->Arg(1)->Arg(128)->Arg(512);

void rdram_sequential(benchmark::State& state) {
  const Layout layout(128, kBlock, kMbit);
  serve(state, layout, sequential_requests(128, layout.tiles()));
}
BENCHMARK(rdram_sequential);

}  // namespace
}  // namespace gicube::emu::rdram
