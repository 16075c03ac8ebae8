// Which links there are: the hierarchy's, refined where they may misplace much power, or all pairs of leaves.
#pragma once

#include <vector>

#include "form_factors/exchange/sampler.h"
#include "form_factors/radiosity/solver.h"

namespace gicube::samples {

class LinkSet {
 public:
  // Begins with links of all roots, or of all leaves' clusters, each with a first guess.
  LinkSet(const Forest& forest, LinkSampler& sampler, const RadiositySettings& settings,
          RadiosityStatistics& statistics, const RadiosityProgress& progress);

  // Divides the links that may misplace more than `error` of the emitted power with the solver's radiosities, and measures
  // those that are left: more exactly where nothing is left to be divided. False if there was nothing to do.
  bool refine(const RadiositySolver& solver, double error);

  std::vector<Link> links() const;

 private:
  void add(std::uint32_t a, std::uint32_t b, std::vector<SampledLink>& to) const;
  void divide(const SampledLink& sampled, std::vector<SampledLink>& to) const;
  void guess(std::vector<SampledLink>& links);
  bool divisible(const Link& link) const;
  bool measure(const RadiositySolver& solver, double error);
  std::uint32_t rays_for(const SampledLink& sampled, const RadiositySolver& solver, double error) const;

  const Forest& forest_;
  LinkSampler& sampler_;
  const RadiositySettings& settings_;
  RadiosityStatistics& statistics_;
  const RadiosityProgress& progress_;
  std::vector<SampledLink> links_;
};

}  // namespace gicube::samples
