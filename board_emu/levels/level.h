// A fidelity level: it takes rays to their ends, and says how long the board needs for it.
//
// Every level computes the same values. Levels differ in the time that they compute: none, every clock, or an approximation.
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

// Shared by the thread that runs a command and the threads that watch it.
struct Progress {
  std::atomic<bool> cancel{false};       // set by a watcher: end soon, with ErrorCode::kCancelled
  std::atomic<std::uint32_t> ticket{0};  // the command in work, and how much of it is done
  std::atomic<std::uint32_t> done{0};
  std::atomic<std::uint32_t> all{0};

  // The board sets it; a level calls it, on the command's thread, where all counters hold. The cycle level does so often while it
  // runs; what counts values (visible samples, how rays end) may then have rays in it that are still under way, since values are
  // computed ahead. The other levels are quick, and their counters hold at the end of a run.
  std::function<void()> may_count{};
};

struct RunResult {
  Cycle cycles = 0;              // of the ASIC; 0 at a level without time
  Picoseconds asic_ps = 0;       // the same
  std::uint64_t dsp_cycles = 0;  // in which the DSP worked
  std::uint64_t made = 0;        // rays that the source made
  RayCounters rays;
  bool cancelled = false;
  v1::FidelityLevel answered = v1::functional;  // the level that did it
};

// Where rays wait and which banks of the memory serve: one moment of a machine that has queues and banks.
struct MachineLook {
  static constexpr std::size_t kMaxCells = 65'536;  // chosen: 1024^3 voxels in blocks of 32 have 32,768

  Cycle cycle = 0;
  // A cell is a block, or a cube of 2^3, 4^3, ... where the volume has more blocks than that.
  std::uint32_t blocks_a_side = 1;
  std::array<std::uint32_t, 3> cells{};  // along x, y, z; 0: there is no machine
  // Rays in the queues of each cell, x fastest; empty: one queue has those of all blocks.
  std::vector<std::uint32_t> waiting{};
  std::vector<std::uint32_t> processors{};  // rays in the queues of each
  std::uint32_t banks = 0;                  // of a device
  // By memory channel, device and bank: packets read and written since the machine was made.
  std::vector<std::vector<std::uint64_t>> packets{};
};

// No part of the board has moved for long although rays are under way; what() describes every part.
class Stall : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Level {
 public:
  virtual ~Level() = default;

  // Takes the source's rays to their ends. After a run that was cancelled, or that threw (RoutineFault, Stall), the hardware is
  // as after reset().
  virtual RunResult run(RaySource& rays, const Frame& frame, Progress& progress) = 0;

  // To be called when the volume's words have changed or it is gone: drops what is cached of it.
  virtual void volume_changed() = 0;
  // To be called when the words that deposits go to were cleared.
  virtual void deposits_cleared() = 0;
  // Sets all state but the counters back to power-up.
  virtual void reset() = 0;

  // The ray counters of all runs.
  virtual RayCounters rays() const = 0;
  // Adds the counters of the level's hardware, if it has any.
  virtual void count(std::vector<wire::Counter>& list) const = 0;
  // Cycles of processors that were computed many at a time, since nobody observed them. It depends on observers and checkpoints, so it
  // is part of no checkpoint.
  virtual std::uint64_t cycles_ahead() const { return 0; }
  // To be called where all counters hold.
  virtual MachineLook look() const { return {}; }

  // Whether a run is under way: state() saves it too. A level to which such a run was loaded goes on with it in the next run(), whose
  // source and frame must be those of that run; it throws CheckpointFault if it finds that they are not. Or reset() ends it.
  virtual bool in_run() const { return false; }
  // Saves what the level is, or makes a new level what was saved; the volume has `blocks` along x, y, z. In a run it may be called
  // from Progress::may_count() and Observer::see().
  virtual void state(Archive& archive, const std::array<int, 3>& blocks) = 0;
};

}  // namespace gicube::emu
