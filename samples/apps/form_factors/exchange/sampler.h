// Estimates links from pairs that the board traces.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "form_factors/exchange/box_factor.h"
#include "form_factors/exchange/elements.h"
#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

struct SampledLink {
  Link link;
  std::uint32_t next = 0;                    // first unused sample
  double first_error = 0, first_spread = 0;  // of the first estimate, which decides on more rays and on division
  bool measured = false;                     // after the estimate that decided whether to divide it
};

// A full cluster is one element for the board: k rays between two of them connect k points that fill both uniformly.
// BoxFactors has their geometric factor; the rays measure the share that arrives. Near clusters in an open and nearly
// uniform medium need no rays. For other clusters it draws members, uniformly in the cumulative sum of their measures:
// the mean over members is an unbiased estimate of the sum over all of them.
class LinkSampler {
 public:
  LinkSampler(Board& board, const Forest& forest, const Contents& contents, const RadiositySettings& settings,
              RadiosityStatistics& statistics);

  // Estimates each link anew with `rays` new samples; leaves that need no rays use none.
  void estimate(std::span<SampledLink* const> links, int rays);

  // Physical distance of two boxes, and the longest edge of both.
  struct Place {
    double gap = 0, size = 0;
    bool near() const { return gap <= size; }      // chosen
    bool touch() const { return 2 * gap < size; }  // chosen: a few rays cannot sample 1/r^2 there
  };
  Place place_of(const Cluster& a, const Cluster& b) const;

 private:
  using Links = std::span<SampledLink* const>;
  void full_pairs(Links links, int rays);
  void member_pairs(Links links, int rays);
  std::vector<PairFactor> ask(std::span<const ElementPair> pairs, const PairRequest& request);
  std::uint32_t member(const Cluster& cluster, double share) const;
  bool conclude_without_rays(SampledLink& sampled);
  void conclude(SampledLink& sampled, const PairFactor& mean, int rays);
  std::optional<double> near_factor(const Cluster& a, const Cluster& b);

  Board& board_;
  const Forest& forest_;
  const Contents& contents_;
  const RadiositySettings& settings_;
  RadiosityStatistics& statistics_;
  BoxFactors box_factors_;
  std::vector<Element> elements_;  // leaves, then clusters
};

}  // namespace gicube::samples
