// Radiosity over the links of a forest, by gathering or by shooting.
#pragma once

#include <span>
#include <vector>

#include "form_factors/exchange/elements.h"
#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

class RadiositySolver {
 public:
  explicit RadiositySolver(const Forest& forest);

  // Goes on from what it has, with these links, until the share of the emitted power that is under way is at most
  // `convergence`. Adds to `iterations`.
  // With `balance` what is uncertain of the exchange areas (uncertain_part()) is scaled until each leaf's sum closes,
  // by a factor of each leaf for what it sends and takes, so that they stay reciprocal. What is certain stays as it was
  // measured.
  void solve(std::span<const Link> links, const RadiositySettings& settings, bool balance,
             std::vector<Iteration>& iterations);

  // Radiosity of a cluster: the mean over its leaves, by weight.
  Power outgoing(std::uint32_t cluster) const;
  const Power& emitted() const { return emitted_; }  // power

  // Results of the last solve().
  void results(RadiosityResult& result) const;

 private:
  // Three channels of the links' certain parts, and three of the uncertain ones.
  using Flow = std::array<double, 6>;
  struct Parts {
    double certain = 0, uncertain = 0;  // of an exchange area
  };

  void gather(std::span<const Link> links);
  void shoot(std::span<const Link> links);
  void index(std::span<const Link> links);
  void carry(std::uint32_t link, std::uint32_t to, const Flow& what);
  void push_pull();
  void balance(std::span<const Link> links);
  void reach(std::span<const Link> links);
  std::vector<Parts> leaf_sums() const;
  Flow under_way(std::uint32_t cluster) const;
  double residual() const;

  const Forest& forest_;
  bool balance_ = false;
  Power emitted_{};
  std::vector<Power> leaf_in_, leaf_out_;
  std::vector<double> factors_;   // of leaves, from balancing
  std::vector<double> raw_sums_;  // by leaf, of its exchange areas over its weight, before balancing
  std::vector<Flow> cluster_out_;
  std::vector<Flow> sent_;            // the part of it that has gone over the cluster's own links
  std::vector<Flow> received_;        // power that came over them
  std::vector<Parts> reach_;          // sums of the cluster's own links, as the leaves at their other ends take it
  std::vector<Parts> parts_;          // by link
  std::vector<std::uint32_t> first_;  // of each cluster's own links in `own_`
  std::vector<std::uint32_t> own_;
};

// Share, 0..1, of a link's exchange area that is not certain between any two of its leaves: of leaves the noise of its
// rays, of larger clusters what its rays differ by.
double uncertain_part(const Link& link, const Forest& forest);

}  // namespace gicube::samples
