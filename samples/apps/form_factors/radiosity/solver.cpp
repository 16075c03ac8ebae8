#include "form_factors/radiosity/solver.h"

#include <algorithm>
#include <cmath>
#include <ranges>

namespace gicube::samples {
namespace {

// Leaves of a cluster without children.
auto own_leaves(const Cluster& cluster) {
  return std::views::iota(cluster.first, cluster.child == kNone ? cluster.last : cluster.first);
}

}  // namespace

double uncertain_part(const Link& link, const Forest& forest) {
  if (!(link.exchange > 0)) return 0;
  const bool leaves = forest.clusters[link.a].child == kNone && forest.clusters[link.b].child == kNone;
  return std::min((leaves ? link.standard_error : link.spread) / link.exchange, 1.0);
}

RadiositySolver::RadiositySolver(const Forest& forest)
    : forest_(forest),
      leaf_in_(forest.leaves.size()),
      factors_(forest.leaves.size(), 1),
      raw_sums_(forest.leaves.size(), 1),
      cluster_out_(forest.clusters.size()),
      sent_(forest.clusters.size()),
      received_(forest.clusters.size()),
      reach_(forest.clusters.size()) {
  for (const Leaf& leaf : forest.leaves) {
    leaf_out_.push_back(leaf.emission);
    add(emitted_, leaf.weight, leaf.emission);
  }
  push_pull();
}

Power RadiositySolver::outgoing(std::uint32_t cluster) const {
  const Flow& out = cluster_out_[cluster];
  return {out[0], out[1], out[2]};
}

// Pushes the received light of clusters down to their leaves, and pulls the means of the leaves' radiosity up.
void RadiositySolver::push_pull() {
  const auto& clusters = forest_.clusters;
  std::vector<Flow> incident(clusters.size());
  for (std::size_t i = 0; i < clusters.size(); ++i) {  // parents come before their children
    const Cluster& cluster = clusters[i];
    if (cluster.parent != kNone) incident[i] = incident[cluster.parent];
    add(incident[i], 1 / cluster.weight, received_[i]);
    for (const std::uint32_t leaf : own_leaves(cluster)) {
      for (std::size_t c = 0; c < 3; ++c) {
        leaf_in_[leaf][c] = incident[i][c] + factors_[leaf] * incident[i][3 + c];
        leaf_out_[leaf][c] = forest_.leaves[leaf].emission[c] + forest_.leaves[leaf].albedo[c] * leaf_in_[leaf][c];
      }
    }
  }
  std::ranges::fill(cluster_out_, Flow{});
  for (std::size_t i = clusters.size(); i-- > 0;) {
    const Cluster& cluster = clusters[i];
    for (const std::uint32_t leaf : own_leaves(cluster)) {
      const Power& out = leaf_out_[leaf];
      const double d = factors_[leaf];
      add(cluster_out_[i], forest_.leaves[leaf].weight / cluster.weight,
          Flow{out[0], out[1], out[2], d * out[0], d * out[1], d * out[2]});
    }
    if (cluster.parent == kNone) continue;
    add(cluster_out_[cluster.parent], cluster.weight / clusters[cluster.parent].weight, cluster_out_[i]);
  }
}

void RadiositySolver::index(std::span<const Link> links) {
  parts_.clear();
  first_.assign(forest_.clusters.size() + 1, 0);
  for (const Link& link : links) {
    const double uncertain = balance_ ? uncertain_part(link, forest_) * link.exchange : 0;
    parts_.push_back({link.exchange - uncertain, uncertain});
    both_ways(link, [&](std::uint32_t to, std::uint32_t) { ++first_[to + 1]; });
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  own_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t i = 0; i < links.size(); ++i) {
    both_ways(links[i], [&](std::uint32_t to, std::uint32_t) { own_[next[to]++] = i; });
  }
}

void RadiositySolver::reach(std::span<const Link> links) {
  const auto& clusters = forest_.clusters;
  std::vector<double> taken(clusters.size());  // of the uncertain parts that a cluster receives
  for (std::size_t i = clusters.size(); i-- > 0;) {
    const Cluster& cluster = clusters[i];
    for (const std::uint32_t leaf : own_leaves(cluster)) {
      taken[i] += factors_[leaf] * forest_.leaves[leaf].weight / cluster.weight;
    }
    if (cluster.parent != kNone) taken[cluster.parent] += taken[i] * cluster.weight / clusters[cluster.parent].weight;
  }
  reach_.assign(clusters.size(), {});
  for (std::size_t i = 0; i < links.size(); ++i) {
    both_ways(links[i], [&](std::uint32_t to, std::uint32_t from) {
      reach_[to].certain += parts_[i].certain;
      reach_[to].uncertain += parts_[i].uncertain * taken[from];
    });
  }
}

// Sums of the leaves' exchange areas over their weights.
std::vector<RadiositySolver::Parts> RadiositySolver::leaf_sums() const {
  const auto& clusters = forest_.clusters;
  std::vector<Parts> sums(clusters.size()), leaves(forest_.leaves.size());
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const Cluster& cluster = clusters[i];
    if (cluster.parent != kNone) sums[i] = sums[cluster.parent];
    sums[i].certain += reach_[i].certain / cluster.weight;
    sums[i].uncertain += reach_[i].uncertain / cluster.weight;
    for (const std::uint32_t leaf : own_leaves(cluster)) {
      leaves[leaf] = {sums[i].certain, factors_[leaf] * sums[i].uncertain};
    }
  }
  return leaves;
}

