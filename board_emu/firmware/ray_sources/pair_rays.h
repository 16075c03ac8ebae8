// Rays that the DSP makes between pairs of elements, and the sums that it makes of them [P §5.6].
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/pair.h"
#include "levels/ray_source.h"

namespace gicube::emu {

struct PairJob {
  wire::PairsHeader header;
  std::vector<wire::Element> elements;
  std::vector<wire::Vector> normals;  // of the elements
  std::vector<wire::Pair> pairs;
  wire::Vector spacing{};
};

// Samples without weight are not sent.
class PairRays : public RaySource {
 public:
  // Writes wire::kPairResultBytes of each pair to `out`. All must outlive this.
  PairRays(const PairJob& job, const v1::DspConfig& dsp, std::span<std::uint8_t> out)
      : job_(job), dsp_(dsp), out_(out) {}

  std::uint64_t count() const override { return job_.pairs.size() * std::uint64_t{job_.header.rays}; }
  // Made like lighting rays, from two points of a sequence; taken back like viewing rays, into a sum.
  std::uint32_t make_cycles() const override { return dsp_.lighting_ray_cycles(); }
  std::uint32_t take_cycles() const override { return dsp_.returned_ray_cycles(); }
  std::uint64_t max_at_once() const override;

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override;
  void take(std::uint64_t i, const wire::Ray& ray) override;

  std::size_t divide(std::size_t rays) override;
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override;
  void take_batch(RayBatch& batch) override;

 private:
  struct Batch;

  wire::PairSample sample(std::size_t pair, std::uint32_t i) const;
  void write(std::size_t pair, const wire::PairSum& sum) const;
  void write_if_complete();

  const PairJob& job_;
  const v1::DspConfig& dsp_;
  std::span<std::uint8_t> out_;
  std::size_t batch_pairs_ = 1;

  // One by one: the rays of the run in hand, from `begin_` on.
  struct Measured {
    double weight = 0;
    std::uint32_t opacity = 0;
  };
  std::uint64_t begin_ = 0;
  std::vector<Measured> measured_;
  std::uint64_t dealt_with_ = 0;  // of them
};

}  // namespace gicube::emu
