// The board's time at the approximate level: DSP, processors, links and memories in passes and rays instead of cycles.
//
// Each part has a clock of its own; the one that is furthest behind goes on, up to a little beyond the next. So what one
// part sends another may come a little late in its order; that, and what pass_processor.h leaves out, is the error.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "asic/partition.h"
#include "dsp/dsp.h"
#include "dsp/overflow_store.h"
#include "gicube/wire/counter_list.h"
#include "levels/level.h"
#include "pass_processor.h"

namespace gicube::emu {

class TracedPasses;

// Makes the rays of `work` in chunks.
class RayPrefetcher {
 public:
  RayPrefetcher(TracedPasses& work, bool ahead);
  PassRay& next();

 private:
  void begin_chunk();

  TracedPasses& work_;
  bool ahead_;
  std::uint64_t begun_ = 0;  // rays in all chunks until now
  std::size_t at_ = 0;
  std::vector<PassRay> chunk_, coming_;
  std::future<void> making_;  // of what is coming; waits for it when it goes
};

class PassMachine {
 public:
  // For volumes of `blocks` along x, y, z.
  PassMachine(const v1::BoardConfig& config, const std::array<int, 3>& blocks);
  // Whether it has a model of such a board's sorter. Where it has none, the cycle level is to answer.
  static bool covers(const v1::BoardConfig& config);
  PassMachine(const PassMachine&) = delete;  // its processors point at it
  PassMachine& operator=(const PassMachine&) = delete;

  // Of the result the time, and whether it was cancelled. `ahead`: a thread of its own makes rays while passes are worked off.
  RunResult run(TracedPasses& work, const Frame& frame, Progress& progress, bool ahead);

  void invalidate_caches();
  const std::array<int, 3>& blocks() const { return blocks_; }
  // By the cycle level's names, those that there are.
  void count(std::vector<wire::Counter>& list) const;
  // Between two runs.
  void state(Archive& archive);

 private:
  // What the DSP is at, as RayEngine of the cycle level.
  struct Engine {
    Cycle now = 0;
    DspCycle free = 0;
    std::uint32_t batch = 0;
    bool sends_again = false;
    std::uint64_t made = 0, sent = 0, taken = 0, overflows = 0, under_way = 0;
  };

  // A ray on the bus.
  struct OnBus {
    std::uint8_t processor = 0;
    bool first = true;      // alone, or of its run
    std::uint32_t run = 0;  // 0: alone
    Arrival ray;
  };
  // A processor's run buffers.
  struct Listener {
    std::uint64_t sent = 0;               // rays in all
    std::uint32_t making = 0, made = 0;   // the latest run that the DSP made with rays for it, and how many those are
    std::uint32_t run = 0;                // the latest sent
    std::array<std::uint64_t, 2> ends{};  // how many it had been sent after the last but one and after the last of them

    void state(Archive::Record& record) { record(sent, making, made, run, ends); }
  };

  void dsp_works(const DspTask& task);
  void make_rays(TracedPasses& work);
  void make_ray_that_is_there(TracedPasses& work);
  void launch(PassRay& ray, std::uint64_t index, std::uint32_t run, bool first);
  bool scatter(std::uint32_t handle);
  void send_again();
  void send(std::uint32_t handle, std::uint32_t run, bool first, bool has_slot = false);
  bool may_make() const { return engine_.made < count_ && engine_.under_way < may_be_under_way_; }
  std::size_t list_of(std::uint8_t processor, std::uint32_t queue) const {
    return processor * std::max<std::size_t>(1, partition_.max_blocks()) + queue;
  }
  void take_back(TracedPasses& work);
  PassProcessor* holds(const OnBus& next) const;
  void hand_on(const OnBus& next);
  void run_bus();
  bool dsp_acts(TracedPasses& work);
  bool send_first(Cycle before);

  v1::BoardConfig config_;
  std::array<int, 3> blocks_;
  Partition partition_;
  std::uint64_t core_khz_, dsp_khz_;
  PassTree up_;
  PassRays rays_;
  dram::Standard standard_;  // of the memories
  std::vector<std::unique_ptr<PassMemory>> memories_;
  std::vector<std::unique_ptr<PassProcessor>> processors_;
  Dsp dsp_;
  OverflowStore store_;
  Engine engine_;
  std::vector<std::uint64_t> index_of_;  // by handle: which ray of the work it is
  std::uint64_t count_ = 0;              // of the work in hand
  std::uint64_t may_be_under_way_ = 0;   // of its rays
  std::optional<RayPrefetcher> maker_;   // of it
  std::uint32_t runs_ = 0;
  std::vector<Listener> listeners_;   // by processor
  LongQueue<OnBus> bus_;              // behind what a processor can't take yet
  std::size_t sends_ = 0;             // on it: rays alone and runs
  PassProcessor* holding_ = nullptr;  // that processor
  Cycle bus_free_ = 0;                // when the last that was held left
  BlockGrid grid_;
  bool jitter_ = false;       // of its frame
  bool caches_sums_ = false;  // what the caches have, instead of voxels
  Cycle now_ = 0;
};

}  // namespace gicube::emu
