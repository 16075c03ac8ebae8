#include "form_factors/exchange/sampler.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace gicube::samples {
namespace {

constexpr int kRaysPerMember = 2;  // chosen: more pairs of members are more accurate, fewer spare the bus
constexpr double kCautious = 1.8;  // PairFactor::standard_error of a far pair, relative to the scatter of its runs
constexpr std::size_t kLinksAtOnce = 1u << 16;  // chosen: some ten commands of the driver's

std::uint64_t mix(std::uint64_t x) {  // SplitMix64 (Steele, Lea, Flood 2014)
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
  x = (x ^ x >> 27) * 0x94D049BB133111EBu;
  return x ^ x >> 31;
}

// Hash of a link, and of the i-th draw of its members.
std::uint64_t hash_of(const Link& link, std::uint64_t i) { return mix(mix(link.a | std::uint64_t{link.b} << 32) + i); }

}  // namespace

LinkSampler::LinkSampler(Board& board, const Forest& forest, const Contents& contents,
                         const RadiositySettings& settings, RadiosityStatistics& statistics)
    : board_(board),
      forest_(forest),
      contents_(contents),
      settings_(settings),
      statistics_(statistics),
      box_factors_(forest.edges) {
  for (const Leaf& leaf : forest.leaves) elements_.push_back(leaf.element);
  for (const Cluster& cluster : forest.clusters) elements_.push_back(element_of(cluster));
}

std::vector<PairFactor> LinkSampler::ask(std::span<const ElementPair> pairs, const PairRequest& request) {
  statistics_.pairs += pairs.size();
  statistics_.rays += std::uint64_t{request.rays} * pairs.size();
  return board_.pair_factors(elements_, pairs, request);
}

void LinkSampler::estimate(Links links, int rays) {
  // A request has one first sample, and either whole clusters or members of clusters.
  std::map<std::pair<std::uint32_t, bool>, std::vector<SampledLink*>> parts;
  for (SampledLink* sampled : links) {
    if (conclude_without_rays(*sampled)) continue;
    const bool full = forest_.clusters[sampled->link.a].full && forest_.clusters[sampled->link.b].full;
    parts[{sampled->next, !full}].push_back(sampled);
  }
  for (const auto& [request, all] : parts) {
    for (std::size_t at = 0; at < all.size(); at += kLinksAtOnce) {
      const Links some = Links(all).subspan(at, std::min(kLinksAtOnce, all.size() - at));
      request.second ? member_pairs(some, rays) : full_pairs(some, rays);
    }
  }
}

void LinkSampler::full_pairs(Links links, int rays) {
  const auto leaves = static_cast<std::uint32_t>(forest_.leaves.size());
  std::vector<ElementPair> pairs;
  for (const SampledLink* sampled : links) {
    const Link& link = sampled->link;
    pairs.push_back({leaves + link.a, leaves + link.b, static_cast<std::uint32_t>(hash_of(link, 0))});
  }
  const auto factors = ask(pairs, {.rays = static_cast<std::uint32_t>(rays),
                                   .first = links.front()->next,
                                   .seed = settings_.seed,
                                   .step = settings_.step,
                                   .made = settings_.made});
  for (std::size_t i = 0; i < links.size(); ++i) {
    PairFactor scattered = factors[i];  // many links' scatter adds up to a solution's error
    scattered.standard_error /= kCautious;
    conclude(*links[i], scattered, rays);
  }
}

// The leaf at a share, 0..1, of the cluster's measure.
std::uint32_t LinkSampler::member(const Cluster& cluster, double share) const {
  const auto begin = forest_.measures.begin();
  const double at = std::lerp(begin[cluster.first], begin[cluster.last], share);
  const auto after = std::upper_bound(begin + cluster.first + 1, begin + cluster.last, at);
  return static_cast<std::uint32_t>(after - begin) - 1;
}

