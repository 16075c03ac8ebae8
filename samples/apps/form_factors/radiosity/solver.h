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

  // Continues from the last radiosities, with these links, until the share of the emitted power in transit is at most
  // `convergence`. Adds to `iterations`. `balance` scales the uncertain_part() of the exchange areas by factors of the
  // leaves at both ends, which keeps them reciprocal, until each leaf's sum closes. Certain parts stay as measured.
  void solve(std::span<const Link> links, const RadiositySettings& settings, bool balance,
             std::vector<Iteration>& iterations);

  // Radiosity of a cluster: the mean over its leaves, by weight.
  Power outgoing(std::uint32_t cluster) const;
  const Power& emitted() const { return emitted_; }  // power

  // Results of the last solve().
  void results(RadiosityResult& result) const;

 private:
  // Three channels for the links' certain parts, and three for the uncertain ones.
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
  std::vector<Flow> sent_;      // part of it sent over the cluster's own links
  std::vector<Flow> received_;  // power received over them
  std::vector<Parts> reach_;    // sums of the cluster's own links, with the factors of the leaves at their other ends
  std::vector<Parts> parts_;    // by link
  std::vector<std::uint32_t> first_;  // of each cluster's own links in `own_`
  std::vector<std::uint32_t> own_;
};

// Share, 0..1, of a link's exchange area that is uncertain between two of its leaves: for leaves the noise of its rays,
// for larger clusters the spread of its rays.
double uncertain_part(const Link& link, const Forest& forest);

}  // namespace gicube::samples
