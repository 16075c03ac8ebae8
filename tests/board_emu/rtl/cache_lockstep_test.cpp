// Tags, miss scheduler, pipeline stages and splat unit in SystemVerilog against asic/cache and cycle, register by
// register.
#include <Vmiss_scheduler.h>
#include <Vsplat_unit.h>
#include <Vstages.h>
#include <Vvolume_cache_32.h>
#include <Vvolume_cache_8.h>

#include <deque>

#include "asic/cache/volume_cache.h"
#include "cycle/memory_port.h"
#include "cycle/splat_unit.h"
#include "cycle/stages.h"
#include "lockstep.h"

namespace gicube::emu::lockstep {
namespace {

template <typename Model>
void run_volume_cache(std::uint32_t edge, unsigned seed) {
  constexpr std::uint32_t kBlocks = 5;
  VolumeCache cache({.block_voxels = static_cast<int>(edge)});
  Clocked<Model> rtl("volume_cache");
  const std::uint32_t across = edge / 2 + 1, bank_across = (across + 1) / 2,
                      voxel_bits = static_cast<std::uint32_t>(std::bit_width(edge - 1));
  const auto tile_bits = static_cast<std::size_t>(std::bit_width(across * across * (edge + 1) - 1));
  std::array<Register, 8> tags, valid;
  for (std::size_t bank = 0; bank < 8; ++bank) {
    const std::string path = "gen_bank[" + std::to_string(bank) + "].bank.";
    tags[bank] = rtl.find(path + "tags");
    valid[bank] = rtl.find(path + "valid");
  }
  Chance chance(seed, 3);
  CacheCounters counters;
  std::array<std::uint32_t, 3> voxel{};
  std::uint32_t block = 0;
  for (Cycle now = 0; now < cycles() / (edge > 8 ? 10 : 1); ++now) {  // the larger one has 9,537 tags to compare
    chance.next_cycle(now);
    const bool checks = chance.happens(0), clears = !checks && now % 4096 == 4095;
    if (chance.happens(1)) block = chance.below(kBlocks);
    for (std::uint32_t& at : voxel)
      at = chance.happens(2) ? chance.below(edge) : std::min(edge - 1, at + chance.below(2));
    Misses misses;
    if (checks) misses = cache.check(block, voxel);
    if (clears) cache.invalidate();

    rtl->check = checks;
    rtl->invalidate = clears;
    rtl->block = static_cast<SData>(block);
    for (std::size_t axis = 0; axis < 3; ++axis) put(rtl->voxel, axis * voxel_bits, voxel_bits, voxel[axis]);
    rtl.settle();
    ASSERT_EQ(misses.count, rtl->count) << "cycle " << now;
    const std::uint32_t voxels = 4u >> ((voxel[0] & 1) + (voxel[1] & 1));
    for (std::size_t i = 0; i < misses.count; ++i) {
      const auto tile = static_cast<std::uint32_t>(bits(rtl->tiles, i * tile_bits, tile_bits));
      ASSERT_EQ(misses.tiles[i], tile) << "cycle " << now;
      counters.filled_voxels +=
          (tile % across != across - 1 ? 2u : 1u) * (tile / across % across != across - 1 ? 2u : 1u);
    }
    if (checks) {
      ++counters.checks;
      counters.packets += rtl->count;
      counters.missed_voxels += rtl->count * voxels;
      ++counters.misses.at(rtl->count * voxels);
    }
    rtl.cycle();

    const Registers part(std::ref(cache));
    const Numbers& listed = part["tags"];
    for (std::uint32_t tile = 0; tile < listed.size(); ++tile) {
      const std::uint32_t x = tile % across, y = tile / across % across, z = tile / (across * across);
      const std::size_t bank = (x & 1) | (y & 1) << 1 | (z & 1) << 2,
                        place = (z / 2 * bank_across + y / 2) * bank_across + x / 2;
      const std::uint64_t tag = valid[bank](place, 1) != 0 ? tags[bank].of_entry(place) : 0xFFFF'FFFF;
      ASSERT_EQ(listed[tile], tag) << "tile " << tile << ", cycle " << now;
    }
    Numbers counted;
    NumbersArchive archive(false, counted);
    archive("", counters);
    ASSERT_EQ(part["counters"], counted) << "cycle " << now;
  }
  for (const std::uint64_t count : {counters.misses[0], counters.misses[1], counters.misses[8]}) EXPECT_GT(count, 0u);
}

TEST(VolumeCacheInLockstep, OfSmallBlocks) { run_volume_cache<Vvolume_cache_8>(8, 1); }
TEST(VolumeCacheInLockstep, OfThePapersBlocks) { run_volume_cache<Vvolume_cache_32>(32, 2); }

TEST(MissSchedulerInLockstep, OrdersReadsAndWrites) {
  constexpr std::size_t kPlaces = 32, kBlockBits = 9, kTileBits = 14;
  MissQueue misses(kPlaces);
  WriteQueue writes(kPlaces);
  const MemoryClient client{&misses, &writes};
  Clocked<Vmiss_scheduler> rtl("miss_scheduler");
  const Register entries = rtl.find("misses.entries"), head = rtl.find("misses.head"), size = rtl.find("misses.size"),
                 sent = rtl.find("misses.sent"), arrived = rtl.find("misses.arrived");
  const Register tiles = rtl.find("writes.entries"), first = rtl.find("writes.first"), next = rtl.find("writes.next"),
                 waiting = rtl.find("writes.waiting"), last = rtl.find("writes.last");
  // Times are the part's alone; here they come from the events of the description.
  std::deque<std::array<Cycle, 3>> read_times;  // requested, sent, arrives
  std::map<std::uint64_t, std::array<Cycle, 2>> write_times;
  Chance chance(1, 8);
  WriteCounters counters;
  Cycle latest_arrival = 0;
  std::uint64_t reads_first = 0, writes_first = 0;
  for (Cycle now = 1; now < cycles(); ++now) {
    chance.next_cycle(now);
    // The pipeline: what has been sent leaves, waiting writes are requested, a packet is taken, tiles change and are
    // requested.
    const bool all = chance.happens(0), combines = now / 4096 % 4 != 3;
    writes.settle(now);
    writes.ask(now, all);
    const bool takes = chance.happens(1) && !misses.empty() && misses.oldest().arrival <= now;
    const std::uint64_t here = static_cast<std::uint64_t>(
        std::ranges::count_if(read_times, [now](const auto& times) { return times[2] <= now; }));
    rtl->has_arrived = 0;
    if (takes) misses.take();
    const std::uint32_t block = chance.below(1 << kBlockBits), put_block = chance.below(4);
    rtl->put = rtl->in_cache = 0;
    std::array<std::uint32_t, 8> put_tiles{};
    ASSERT_EQ(writes.room() >= 16, rtl->put_has_room != 0) << "cycle " << now;
    if (chance.happens(2) && writes.room() >= 16) {
      for (std::uint32_t i = 0; i < 8; ++i) {
        put_tiles[i] = chance.below(2) * 8 + i;  // different ones
        const bool known = !chance.happens(3);
        put(rtl->put_tiles, i * kTileBits, kTileBits, put_tiles[i]);
        put(rtl->put, i, 1, chance.below(2));
        put(rtl->in_cache, i, 1, known ? 1 : 0);
        if (bits(rtl->put, i, 1) != 0) writes.put(put_block, put_tiles[i], known, combines);
      }
    }
    ASSERT_EQ(misses.room() + (takes ? 0 : 0) >= 8 + (takes ? 1 : 0), rtl->has_room != 0) << "cycle " << now;
    rtl->ask = 0;
    if (chance.happens(4) && rtl->has_room) {
      rtl->ask = static_cast<CData>(chance.below(9));
      for (std::uint32_t i = 0; i < rtl->ask; ++i) {
        const std::uint32_t tile = chance.below(1 << kTileBits);
        put(rtl->ask_tiles, i * kTileBits, kTileBits, tile);
        misses.ask(now, block, tile);
      }
    }
    rtl->ask_block = static_cast<SData>(block);
    rtl->put_block = static_cast<SData>(put_block);
    rtl->ask_all = all;
    rtl->combines = combines;
    rtl->take = takes;
    rtl->arrives = std::ranges::any_of(read_times, [now](const auto& times) { return times[2] == now; });
    rtl->send = 0;
    rtl.settle();
    ASSERT_EQ(here > 0, rtl->has_arrived != 0) << "cycle " << now;
    // The memory.
    ASSERT_EQ(client.can_send(now), rtl->can_send != 0) << "cycle " << now;
    Cycle arrival = kNoCycle;
    if (chance.happens(5) && rtl->can_send) {
      ASSERT_EQ(client.next_is_write(), rtl->is_write != 0) << "cycle " << now;
      (rtl->is_write ? writes_first : reads_first) += misses.all_sent() || writes.all_sent() ? 0 : 1;
      rtl->send = 1;
      if (rtl->is_write) {
        const TileWrite& write = writes.next();
        ASSERT_EQ((Numbers{write.block, write.tile, write.fetch}), (Numbers{rtl->block, rtl->tile, rtl->reads}));
        write_times[next()][1] = now;
        writes.send(now);
      } else {
        ASSERT_EQ((Numbers{misses.next().block, misses.next().tile, 1}), (Numbers{rtl->block, rtl->tile, rtl->reads}));
        latest_arrival = std::max(latest_arrival, now + chance.below(chance.happens(6) ? 40 : 4)) + 1;
        arrival = latest_arrival;
        misses.send(now, arrival, Delay::kTransfer);
      }
    }
    rtl.settle();
    // Times, counters.
    if (rtl->send && !rtl->is_write) {
      auto& times = read_times.at(sent());
      times[1] = now;
      times[2] = arrival;
    }
    if (takes) read_times.pop_front();
    for (std::uint32_t i = 0; i < rtl->ask; ++i) read_times.push_back({now, kNoCycle, kNoCycle});
    counters.tiles += static_cast<std::uint64_t>(std::popcount(static_cast<unsigned>(rtl->put)));
    counters.combined += static_cast<std::uint64_t>(std::popcount(static_cast<unsigned>(rtl->absorbed)));
    counters.fetches +=
        static_cast<std::uint64_t>(std::popcount(static_cast<unsigned>(rtl->put & ~rtl->absorbed & ~rtl->in_cache)));
    const std::uint64_t waited = waiting(), ended = last();
    rtl.cycle();
    for (std::uint64_t number = waited; number != waiting(); number = (number + 1) % (2 * kPlaces))
      write_times[number][0] = now;
    for (std::uint64_t number = ended; number != last(); number = (number + 1) % (2 * kPlaces))
      write_times[number] = {0, kNoCycle};

    Numbers part_reads, rtl_reads{size(), sent()};
    NumbersArchive archive(false, part_reads);
    archive.field("", [&misses](Archive::Record& record) { misses.state(record, ~0u, ~std::size_t{0}); });
    for (std::uint64_t i = 0; i < size(); ++i) {
      const std::uint64_t entry = entries.of_entry((head() + i) % kPlaces);
      rtl_reads.insert(rtl_reads.end(), {entry >> kTileBits & 0x1FF, entry & 0x3FFF, read_times[i][0], read_times[i][1],
                                         read_times[i][2], 0});
    }
    ASSERT_EQ(part_reads, rtl_reads) << "cycle " << now;
    ASSERT_EQ(static_cast<std::uint64_t>(
                  std::ranges::count_if(read_times, [now](const auto& times) { return times[2] <= now; })),
              arrived())
        << "cycle " << now;

    struct Listed {
      WriteQueue& queue;
      void state(Archive& archive) { queue.state(archive, ~0u, ~std::size_t{0}); }
    };
    const Registers part(Listed{writes});
    const auto list = [&](std::uint64_t from, std::uint64_t to) {
      Numbers out{(to - from) % (2 * kPlaces)};
      for (std::uint64_t number = from; number != to; number = (number + 1) % (2 * kPlaces)) {
        const std::uint64_t entry = tiles(number % kPlaces * 24, 24);
        out.insert(out.end(), {entry >> kTileBits & 0x1FF, entry & 0x3FFF, entry >> 23, write_times[number][0],
                               write_times[number][1]});
      }
      return out;
    };
    ASSERT_EQ(part["asked"], list(first(), waiting())) << "cycle " << now;
    ASSERT_EQ(part["waiting"], list(waiting(), last())) << "cycle " << now;
    ASSERT_EQ(part.number("sent"), (next() - first()) % (2 * kPlaces)) << "cycle " << now;
    ASSERT_EQ(part["counters"], (Numbers{counters.tiles, counters.combined, counters.fetches})) << "cycle " << now;
  }
  for (const std::uint64_t count : {counters.combined, counters.fetches, reads_first, writes_first})
    EXPECT_GT(count, 0u);
}

TEST(StagesInLockstep, WithThePapersDepth) {
  constexpr std::size_t kPrefetch = 16, kCompute = 16, kEntry = 64;
  Stages stages(kPrefetch, kCompute);
  Clocked<Vstages> rtl("stages");
  const Register prefetched = rtl.find("prefetch.entries"), packets = rtl.find("prefetch.packets"),
                 prefetching = rtl.find("prefetch.valid");
  const Register computed = rtl.find("compute.entries"), computing = rtl.find("compute.valid");
  Cycle clock = 0;
  Chance chance(1, 5);
  std::uint64_t next_ray = 0, waits = 0, full = 0;
  for (Cycle now = 0; now < cycles(); ++now) {
    chance.next_cycle(now);
    const bool stalls = chance.happens(0), arrived = chance.happens(1), taken = chance.happens(2),
               comes = chance.happens(3);
    const std::uint64_t ray = next_ray++;
    const std::uint8_t wants = chance.happens(4) ? static_cast<std::uint8_t>(chance.below(9)) : 0;
    // In the order of Processor::tick_pipeline().
    bool stalled = false, takes_packet = false, starts = false;
    const bool at_end = stages.computing() > 0 && stages.oldest_computing().ready <= clock;
    const std::uint32_t leaving = at_end ? stages.oldest_computing().token.ray : 0;
    if (at_end) {
      stalled = stalls;
      if (!stalled) stages.leave();
    }
    if (!stalled) {
      if (stages.prefetching() > 0 && stages.oldest_prefetching().ready <= now && !taken) {
        InFlight& head = stages.oldest_prefetching();
        takes_packet = head.packets > 0 && arrived;
        if (takes_packet) --head.packets;
        starts = head.packets == 0;
        if (starts) stages.start_computing(clock);
        waits += starts ? 0 : 1;
      }
      ++clock;
    }
    const bool enters = comes && stages.can_enter();
    full += stages.can_enter() ? 0 : 1;
    if (enters) {
      InFlight& entry = stages.enter(now);
      entry.token = RayToken{.ray = static_cast<std::uint32_t>(ray)};
      entry.packets = wants;
    }

    rtl->entry = ray & 0xFFFF'FFFF;
    rtl->entry_packets = wants;
    rtl->cache_taken = taken;
    rtl->has_arrived = arrived;
    rtl->enter = 0;
    rtl->stall = 0;
    rtl.settle();
    ASSERT_EQ(at_end, rtl->has_last != 0) << "cycle " << now;
    if (at_end) {
      ASSERT_EQ(leaving, rtl->last);
    }
    rtl->stall = at_end && stalls;
    rtl.settle();
    ASSERT_EQ(takes_packet, rtl->takes_packet != 0) << "cycle " << now;
    ASSERT_EQ(starts, rtl->starts != 0) << "cycle " << now;
    ASSERT_EQ(enters, comes && rtl->can_enter) << "cycle " << now;
    rtl->enter = enters;
    rtl.cycle();

    // Each ray's stage follows from the part's times; all other stages are empty.
    std::uint64_t in_prefetch = 0, in_compute = 0;
    for (std::size_t i = 0; i < stages.prefetching(); ++i) {
      const InFlight& entry = stages[stages.computing() + i];
      const std::size_t stage = std::min<std::size_t>(now + kPrefetch - entry.ready, kPrefetch - 1 - i);
      in_prefetch |= std::uint64_t{1} << stage;
      ASSERT_EQ(entry.token.ray, prefetched(stage * kEntry, kEntry)) << "cycle " << now;
      ASSERT_EQ(entry.packets, packets(4 * stage, 4)) << "cycle " << now;
    }
    for (std::size_t i = 0; i < stages.computing(); ++i) {
      const std::size_t stage = kCompute - 1 - (stages[i].ready - clock);
      in_compute |= std::uint64_t{1} << stage;
      ASSERT_EQ(stages[i].token.ray, computed(stage * kEntry, kEntry)) << "cycle " << now;
    }
    ASSERT_EQ(in_prefetch, prefetching()) << "cycle " << now;
    ASSERT_EQ(in_compute, computing()) << "cycle " << now;
  }
  EXPECT_GT(waits, 0u);
  EXPECT_GT(full, 0u);
}

TEST(SplatUnitInLockstep, TakesTheCacheAndSendsCarriers) {
  SplatUnit unit(4);
  Clocked<Vsplat_unit> rtl("splat_unit");
  Chance chance(1, 3);
  SplatCounters counters;
  for (Cycle now = 1; now < cycles(); ++now) {
    chance.next_cycle(now);
    rtl->begins = rtl->sent_carrier = 0;
    rtl.settle();
    ASSERT_EQ(unit.has_carrier(), rtl->has_carrier != 0) << "cycle " << now;
    if (chance.happens(0) && unit.has_carrier()) {
      ASSERT_EQ(unit.carrier().ray, rtl->carrier) << "cycle " << now;
      unit.sent_carrier();
      rtl->sent_carrier = 1;
      ++counters.carriers;
    }
    rtl.settle();
    ASSERT_EQ(unit.busy(now), rtl->busy != 0) << "cycle " << now;
    if (chance.happens(1) && !unit.busy(now)) {
      Splat& splat = unit.add();
      splat.tiles = static_cast<std::uint8_t>(chance.below(3));
      splat.carriers = static_cast<std::uint8_t>(chance.happens(2) ? chance.below(9) : 0);
      for (std::uint32_t i = 0; i < splat.carriers; ++i) splat.carrier[i].ray = i;
      rtl->begins = 1;
      rtl->has_tiles = splat.tiles > 0;
      rtl->carriers = splat.carriers;
      counters.deposits += rtl->has_tiles;
      unit.begin(now);
    }
    rtl.settle();
    ASSERT_EQ(unit.takes_cache(now), rtl->takes_cache != 0) << "cycle " << now;
    rtl.cycle();
  }
  EXPECT_EQ(unit.counters().deposits, counters.deposits);
  EXPECT_EQ(unit.counters().carriers, counters.carriers);
  EXPECT_GT(counters.carriers, 0u);
}

}  // namespace
}  // namespace gicube::emu::lockstep