// Symmetric scaling to given sums (Sinkhorn 1964).
void RadiositySolver::balance(std::span<const Link> links) {
  constexpr int kMaxPasses = 50;
  constexpr double kClosed = 1e-5,
                   kMaxFactor = 4;  // chosen: greater factors come from too few rays
  std::fill(factors_.begin(), factors_.end(), 1.0);
  reach(links);
  std::vector<Parts> sums = leaf_sums();
  for (std::size_t i = 0; i < sums.size(); ++i) raw_sums_[i] = sums[i].certain + sums[i].uncertain;
  if (!balance_) return;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    double worst = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (!(sums[i].uncertain > 0)) continue;
      const double wished = std::max(1 - sums[i].certain, 0.0);
      const double factor = factors_[i] * std::sqrt(wished / sums[i].uncertain);
      const double kept = std::clamp(factor, 1 / kMaxFactor, kMaxFactor);
      if (kept == factor) worst = std::max(worst, std::abs(sums[i].uncertain - wished));
      factors_[i] = kept;
    }
    reach(links);
    if (worst < kClosed) return;
    sums = leaf_sums();
  }
}

void RadiositySolver::carry(std::uint32_t link, std::uint32_t to, const Flow& what) {
  Flow& received = received_[to];
  for (std::size_t c = 0; c < 3; ++c) {
    received[c] += parts_[link].certain * what[c];
    received[3 + c] += parts_[link].uncertain * what[3 + c];
  }
}

void RadiositySolver::gather(std::span<const Link> links) {
  sent_ = cluster_out_;
  std::fill(received_.begin(), received_.end(), Flow{});
  for (std::uint32_t i = 0; i < links.size(); ++i) {
    both_ways(links[i], [&](std::uint32_t to, std::uint32_t from) { carry(i, to, sent_[from]); });
  }
  push_pull();
}

// Sends the unsent power of all clusters that have at least half of the greatest.
void RadiositySolver::shoot(std::span<const Link> links) {
  std::vector<double> unsent(forest_.clusters.size());
  for (std::uint32_t i = 0; i < unsent.size(); ++i) {
    for (const double part : under_way(i)) unsent[i] += std::abs(part);
  }
  const double least = 0.5 * std::ranges::max(unsent);
  for (std::uint32_t i = 0; i < unsent.size(); ++i) {
    if (unsent[i] < least || unsent[i] == 0) continue;
    Flow shot = cluster_out_[i];
    add(shot, -1, sent_[i]);
    for (std::uint32_t k = first_[i]; k < first_[i + 1]; ++k) {
      const Link& link = links[own_[k]];
      carry(own_[k], link.a == i ? link.b : link.a, shot);
    }
    sent_[i] = cluster_out_[i];
  }
  push_pull();
}

