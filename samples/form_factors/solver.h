// Radiosity over the links of a forest, by gathering or by shooting.
#pragma once

#include <span>
#include <vector>

#include "form_factors/elements.h"
#include "form_factors/radiosity.h"

namespace gicube::samples {

class RadiositySolver {
 public:
  // `balance`: scales what leaves send and take, each by a factor of its own, until the links' sums close (as the smoothing
  // of exchange areas in the zonal method); they stay reciprocal.
  RadiositySolver(const Forest& forest, bool balance);

  // Goes on from what it has, with these links, until the share of the emitted power that is under way is at most
  // `convergence`. Adds to `iterations`.
  void solve(std::span<const Link> links, Solver solver, double convergence, int most_iterations,
             std::vector<Iteration>& iterations);

  // Radiosity of a cluster: the mean over its leaves, by weight.
  const Power& outgoing(std::uint32_t cluster) const { return cluster_out_[cluster]; }
  const Power& emitted() const { return emitted_; }  // power

  // Of the last solve().
  void results(RadiosityResult& result) const;

 private:
  void gather(std::span<const Link> links);
  void shoot(std::span<const Link> links);
  void index(std::span<const Link> links);
  void reach(std::span<const Link> links);
  std::vector<double> leaf_sums() const;
  void balance(std::span<const Link> links);
  void push_pull();
  double under_way(std::uint32_t cluster, std::size_t channel) const {
    return reach_[cluster] * (cluster_out_[cluster][channel] - sent_[cluster][channel]);
  }
  double residual() const;

  const Forest& forest_;
  bool balance_;
  Power emitted_{};
  std::vector<Power> leaf_in_, leaf_out_;
  std::vector<Power> cluster_out_;
  std::vector<Power> sent_;      // the part of it that has gone over the cluster's own links
  std::vector<Power> received_;  // power that came over them
  std::vector<double> factors_;  // of leaves, from balancing
  std::vector<double> reach_;  // sum of the exchange areas of its own links, as the leaves at their other ends take it
  std::vector<double> raw_sums_;      // by leaf, of its exchange areas over its weight, before balancing
  std::vector<std::uint32_t> first_;  // of each cluster's own links in `own_`
  std::vector<std::uint32_t> own_;
};

}  // namespace gicube::samples
