// Commands of one kind, some of which are simulated at cycle level and the others estimated.
//
// They come in blocks. One command of each block, drawn at random before any of the block is seen, is simulated. The others are
// estimated as their work (which the functional level counts) times what the last simulated ones took for their work. What the simulated
// command takes, less what it would have been estimated at, is an unbiased sample of that difference for the whole block. From these
// differences follow the interval, and from the interval the length of the next block.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "gicube/archive.h"
#include "gicube/wire/counter_list.h"

namespace gicube::emu {

// What is estimated with an interval.
enum SampledQuantity : std::size_t { kSampledCycles, kSampledPackets, kSampledMisses, kSampledQuantities };
using SampledQuantities = std::array<double, kSampledQuantities>;

// Commands, and what they took together.
struct CommandCost {
  double work = 0;  // more than 0
  SampledQuantities took{};
  double dsp_cycles = 0;
  std::vector<wire::Counter> counters{};  // by how much they grew

  void add(const CommandCost& other);
  // For another amount of work.
  CommandCost times(double factor) const;
  bool is_good() const;  // no number of a broken checkpoint
  void state(Archive& archive);
};

class SampledSeries {
 public:
  // `error`: half the interval of the cycles over all cycles, at most. Different seeds draw different commands.
  SampledSeries(double error, std::uint64_t seed) : error_(error), seed_(seed) {}

  // Whether the next command is to be simulated; then one of the two below is to be called.
  bool simulates_next();
  void simulated(const CommandCost& sample);
  // What a command of that work, more than 0, is thought to take.
  CommandCost estimate(double work);

  // Half of the interval of the sums, at 99.7%: what they differ by from those of a simulation of all commands. It never shrinks.
  const SampledQuantities& within() const { return within_; }
  void state(Archive& archive);

  static constexpr std::size_t kFirstDifferences = 8;  // chosen: before them nothing is estimated
  static constexpr std::uint32_t kMaxLength = 64;      // chosen: of a block

 private:
  static constexpr std::size_t kBasis = 4;            // chosen: simulated commands that estimates go by
  static constexpr std::size_t kMaxDifferences = 24;  // chosen: the last ones
  static constexpr std::uint32_t kBlocksALength =
      4;  // chosen: before it is doubled: so many differences have its distance

  void begin_block();
  void end_block();
  // If a block left out `more` beside what is left out by now.
  double half_width(std::size_t quantity, double more) const;

  double error_;
  std::uint64_t seed_;
  std::uint64_t blocks_ = 0;
  // The block in work: its commands, and which of them is simulated.
  std::uint32_t length_ = 0, at_ = 0, drawn_ = 0;
  std::uint32_t blocks_of_length_ = 0;
  bool first_ = true;  // no command was simulated; the first has cold caches, and no other is estimated by it
  std::deque<CommandCost> last_;               // kBasis at most
  CommandCost basis_;                          // their sum when the block began
  SampledQuantities open_{};                   // estimated in this block
  SampledQuantities off_{};                    // its relative difference, once known
  std::deque<SampledQuantities> differences_;  // relative, of simulated commands
  SampledQuantities bias_{};                   // the sum over ended blocks of what their estimates are off by
  SampledQuantities squares_{};                // the sum of the squares of what was estimated in each
  double cycles_ = 0;                          // of all commands
  SampledQuantities within_{};
};

}  // namespace gicube::emu
