// Rays that the DSP generates between pairs of elements, and the sums of their results [P §5.6].
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gicube/wire/pair.h"
#include "levels/ray_source.h"

namespace gicube::emu {

struct PairJob {
  wire::PairsHeader header;
  std::vector<wire::Element> elements;
  std::vector<wire::Vector> normals;  // one per element
  std::vector<wire::Pair> pairs;
  wire::Vector spacing{};
};

// In words of 32 bits. Four numbers of a scrambled sequence (as for a lighting ray); two points (each 3 products of 3
// with two edges); the segment, its length and reciprocal; two cosines (3 products of 2 each), their product with the
// area's share. The packet as for a lighting ray.
inline constexpr DspLoop kMakePairRay{"ray of a pair", 4 * 4 * 3 + 2 * 6 * 3 + 3 * 3 + 5 + 2 * 6 + 4,
                                      4 * 20 + 2 * 9 + 3 + 2 + 7 + 2 * 4 + 12, 4 + 2 * 9 + 1 + 8};
// Opacity and weight of the ray; a product of 32 by 32 bits, and the sums of it and of its square.
inline constexpr DspLoop kAddToPair{"sum of a pair", 2 * 3, 12, 6};

// Rays of samples with weight 0 are not sent.
class PairRays : public RaySource {
 public:
  // Writes wire::kPairResultBytes per pair to `out`. All parameters must outlive this object.
  PairRays(const PairJob& job, std::span<std::uint8_t> out) : job_(job), out_(out) {}

  std::uint64_t count() const override { return job_.pairs.size() * std::uint64_t{job_.header.rays}; }
  DspTask making(std::uint64_t i) const override {
    DspTask task{.loop = &kMakePairRay};
    if (i % job_.header.rays != 0) return task;
    const wire::Pair& pair = job_.pairs[i / job_.header.rays];
    for (const std::uint64_t element : {pair.a, pair.b}) {
      task.with({sdram_map::kTables + element * kElementBytes, kElementBytes, SdramUse::Kind::kRead});
    }
    return task;
  }
  DspTask taking(std::uint64_t i) const override {
    DspTask task{.loop = &kAddToPair};
    if (i % job_.header.rays != 0) return task;
    return task.with({sdram_map::kBatch + i / job_.header.rays * wire::kPairResultBytes, wire::kPairResultBytes,
                      SdramUse::Kind::kWrite});
  }
  std::uint64_t max_at_once() const override {
    return std::max<std::uint64_t>(1, kRaysAtOnce / job_.header.rays) * job_.header.rays;
  }

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters&) override {
    if (measured_.empty()) {
      begin_ = i;
      measured_.resize(static_cast<std::size_t>(std::min(max_at_once(), count() - i)));
    }
    const auto pair = static_cast<std::size_t>(i / job_.header.rays);
    const wire::PairSample made = sample(pair, static_cast<std::uint32_t>(i % job_.header.rays));
    measured_[i - begin_].weight = made.weight;
    if (made.weight > 0) return wire::segment_packet(made.from, made.to, job_.pairs[pair].id);
    ++dealt_with_;
    write_if_complete();
    return std::nullopt;
  }
  void take(std::uint64_t i, const wire::Ray& ray) override {
    measured_[i - begin_].opacity = ray.opacity;
    ++dealt_with_;
    write_if_complete();
  }

  void state(Archive::Record& record, std::uint64_t begin) override {
    record(out_);
    record.list(measured_, kRaysAtOnce);
    record(dealt_with_);
    begin_ = begin;
    const std::uint64_t all = begin < count() ? std::min(max_at_once(), count() - begin) : 0;
    record.expect(measured_.empty() || measured_.size() == all, std::to_string(all) + " rays", measured_.size());
  }

  std::size_t divide(std::size_t) override {
    batch_pairs_ = std::max<std::size_t>(1, kBatchRays / job_.header.rays);
    return (job_.pairs.size() + batch_pairs_ - 1) / batch_pairs_;
  }
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override {
    auto batch = std::make_unique<Batch>();
    batch->begin = b * batch_pairs_;
    const std::size_t end = std::min(batch->begin + batch_pairs_, job_.pairs.size());
    batch->samples.reserve((end - batch->begin) * job_.header.rays);
    batch->room.reserve((end - batch->begin) * job_.header.rays);
    for (std::size_t pair = batch->begin; pair < end; ++pair) {
      for (std::uint32_t i = 0; i < job_.header.rays; ++i) {
        const wire::PairSample made = sample(pair, i);
        batch->samples.push_back({made.weight});
        if (made.weight > 0) batch->room.push_back(wire::segment_packet(made.from, made.to, job_.pairs[pair].id));
      }
    }
    batch->rays = batch->room;
    return batch;
  }
  void take_batch(RayBatch& taken) override {
    auto& batch = static_cast<Batch&>(taken);
    auto ray = batch.rays.begin();
    for (Measured& each : batch.samples) {
      if (each.weight > 0) each.opacity = (ray++)->opacity;
    }
    write(batch.begin, batch.samples);
  }

 private:
  static constexpr std::uint64_t kRaysAtOnce = 65'536;  // chosen: rays in the DSP's memory between two runs of the ASIC
  static constexpr std::size_t kBatchRays = 2'048;      // chosen: fit into a thread's cache

  static constexpr std::uint32_t kElementBytes = 64;  // in the SDRAM, including the normal

  struct Measured {
    double weight = 0;
    std::uint32_t opacity = 0;

    void state(Archive::Record& record) { record(weight, opacity); }
  };
  // Whole pairs, with all their samples.
  struct Batch : RayBatch {
    std::size_t begin = 0;
    std::vector<Measured> samples;
  };

  wire::PairSample sample(std::size_t pair, std::uint32_t i) const {
    const wire::Pair& of = job_.pairs[pair];
    return wire::pair_sample(job_.elements[of.a], job_.elements[of.b], {job_.normals[of.a], job_.normals[of.b]},
                             job_.spacing, of.id, job_.header.seed, job_.header.first + i);
  }
  // Writes the results of the pairs from `pair` on. Rays return in any order, but sums of doubles must be computed in
  // the samples' order.
  void write(std::size_t pair, std::span<const Measured> samples) const {
    for (std::size_t at = 0; at < samples.size(); ++pair) {
      wire::PairSum sum(job_.header.rays);
      for (std::uint32_t i = 0; i < job_.header.rays; ++i, ++at) {
        sum.add(i, samples[at].weight, 1 - samples[at].opacity / double{wire::kOpacityOne});
      }
      wire::encode(sum.result(), out_.subspan(pair * wire::kPairResultBytes));
    }
  }
  void write_if_complete() {
    if (dealt_with_ < measured_.size()) return;
    write(static_cast<std::size_t>(begin_ / job_.header.rays), measured_);
    measured_.clear();
    dealt_with_ = 0;
  }

  const PairJob& job_;
  std::span<std::uint8_t> out_;
  std::size_t batch_pairs_ = 1;

  // Ray by ray: the rays of the current run, from `begin_` on.
  std::uint64_t begin_ = 0;
  std::vector<Measured> measured_;
  std::uint64_t dealt_with_ = 0;  // number of completed rays
};

}  // namespace gicube::emu
