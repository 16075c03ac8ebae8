#include "form_factors/radiosity/refinement.h"

#include <algorithm>
#include <bit>
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

constexpr double kNearRays = 64;  // chosen
constexpr double kNoise = 0.25;   // chosen: part of the error that may come from too few rays: that of 16 of them

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
    sampler_.estimate(part, settings_.rays);
    for (SampledLink* sampled : part) {
      sampled->first_error = sampled->link.standard_error;
      sampled->first_spread = sampled->link.spread;
    }
    if (progress_) progress_("links", static_cast<double>(end) / static_cast<double>(links.size()));
  }
}

bool LinkSet::refine(const RadiositySolver& solver, double error) {
  std::vector<SampledLink> kept, fresh, next;
  const auto sort_out = [&](std::vector<SampledLink>& links) {
    next.clear();
    for (const SampledLink& sampled : links) {
      if (divisible(sampled.link) && misplaced(solver, sampled.link, sampled.first_spread) > error) {
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
  return measure(solver, error) || any;
}

// Rays that an estimate should have, 0 for none but its first guess.
std::uint32_t LinkSet::rays_for(const SampledLink& sampled, const RadiositySolver& solver, double error) const {
  const Link& link = sampled.link;
  if (link.rays == 0) return 0;  // exact
  if (divisible(link)) return static_cast<std::uint32_t>(settings_.rays);
  const double off = misplaced(solver, link, sampled.first_error) / (kNoise * error);
  double rays = off > 1 ? settings_.rays * off * off : 0;
  // Something is in the way of two that touch, and few rays see too little of where they are nearest.
  if (sampler_.place_of(forest_.clusters[link.a], forest_.clusters[link.b]).near()) rays = std::max(rays, kNearRays);
  const double most = std::max(settings_.max_rays, settings_.rays);
  return rays > 0 ? std::bit_floor(static_cast<std::uint32_t>(std::clamp(2 * rays, double(settings_.rays), most))) : 0;
}

// With fresh rays: if the guess that decided to keep a link were its measure too, those that found too little would be kept,
// those that found too much divided, and the sum would be too low.
bool LinkSet::measure(const RadiositySolver& solver, double error) {
  std::map<std::uint32_t, std::vector<SampledLink*>> wanted;
  for (SampledLink& sampled : links_) {
    const std::uint32_t rays = rays_for(sampled, solver, error);
    if (rays > (sampled.measured ? sampled.link.rays : 0)) wanted[rays].push_back(&sampled);
  }
  for (const auto& [rays, links] : wanted) {
    sampler_.estimate(links, static_cast<int>(rays));
    for (SampledLink* sampled : links) {
      sampled->link.spread = std::max(sampled->link.spread, sampled->first_spread);
      sampled->measured = true;
    }
  }
  return !wanted.empty();
}

std::vector<Link> LinkSet::links() const {
  std::vector<Link> out;
  for (const SampledLink& sampled : links_) out.push_back(sampled.link);
  return out;
}

}  // namespace gicube::samples
