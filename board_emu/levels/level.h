// A fidelity level: traces rays to their ends, and computes how long the board needs for that.
//
// All levels compute the same values. They differ in the time that they compute: none, or cycle by cycle.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <vector>

#include "datapath/frame.h"
#include "gicube/archive.h"
#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/counter_list.h"
#include "levels/ray_source.h"
#include "words/clock.h"

namespace gicube::emu {

// Shared by the thread that runs a command and the threads that monitor it.
struct Progress {
  std::atomic<bool> cancel{false};       // set by a monitoring thread: end soon, with ErrorCode::kCancelled
  std::atomic<std::uint32_t> ticket{0};  // the command that runs, and how much of it is done
  std::atomic<std::uint32_t> done{0};
  std::atomic<std::uint32_t> all{0};

  // Set by the board; called by the cycle level on the command's thread, often during a run, whenever all counters are
  // consistent. Counts of values (visible samples, how rays end) may then include rays that are still under way,
  // because values are computed ahead. The functional level is fast and does not call it.
  std::function<void()> may_count{};
};

struct RunResult {
  Cycle cycles = 0;              // cycles of the ASIC; 0 at a level without time
  Picoseconds asic_ps = 0;       // time of these cycles
  std::uint64_t dsp_cycles = 0;  // cycles in which the DSP worked
  std::uint64_t made = 0;        // rays that the source made
  RayCounters rays;
  bool cancelled = false;
  v1::FidelityLevel answered = v1::functional;  // the level that ran it
};

// Waiting rays and served memory banks of a machine, at one moment.
struct MachineLook {
  static constexpr std::size_t kMaxCells = 65'536;  // chosen: 1024^3 voxels in blocks of 32 have 32,768

  Cycle cycle = 0;
  // A cell is a block, or a cube of 2^3, 4^3, ... blocks if the volume has more than kMaxCells blocks.
  std::uint32_t blocks_a_side = 1;
  std::array<std::uint32_t, 3> cells{};  // along x, y, z; 0: there is no machine
  // Rays in the queues of each cell, x fastest; empty if one queue holds the rays of all blocks.
  std::vector<std::uint32_t> waiting{};
  std::vector<std::uint32_t> processors{};  // rays in the queues of each processor
  std::uint32_t banks = 0;                  // banks per device
  // By memory channel, device and bank: packets read and written since the machine was created.
  std::vector<std::vector<std::uint64_t>> packets{};
};

// No part of the board has made progress for long although rays are under way; what() contains the state of every part.
class Stall : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Level {
 public:
  virtual ~Level() = default;

  // Traces the source's rays to their ends. After a run that was cancelled or that threw (RoutineFault, Stall), the
  // hardware is in the state after reset().
  virtual RunResult run(RaySource& rays, const Frame& frame, Progress& progress) = 0;

  // Drops what is cached of the volume. To be called when the volume's words have changed or the volume is gone.
  virtual void volume_changed() = 0;
  // To be called when the words that deposits go to were cleared.
  virtual void deposits_cleared() = 0;
  // Sets all state but the counters back to power-up.
  virtual void reset() = 0;

  // The ray counters of all runs.
  virtual RayCounters rays() const = 0;
  // Adds the counters of the level's hardware, if it has any.
  virtual void count(std::vector<wire::Counter>& list) const = 0;
  // Processor cycles that were computed by inner loops, many at a time, because nobody observed them. The number
  // depends on observers and checkpoints, so no checkpoint contains it.
  virtual std::uint64_t cycles_ahead() const { return 0; }
  // To be called only while all counters are consistent.
  virtual MachineLook look() const { return {}; }

  // Whether a run is under way: state() then saves it too. A level restored with such a run continues it in the next
  // run(), if it gets that run's source and frame; it throws CheckpointFault if it finds that they differ. reset() ends
  // the run.
  virtual bool in_run() const { return false; }
  // Saves the level's state, or restores it into a new level; the volume has `blocks` along x, y, z. During a run it
  // may be called from Progress::may_count() and Observer::see().
  virtual void state(Archive& archive, const std::array<int, 3>& blocks) = 0;
};

}  // namespace gicube::emu
