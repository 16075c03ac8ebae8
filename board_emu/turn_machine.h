// The board's time at the approximate level: DSP, processors, links and memories in turns and rays instead of cycles.
//
// Each part has a clock of its own; the one that is furthest behind goes on, up to a little beyond the next. So what one
// part sends another may come a little late in its order; that, and what turn_processor.h leaves out, is the error.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "board.h"
#include "gicube/wire/counter_list.h"
#include "machine.h"
#include "partition.h"
#include "turn_processor.h"

namespace gicube::emu {

// Rays whose values are known, and what they cost the DSP.
class TurnWork {
 public:
  virtual ~TurnWork() = default;

  virtual std::uint64_t count() const = 0;
  // Rays [begin, begin + out.size()), called once for each, in order. One without steps is made, but not sent.
  virtual void make(std::uint64_t begin, std::span<TurnRay> out) = 0;
  // As RayWork.
  virtual std::uint64_t row_end(std::uint64_t i) const = 0;
  virtual std::uint32_t make_cycles() const = 0;
  virtual std::uint32_t take_cycles() const = 0;
};

class TurnMachine {
 public:
  // For volumes of `blocks` along x, y, z.
  TurnMachine(const v1::BoardConfig& config, const std::array<int, 3>& blocks);
  TurnMachine(const TurnMachine&) = delete;  // its processors point at it
  TurnMachine& operator=(const TurnMachine&) = delete;

  Ran run(TurnWork& work, const Frame& frame, Work& progress);

  void invalidate_caches();
  const std::array<int, 3>& blocks() const { return blocks_; }
  // By the cycle level's names, those that there are.
  void count(std::vector<wire::Counter>& list) const;

 private:
  // DSP cycles in units of core cycles.
  struct Dsp {
    double now = 0;
    std::uint64_t made = 0, sent = 0, taken = 0, overflows = 0, busy = 0;
    std::deque<TurnRay> kept;  // overflowed rays
  };

  void dsp_works(std::uint64_t cycles);
  void make_rays(TurnWork& work);
  void send(const TurnRay& ray);
  void run_bus();
  bool dsp_acts(TurnWork& work);
  TurnRay& next_made(TurnWork& work);

  v1::BoardConfig config_;
  std::array<int, 3> blocks_;
  Partition partition_;
  double ratio_;  // core cycles a DSP cycle
  LongQueue<Coming> up_;
  std::vector<std::unique_ptr<TurnMemory>> memories_;
  std::vector<std::unique_ptr<TurnProcessor>> processors_;
  Dsp dsp_;
  std::uint64_t count_ = 0;     // of the work in hand
  std::vector<TurnRay> chunk_;  // of it, made
  std::uint64_t chunk_begin_ = 0;
  struct OnBus {
    std::uint8_t processor = 0;
    Coming ray;
  };
  LongQueue<OnBus> bus_;  // rays behind one that a processor can't take yet
  bool held_ = false;     // there is
  Cycle bus_free_ = 0;    // when the last that was left
  BlockGrid grid_;
  Cycle now_ = 0;
};

}  // namespace gicube::emu
