#include "form_factors/refinement.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace gicube::samples {
namespace {

double extent(const Cluster& cluster) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    square += (cluster.high[axis] - cluster.low[axis]) * (cluster.high[axis] - cluster.low[axis]);
  }
  return square;
}

// Share of the emitted power that an error `of` an exchange area misplaces, of the channel that suffers most.
double misplaced(const RadiositySolver& solver, const Link& link, double of) {
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double emitted = solver.emitted()[c];
    if (emitted > 0) most = std::max(most, std::max(solver.outgoing(link.a)[c], solver.outgoing(link.b)[c]) / emitted);
  }
  return of * most;
}

constexpr double kNoise = 0.25;  // chosen: part of the error that may come from too few rays: that of 16 of them

}  // namespace

LinkSet::LinkSet(const Forest& forest, LinkSampler& sampler, const RadiositySettings& settings,
                 RadiosityStatistics& statistics, const RadiosityProgress& progress)
    : forest_(forest), sampler_(sampler), settings_(settings), statistics_(statistics), progress_(progress) {
  std::vector<std::uint32_t> ends;
  for (std::uint32_t i = 0; i < forest.clusters.size(); ++i) {
    if (forest.clusters[i].child == kNone) ends.push_back(i);
  }
  std::array<std::uint64_t, 7> count{};
  for (const std::uint32_t i : ends) ++count[forest.clusters[i].facing];
  for (std::size_t a = 0; a < 7; ++a) {
    for (std::size_t b = a + 1; b < 7; ++b) statistics.all_pairs += count[a] * count[b];
  }
  statistics.all_pairs += count[kMedium] * (count[kMedium] + 1) / 2;

  const std::vector<std::uint32_t>& first = settings.hierarchy ? forest.roots : ends;
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = i; j < first.size(); ++j) add(first[i], first[j], links_);
  }
  guess(links_);
}

void LinkSet::add(std::uint32_t a, std::uint32_t b, std::vector<SampledLink>& to) const {
  if (may_see(forest_.clusters[a], forest_.clusters[b])) to.push_back({{.a = a, .b = b}});
}

bool LinkSet::divisible(const Link& link) const {
  return forest_.clusters[link.a].child != kNone || forest_.clusters[link.b].child != kNone;
}

void LinkSet::divide(const SampledLink& sampled, std::vector<SampledLink>& to) const {
  const auto [a, b] = std::pair(sampled.link.a, sampled.link.b);
  const Cluster& first = forest_.clusters[a];
  const Cluster& second = forest_.clusters[b];
  if (a == b) {
    for (std::uint32_t i = 0; i < first.children; ++i) {
      for (std::uint32_t j = i; j < first.children; ++j) add(first.child + i, first.child + j, to);
    }
  } else if (second.child == kNone || (first.child != kNone && extent(first) >= extent(second))) {
    for (std::uint32_t i = 0; i < first.children; ++i) add(first.child + i, b, to);
  } else {
    for (std::uint32_t i = 0; i < second.children; ++i) add(a, second.child + i, to);
  }
}

void LinkSet::guess(std::vector<SampledLink>& links) {
  constexpr std::size_t kAtOnce = 1u << 16;
  for (std::size_t begin = 0; begin < links.size(); begin += kAtOnce) {
    const std::size_t end = std::min(begin + kAtOnce, links.size());
    std::vector<SampledLink*> part;
    for (std::size_t i = begin; i < end; ++i) part.push_back(&links[i]);
    sampler_.add_rays(part, settings_.rays);
    if (progress_) progress_("links", static_cast<double>(end) / static_cast<double>(links.size()));
  }
}

bool LinkSet::refine(const RadiositySolver& solver, double error) {
  std::vector<SampledLink> kept, fresh, next;
  const auto sort_out = [&](std::vector<SampledLink>& links) {
    next.clear();
    for (const SampledLink& sampled : links) {
      if (divisible(sampled.link) && misplaced(solver, sampled.link, sampled.link.spread) > error) {
        divide(sampled, next);
        ++statistics_.refinements;
      } else {
        kept.push_back(sampled);
      }
    }
  };
  sort_out(links_);
  bool any = !next.empty();
  while (!next.empty()) {
    fresh.swap(next);
    guess(fresh);
    sort_out(fresh);
  }
  links_.swap(kept);
  return sample_more(solver, error) || any;
}

// Twice as many rays, for links that can't be divided, until their noise is small.
bool LinkSet::sample_more(const RadiositySolver& solver, double error) {
  bool any = false;
  while (true) {
    std::map<std::uint32_t, std::vector<SampledLink*>> noisy;
    for (SampledLink& sampled : links_) {
      const Link& link = sampled.link;
      if (divisible(link) || 2 * link.rays > static_cast<std::uint32_t>(settings_.most_rays)) continue;
      if (misplaced(solver, link, link.standard_error) > kNoise * error) noisy[link.rays].push_back(&sampled);
    }
    if (noisy.empty()) return any;
    any = true;
    for (auto& [rays, links] : noisy) sampler_.add_rays(links, static_cast<int>(rays));
  }
}

std::vector<Link> LinkSet::links() const {
  std::vector<Link> out;
  for (const SampledLink& sampled : links_) out.push_back(sampled.link);
  return out;
}

}  // namespace gicube::samples
