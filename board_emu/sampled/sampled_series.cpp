#include "sampled/sampled_series.h"

#include <algorithm>
#include <cmath>

#include "gicube/wire/mix64.h"
#include "levels/counters.h"

namespace gicube::emu {

namespace {

// Student's t at 99.7%, two-sided, of 7 degrees of freedom and more.
constexpr std::array kStudent{4.442, 4.199, 4.024, 3.892, 3.789, 3.706, 3.639, 3.583, 3.535,
                              3.494, 3.459, 3.428, 3.401, 3.376, 3.355, 3.335, 3.318};

// Two dozen differences do not show what happens rarely: their root mean square counts as so much at least. Chosen.
constexpr double kMinDifference = 0.01;
// Of the interval asked for, that blocks are as long as possible within. Chosen: differences to come may be larger.
constexpr double kMargin = 0.85;

// A command of more than so many times the work of those that it is estimated by, or so much less, is not of their kind. Chosen.
constexpr double kUnlike = 2;

// Of what a checkpoint may say; squares of cycles are below it.
constexpr double kMost = 1e36;

template <typename Value>
void deque_state(Archive& archive, std::string_view name, std::deque<Value>& list, std::size_t most) {
  std::uint64_t size = list.size();
  archive.at_most(std::string(name) + "_size", size, most);
  list.resize(static_cast<std::size_t>(size));
}

}  // namespace

void CommandCost::add(const CommandCost& other) {
  work += other.work;
  for (std::size_t q = 0; q < kSampledQuantities; ++q) took[q] += other.took[q];
  dsp_cycles += other.dsp_cycles;
  add_counters(other.counters, counters);
}

CommandCost CommandCost::times(double factor) const {
  CommandCost scaled{.work = work * factor, .dsp_cycles = dsp_cycles * factor, .counters = counters};
  for (std::size_t q = 0; q < kSampledQuantities; ++q) scaled.took[q] = took[q] * factor;
  for (wire::Counter& counter : scaled.counters) {
    counter.value =
        static_cast<std::uint64_t>(std::llround(std::min(static_cast<double>(counter.value) * factor, 1e18)));
  }
  return scaled;
}

bool CommandCost::is_good() const {
  const auto good = [](double value) { return value >= 0 && value <= kMost; };
  return good(work) && good(dsp_cycles) && std::ranges::all_of(took, good);
}

void CommandCost::state(Archive& archive) {
  archive.field("sums", [this](Archive::Record& record) { record(work, took, dsp_cycles); });
  counters_state(archive, "counters", counters);
}

double SampledSeries::half_width(std::size_t quantity, double more) const {
  if (open_[quantity] + more + squares_[quantity] == 0) return 0;
  double sum = 0;
  for (const SampledQuantities& difference : differences_) sum += difference[quantity] * difference[quantity];
  const double typical = std::max(std::sqrt(sum / static_cast<double>(differences_.size())), kMinDifference);
  const double squares = squares_[quantity] + open_[quantity] * open_[quantity] + more * more;
  return std::abs(bias_[quantity] + open_[quantity] * off_[quantity]) +
         kStudent[differences_.size() - kFirstDifferences] * typical * std::sqrt(squares);
}

void SampledSeries::begin_block() {
  basis_ = {};
  for (const CommandCost& sample : last_) basis_.add(sample);
  std::uint32_t length = 1;
  if (differences_.size() >= kFirstDifferences) {
    const bool grows = blocks_of_length_ >= kBlocksALength;
    const double each = basis_.took[kSampledCycles] / static_cast<double>(last_.size());
    length = std::min(grows ? 2 * length_ : length_, kMaxLength);
    const double before = half_width(kSampledCycles, 0) / cycles_;
    // Whether the interval stays well below what it may be; or a larger one shrinks by this block.
    const auto fits = [&](std::uint32_t commands) {
      const double all = cycles_ + commands * each, after = half_width(kSampledCycles, (commands - 1) * each) / all;
      return after <= kMargin * error_ || after < before * (1 - commands * each / all / 2);
    };
    while (length > 1 && !fits(length)) length /= 2;
  }
  blocks_of_length_ = length == length_ ? blocks_of_length_ + 1 : 1;
  length_ = length;
  at_ = 0;
  drawn_ = static_cast<std::uint32_t>(wire::mix64(seed_ ^ wire::mix64(++blocks_)) % length);
}

void SampledSeries::end_block() {
  for (std::size_t q = 0; q < kSampledQuantities; ++q) {
    bias_[q] += open_[q] * off_[q];
    squares_[q] += open_[q] * open_[q];
  }
  open_ = off_ = {};
  at_ = length_;
}

bool SampledSeries::simulates_next() {
  if (at_ == length_) begin_block();
  return at_ == drawn_;
}

void SampledSeries::simulated(const CommandCost& sample) {
  cycles_ += sample.took[kSampledCycles];
  if (!last_.empty()) {
    const CommandCost thought = basis_.times(sample.work / basis_.work);
    for (std::size_t q = 0; q < kSampledQuantities; ++q) {
      const bool known = thought.took[q] > 0;
      off_[q] = known ? sample.took[q] / thought.took[q] - 1 : sample.took[q] > 0 ? 1 : 0;
    }
    differences_.push_back(off_);
    if (differences_.size() > kMaxDifferences) differences_.pop_front();
  }
  if (!first_) last_.push_back(sample);
  first_ = false;
  if (last_.size() > kBasis) last_.pop_front();
  if (++at_ == length_) end_block();
}

CommandCost SampledSeries::estimate(double work) {
  CommandCost sample = basis_.times(work / basis_.work);
  cycles_ += sample.took[kSampledCycles];
  for (std::size_t q = 0; q < kSampledQuantities; ++q) {
    open_[q] += sample.took[q];
    within_[q] = std::max(within_[q], half_width(q, 0));
  }
  const double alike = basis_.work / static_cast<double>(last_.size());
  const bool unlike = work > alike * kUnlike || work * kUnlike < alike;
  if (++at_ == length_ || unlike) end_block();
  if (unlike) length_ = at_ = 1;
  return sample;
}

void SampledSeries::state(Archive& archive) {
  archive.field("plan", [this](Archive::Record& record) {
    record(blocks_);
    record.at_most(length_, kMaxLength);
    record.at_most(at_, length_);
    record.at_most(drawn_, kMaxLength);
    record(blocks_of_length_, first_);
    record(open_, off_, bias_, squares_, cycles_, within_);
  });
  deque_state(archive, "last", last_, kBasis);
  archive.parts("last", last_);
  archive("basis", basis_);
  deque_state(archive, "differences", differences_, kMaxDifferences);
  archive.field("differences", [this](Archive::Record& record) {
    for (SampledQuantities& difference : differences_) record(difference);
  });
  const auto good = [](const SampledQuantities& values, double least) {
    return std::ranges::all_of(values, [least](double value) { return value >= least && value <= kMost; });
  };
  bool numbers = good(open_, 0) && good(off_, -kMost) && good(bias_, -kMost) && good(squares_, 0) && good(within_, 0) &&
                 cycles_ >= 0 && cycles_ <= kMost && basis_.is_good();
  for (const CommandCost& each : last_) numbers = numbers && each.is_good() && each.work > 0;
  for (const SampledQuantities& each : differences_) numbers = numbers && good(each, -kMost);
  archive.expect(numbers, "plan", "finite numbers", blocks_);
  const bool none = length_ <= 1 && open_ == SampledQuantities{} && squares_ == SampledQuantities{};
  const bool knows = differences_.size() >= kFirstDifferences && !last_.empty() && basis_.work > 0;
  archive.expect(none || knows, "plan", "no estimates before there are differences", length_);
}

}  // namespace gicube::emu
