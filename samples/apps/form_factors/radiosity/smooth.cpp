#include "form_factors/radiosity/field.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace gicube::samples {
namespace {

constexpr double kSigma = 1.0 / 3;      // chosen: of a cluster's width
constexpr double kMaxVariance = 64;     // chosen: voxels^2; bounds the number of steps
constexpr double kTimeStep = 1.0 / 12;  // at most half of an element's light flows to its six neighbours

// Mean radiosity of the leaves of each cluster, summed over channels.
std::vector<double> radiosities(const RadiosityResult& result) {
  std::vector<double> weights(result.leaves.size() + 1), powers(result.leaves.size() + 1);
  for (std::size_t i = 0; i < result.leaves.size(); ++i) {
    weights[i + 1] = weights[i] + result.leaves[i].weight;
    powers[i + 1] = powers[i] + result.leaves[i].weight * total(result.outgoing[i]);
  }
  std::vector<double> out;
  for (const Cluster& cluster : result.clusters) {
    const double weight = weights[cluster.last] - weights[cluster.first];
    out.push_back(weight > 0 ? (powers[cluster.last] - powers[cluster.first]) / weight : 0);
  }
  return out;
}

// Variance of the diffusion of each leaf's light, voxels^2.
std::vector<double> variances(const RadiosityResult& result) {
  const std::vector<double> radiosity = radiosities(result);
  struct Brought {
    double light = 0, spread = 0;
  };
  std::vector<Brought> brought(result.clusters.size());
  for (const Link& link : result.links) {
    both_ways(link, [&](std::uint32_t to, std::uint32_t from) {
      const Cluster& cluster = result.clusters[to];
      if (!(cluster.weight > 0)) return;
      double width = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) width = std::max(width, cluster.high[axis] - cluster.low[axis]);
      const double light = link.exchange * radiosity[from] / cluster.weight, sigma = kSigma * width;
      brought[to].light += light;
      brought[to].spread += light * sigma * sigma;
    });
  }
  std::vector<double> out(result.leaves.size());
  for (const Cluster& lowest : result.clusters) {
    if (lowest.child != kNone) continue;
    Brought all;
    for (auto c = static_cast<std::uint32_t>(&lowest - result.clusters.data()); c != kNone;
         c = result.clusters[c].parent) {
      all.light += brought[c].light;
      all.spread += brought[c].spread;
    }
    const double variance = all.light > 0 ? std::min(all.spread / all.light, kMaxVariance) : 0;
    for (std::uint32_t i = lowest.first; i < lowest.last; ++i) out[i] = variance;
  }
  return out;
}

// Leaves of one facing in neighbouring cells.
std::vector<std::pair<std::uint32_t, std::uint32_t>> neighbours(const RadiosityResult& result) {
  const auto key = [](const Leaf& leaf, std::array<int, 3> away) {
    std::uint64_t word = leaf.facing;
    for (std::size_t a = 0; a < 3; ++a) word = word << 16 | static_cast<std::uint16_t>(leaf.cell[a] + away[a]);
    return word;
  };
  std::unordered_map<std::uint64_t, std::uint32_t> places;
  for (std::uint32_t i = 0; i < result.leaves.size(); ++i) {
    if (result.leaves[i].tag != kOutside) places.emplace(key(result.leaves[i], {}), i);
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
  for (std::uint32_t i = 0; i < result.leaves.size(); ++i) {
    if (result.leaves[i].tag == kOutside) continue;
    for (const auto& away : {std::array{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
      const auto other = places.find(key(result.leaves[i], away));
      if (other != places.end()) out.emplace_back(i, other->second);
    }
  }
  return out;
}

}  // namespace

std::vector<Power> smoothed(const RadiosityResult& result) {
  if (result.links.empty()) return result.incident;
  const std::vector<double> variance = variances(result);
  const double most = variance.empty() ? 0 : std::ranges::max(variance);
  std::vector<Power> light = result.incident;
  if (most == 0) return light;
  // In n steps a conductivity of c spreads by a variance of 2 c n kTimeStep.
  const auto steps = static_cast<int>(std::ceil(most / (2 * kTimeStep)));
  const auto pairs = neighbours(result);
  std::vector<Power> flow(light.size());
  for (int step = 0; step < steps; ++step) {
    std::fill(flow.begin(), flow.end(), Power{});
    for (const auto& [i, j] : pairs) {
      const double weight = std::min(result.leaves[i].weight, result.leaves[j].weight);
      const double conducted = kTimeStep * weight * std::min(variance[i], variance[j]) / most;
      for (std::size_t c = 0; c < 3; ++c) {
        const double moved = conducted * (light[j][c] - light[i][c]);
        flow[i][c] += moved;
        flow[j][c] -= moved;
      }
    }
    for (std::size_t i = 0; i < light.size(); ++i) {
      if (!(result.leaves[i].weight > 0)) continue;
      for (std::size_t c = 0; c < 3; ++c) light[i][c] += flow[i][c] / result.leaves[i].weight;
    }
  }
  return light;
}

}  // namespace gicube::samples
