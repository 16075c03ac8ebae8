#include "firmware/ray_sources/pair_rays.h"

#include <algorithm>

namespace gicube::emu {

namespace {

constexpr std::uint64_t kRaysAtOnce = 65'536;  // chosen: rays in the DSP's memory between two runs of the ASIC
constexpr std::size_t kBatchRays = 2'048;      // chosen: in a thread's cache

double transparency(std::uint32_t opacity) { return 1 - opacity / double{wire::kOpacityOne}; }

}  // namespace

// Whole pairs, with the weights of all samples.
struct PairRays::Batch : RayBatch {
  std::size_t begin = 0, end = 0;
  std::vector<double> weights;
};

wire::PairSample PairRays::sample(std::size_t pair, std::uint32_t i) const {
  const wire::Pair& of = job_.pairs[pair];
  return wire::pair_sample(job_.elements[of.a], job_.elements[of.b], {job_.normals[of.a], job_.normals[of.b]},
                           job_.spacing, of.id, job_.header.seed, job_.header.first + i);
}

void PairRays::write(std::size_t pair, const wire::PairSum& sum) const {
  wire::encode(sum.result(), out_.subspan(pair * wire::kPairResultBytes));
}

std::uint64_t PairRays::max_at_once() const {
  return std::max<std::uint64_t>(1, kRaysAtOnce / job_.header.rays) * job_.header.rays;
}

std::optional<wire::Ray> PairRays::make(std::uint64_t i, RayCounters&) {
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

void PairRays::take(std::uint64_t i, const wire::Ray& ray) {
  measured_[i - begin_].opacity = ray.opacity;
  ++dealt_with_;
  write_if_complete();
}

// Rays come back in any order, and sums of doubles are made in the samples' order.
void PairRays::write_if_complete() {
  if (dealt_with_ < measured_.size()) return;
  std::size_t pair = static_cast<std::size_t>(begin_ / job_.header.rays), at = 0;
  for (; at < measured_.size(); ++pair) {
    wire::PairSum sum(job_.header.rays);
    for (std::uint32_t i = 0; i < job_.header.rays; ++i, ++at) {
      sum.add(i, measured_[at].weight, transparency(measured_[at].opacity));
    }
    write(pair, sum);
  }
  measured_.clear();
  dealt_with_ = 0;
}

std::size_t PairRays::divide(std::size_t) {
  batch_pairs_ = std::max<std::size_t>(1, kBatchRays / job_.header.rays);
  return (job_.pairs.size() + batch_pairs_ - 1) / batch_pairs_;
}

std::unique_ptr<RayBatch> PairRays::make_batch(std::size_t b) {
  auto batch = std::make_unique<Batch>();
  batch->begin = b * batch_pairs_;
  batch->end = std::min(batch->begin + batch_pairs_, job_.pairs.size());
  batch->weights.reserve((batch->end - batch->begin) * job_.header.rays);
  batch->room.reserve((batch->end - batch->begin) * job_.header.rays);
  for (std::size_t pair = batch->begin; pair < batch->end; ++pair) {
    for (std::uint32_t i = 0; i < job_.header.rays; ++i) {
      const wire::PairSample made = sample(pair, i);
      batch->weights.push_back(made.weight);
      if (made.weight > 0) batch->room.push_back(wire::segment_packet(made.from, made.to, job_.pairs[pair].id));
    }
  }
  batch->rays = batch->room;
  return batch;
}

void PairRays::take_batch(RayBatch& taken) {
  const auto& batch = static_cast<const Batch&>(taken);
  auto ray = batch.rays.begin();
  auto weight = batch.weights.begin();
  for (std::size_t pair = batch.begin; pair < batch.end; ++pair) {
    wire::PairSum sum(job_.header.rays);
    for (std::uint32_t i = 0; i < job_.header.rays; ++i, ++weight) {
      sum.add(i, *weight, transparency(*weight > 0 ? (ray++)->opacity : 0));
    }
    write(pair, sum);
  }
}

}  // namespace gicube::emu