// Unsent power of the cluster's own links.
RadiositySolver::Flow RadiositySolver::under_way(std::uint32_t cluster) const {
  Flow flow = cluster_out_[cluster];
  add(flow, -1, sent_[cluster]);
  for (std::size_t c = 0; c < 3; ++c) flow[c] *= reach_[cluster].certain, flow[3 + c] *= reach_[cluster].uncertain;
  return flow;
}

double RadiositySolver::residual() const {
  double sum = 0;
  for (std::uint32_t i = 0; i < reach_.size(); ++i) {
    for (const double part : under_way(i)) sum += std::abs(part);
  }
  return sum / total(emitted_);
}

void RadiositySolver::solve(std::span<const Link> links, const RadiositySettings& settings, bool balanced,
                            std::vector<Iteration>& iterations) {
  balance_ = balanced;
  index(links);
  balance(links);
  push_pull();
  gather(links);  // all links may be new
  for (int i = 0;; ++i) {
    iterations.push_back({static_cast<std::uint32_t>(links.size()), residual()});
    if (iterations.back().residual <= settings.convergence || i >= settings.max_iterations) return;
    settings.solver == Solver::kGathering ? gather(links) : shoot(links);
  }
}

void RadiositySolver::results(RadiosityResult& result) const {
  result.incident = leaf_in_;
  result.outgoing = leaf_out_;
  EnergyBalance& energy = result.statistics.energy;
  energy = {};
  energy.emitted = emitted_;
  double squares = 0, weight = 0;
  for (std::size_t i = 0; i < leaf_in_.size(); ++i) {
    const Leaf& leaf = forest_.leaves[i];
    Power& where = leaf.tag == kOutside     ? energy.escaped
                   : leaf.facing == kMedium ? energy.absorbed_by_medium
                                            : energy.absorbed_by_faces;
    for (std::size_t c = 0; c < 3; ++c) where[c] += (1 - leaf.albedo[c]) * leaf.weight * leaf_in_[i][c];
    const double off = 1 - raw_sums_[i];
    add(energy.closure, leaf.weight, leaf_out_[i]);
    add(energy.measured_closure, leaf.weight * off, leaf_out_[i]);
    squares += leaf.weight * off * off;
    weight += leaf.weight;
  }
  result.statistics.closure_rms = std::sqrt(squares / weight);

  const auto& clusters = forest_.clusters;
  std::vector<double> variance(clusters.size());
  for (std::uint32_t i = 0; i < clusters.size(); ++i) {
    const Flow late = under_way(i), &out = cluster_out_[i];
    for (std::size_t c = 0; c < 3; ++c) {
      energy.under_way[c] += late[c] + late[3 + c];
      energy.closure[c] -= reach_[i].certain * out[c] + reach_[i].uncertain * out[3 + c];
    }
  }
  for (const Link& link : result.links) {
    both_ways(link, [&](std::uint32_t to, std::uint32_t from) {
      const double off = link.standard_error * total(outgoing(from)) / clusters[to].weight;
      variance[to] += off * off;
    });
  }
  result.standard_error.assign(forest_.leaves.size(), 0);
  for (std::uint32_t i = 0; i < clusters.size(); ++i) {
    const Cluster& cluster = clusters[i];
    if (cluster.parent != kNone) variance[i] += variance[cluster.parent];
    for (const std::uint32_t leaf : own_leaves(cluster)) {
      result.standard_error[leaf] = std::sqrt(variance[i]);
    }
  }
}

}  // namespace gicube::samples
