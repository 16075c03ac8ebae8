// What counters mean: the paper's figures by arithmetic from one measured window.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "gicube/board.h"
#include "gicube/image.h"

namespace gicube::samples::results {

// One window of a board: most often a frame.
struct Measurement {
  Counters counters;     // its growth
  Picoseconds time = 0;  // simulated, as the host sees it: with bus transfers
  int processors = 0;
  double core_hz = 0;
  Image image;         // where it was asked for
  double clipped = 0;  // of an illumination pass: the part of its energy that did not fit the irradiance words
};

// 0 where `whole` is 0: while a page is only planned, all measurements are empty.
double ratio(double part, double whole);

double frame_ms(const Measurement& m);  // as the host sees it, image transfer included
double rate_hz(const Measurement& m);
double asic_ms(const Measurement& m);  // core cycles of the window

double samples_per_second(const Measurement& m);
// Samples a pipeline cycle, 0..1.
double throughput(const Measurement& m);

// Of voxels asked for, 0..1: those that the cache held; and misses a sample, 0..8.
double hit_ratio(const Measurement& m);
double misses_a_sample(const Measurement& m);
// Shares of samples with 0, 1 .. 8 misses; they sum to 1.
std::vector<double> miss_histogram(const Measurement& m);

// 16 bytes a packet of 144 bits: the paper's unit, in which an RDRAM of 18 bit at 800 MHz gives 1.6 GB/s.
double memory_gb_s(const Measurement& m);
// Share of the time in which the memories' data pins were busy, 0..1; four tCYCLE a core cycle.
double memory_use(const Measurement& m);
// Share of it in which they stood still since reads followed writes, or writes reads, 0..1.
double memory_turnaround(const Measurement& m);

// A processor and 100 cycles: rays that it sent, and cycles in which one of its two links moved bits.
double rays_sent(const Measurement& m);
double links_busy(const Measurement& m);
// Rays of 32 bytes over the cut that halves the ring.
double bisection_mb_s(const Measurement& m);

// The mean over the processors of the part of the time in which one was busy [P §5.4]. Busy is: it holds rays; or its
// pipeline has a sample or leap in hand.
double balance_held(const Measurement& m);
double balance_working(const Measurement& m);

// How evenly the samples lie, whatever the time: the processors' mean over the maximum of one, 0..1. It bounds
// the speed-up of p such processors to p times this.
double work_balance(const Measurement& m);

double dsp_use(const Measurement& m);  // 0..1
double overflows_a_ray(const Measurement& m);

// Every pipeline cycle by its cause: name and share, which sum to 1.
std::vector<std::pair<std::string, double>> cause_shares(const Measurement& m);

// Both windows added; empty if one of them is.
Measurement sum_of(const Measurement& a, const Measurement& b);

// Of lighting passes: deposits a sample; changed tiles a deposit, and the share of them that were written together with an
// earlier change [0..1]; rays scattered a ray sent for the first time.
double deposits_a_sample(const Measurement& m);
double tiles_a_deposit(const Measurement& m);
double tiles_combined(const Measurement& m);
double scatterings_a_ray(const Measurement& m);
// memory_use() if each changed tile were written on its own and fetched first, a read and a write as [P §3.6] has it: above
// 1 the memory would hold the pipelines up.
double memory_use_uncombined(const Measurement& m);

// Samples and leaps (turns) by how many of them were taken while a queue stayed the active one.
struct Stay {
  double turns = 0;        // at least 1, 2, 4 .. and fewer than twice as many
  double activations = 0;  // share of all, 0..1
  double issued = 0;       // share of the turns, 0..1
};
std::vector<Stay> stays(const Measurement& m);
// The share of turns in stays shorter than `turns`: those shorter than the pipeline end before a ray comes round [P §5.1].
double issued_in_short_stays(const Measurement& m, double turns);

// Block loads and samples in each millisecond of the window.
struct Millisecond {
  double loads = 0, samples = 0;
};
std::vector<Millisecond> milliseconds(const Measurement& m);

struct Spread {
  double min = 0, mean = 0, max = 0;

  // "MEAN (MIN to MAX)" in this unit, with so many digits after the point.
  std::string text(double unit, int digits) const;
};
Spread spread_of(const std::vector<double>& values);

}  // namespace gicube::samples::results