void LinkSampler::member_pairs(Links links, int rays) {
  // Fractions of the powers of 1 / 1.3247..., the generalised golden ratio of two dimensions, in 64-bit fixed point.
  constexpr std::array<std::uint64_t, 2> kSteps{0xC13FA9A902A6328F, 0x91E10DA5C79E7B1D};
  constexpr double kShare = 0x1p-64;
  const auto draws = static_cast<std::uint64_t>(rays / kRaysPerMember);
  std::vector<ElementPair> pairs;
  for (const SampledLink* sampled : links) {
    const Link& link = sampled->link;
    const std::uint64_t seed = mix(settings_.seed), first = sampled->next / kRaysPerMember;
    const std::uint64_t shift_a = hash_of(link, seed), shift_b = hash_of(link, seed + 1);
    for (std::uint64_t i = first; i < first + draws; ++i) {
      const double share_a = static_cast<double>(shift_a + (i + 1) * kSteps[0]) * kShare;
      const double share_b = static_cast<double>(shift_b + (i + 1) * kSteps[1]) * kShare;
      pairs.push_back({member(forest_.clusters[link.a], share_a), member(forest_.clusters[link.b], share_b),
                       static_cast<std::uint32_t>(hash_of(link, i + 2))});
    }
  }
  const auto factors =
      ask(pairs, {.rays = kRaysPerMember, .seed = settings_.seed, .step = settings_.step, .made = settings_.made});
  for (std::size_t i = 0; i < links.size(); ++i) {
    const std::span of_link = std::span(factors).subspan(i * draws, draws);
    PairFactor mean;
    for (const PairFactor& factor : of_link) {
      mean.transported += factor.transported / static_cast<double>(draws);
      mean.geometric += factor.geometric / static_cast<double>(draws);
    }
    double squares = 0;
    for (const PairFactor& factor : of_link) {
      squares += (factor.transported - mean.transported) * (factor.transported - mean.transported);
    }
    mean.standard_error = std::sqrt(squares / (static_cast<double>(draws) * static_cast<double>(draws - 1)));
    conclude(*links[i], mean, rays);
  }
}

LinkSampler::Place LinkSampler::place_of(const Cluster& a, const Cluster& b) const {
  const Edges& edges = forest_.edges;
  Place place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double gap = std::max({a.low[axis] - b.high[axis], b.low[axis] - a.high[axis], 0.0}) * edges[axis];
    const double size = std::max(a.high[axis] - a.low[axis], b.high[axis] - b.low[axis]) * edges[axis];
    place.gap += gap * gap;
    place.size = std::max(place.size, size);
  }
  place.gap = std::sqrt(place.gap);
  return place;
}

// Mean factor of two full clusters that are too near for rays, if the space between them is open and uniform enough.
std::optional<double> LinkSampler::near_factor(const Cluster& a, const Cluster& b) {
  constexpr double kUneven = 0.02;  // chosen: of ln T
  const Place place = place_of(a, b);
  if (!place.near()) return std::nullopt;
  std::array<double, 3> low, high;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(a.low[axis], b.low[axis]);
    high[axis] = std::max(a.high[axis], b.high[axis]);
  }
  const Contents::Of between = contents_.box(low, high);
  const bool leaves = a.child == kNone && b.child == kNone;  // as uniform as their elements by definition
  if (between.solid) return std::nullopt;
  if (!leaves && between.kappa_spread * (place.gap + 2 * place.size) > kUneven) return std::nullopt;
  return box_factors_.of(a, b, between.mean_kappa);
}

// Near leaves: rays add no information, and leaves cannot be divided by their spread.
bool LinkSampler::conclude_without_rays(SampledLink& sampled) {
  const Cluster& a = forest_.clusters[sampled.link.a];
  const Cluster& b = forest_.clusters[sampled.link.b];
  if (a.child != kNone || b.child != kNone || !a.full || !b.full) return false;
  const auto factor = near_factor(a, b);
  if (factor) sampled.link.exchange = forest_.exchange_measure(a) * forest_.exchange_measure(b) * *factor;
  return factor.has_value();
}

// Converts means to the exchange area.
void LinkSampler::conclude(SampledLink& sampled, const PairFactor& mean, int rays) {
  Link& link = sampled.link;
  sampled.next += static_cast<std::uint32_t>(rays);
  link.rays = static_cast<std::uint32_t>(rays);
  const Cluster& a = forest_.clusters[link.a];
  const Cluster& b = forest_.clusters[link.b];
  const double scale = forest_.exchange_measure(a) * forest_.exchange_measure(b);
  link.exchange = scale * mean.transported;
  link.standard_error = scale * mean.standard_error;
  link.spread = link.standard_error * std::sqrt(rays);
  if (a.full && b.full && mean.geometric > 0) {
    // The rays' error is that of the share that arrives, at most that of shares 0 and 1.
    const double geometric = box_factors_.of(a, b, 0);
    const double share = std::min(mean.transported / mean.geometric, 1.0);
    const double most = std::sqrt(share * (1 - share) / rays);
    link.exchange = scale * geometric * share;
    link.standard_error = scale * geometric * std::min(mean.standard_error / mean.geometric, most);
    if (const auto factor = near_factor(a, b)) {
      link.exchange = scale * *factor;
      link.standard_error = 0;
    }
  }
  link.exchange = std::min({link.exchange, a.weight, b.weight});  // true bounds, which a few rays may exceed
  // The next ray may find light that no ray has found. For touching clusters it may be the largest part.
  const Place place = place_of(a, b);
  const double unseen = (mean.transported > 0 ? mean.transported : mean.geometric) / (rays + 1);
  const double meeting = 1 / (std::numbers::pi * (place.gap * place.gap + place.size * place.size));
  link.spread = std::max(link.spread, scale * (place.touch() ? std::max(unseen, meeting) : unseen));
}

}  // namespace gicube::samples
