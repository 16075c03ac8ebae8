#include "form_factors/solver.h"

#include <algorithm>
#include <cmath>

namespace gicube::samples {
namespace {

void add(Power& to, double factor, const Power& what) {
  for (std::size_t c = 0; c < 3; ++c) to[c] += factor * what[c];
}

double total(const Power& power) { return power[0] + power[1] + power[2]; }

}  // namespace

RadiositySolver::RadiositySolver(const Forest& forest, bool balance)
    : forest_(forest),
      balance_(balance),
      leaf_in_(forest.leaves.size()),
      cluster_out_(forest.clusters.size()),
      sent_(forest.clusters.size()),
      received_(forest.clusters.size()),
      factors_(forest.leaves.size(), 1),
      raw_sums_(forest.leaves.size(), 1) {
  for (const Leaf& leaf : forest.leaves) {
    leaf_out_.push_back(leaf.emission);
    add(emitted_, leaf.weight, leaf.emission);
  }
  push_pull();
}

// What clusters received goes down to their leaves; what leaves send out goes up as means.
void RadiositySolver::push_pull() {
  const auto& clusters = forest_.clusters;
  std::vector<Power> incident(clusters.size());
  for (std::size_t i = 0; i < clusters.size(); ++i) {  // parents come before their children
    const Cluster& cluster = clusters[i];
    if (cluster.parent != kNone) incident[i] = incident[cluster.parent];
    add(incident[i], 1 / cluster.weight, received_[i]);
    if (cluster.child != kNone) continue;
    for (std::uint32_t leaf = cluster.first; leaf < cluster.last; ++leaf) {
      for (std::size_t c = 0; c < 3; ++c) {
        leaf_in_[leaf][c] = factors_[leaf] * incident[i][c];
        leaf_out_[leaf][c] = forest_.leaves[leaf].emission[c] + forest_.leaves[leaf].albedo[c] * leaf_in_[leaf][c];
      }
    }
  }
  std::fill(cluster_out_.begin(), cluster_out_.end(), Power{});
  for (std::size_t i = clusters.size(); i-- > 0;) {
    const Cluster& cluster = clusters[i];
    if (cluster.child == kNone) {
      for (std::uint32_t leaf = cluster.first; leaf < cluster.last; ++leaf) {
        add(cluster_out_[i], factors_[leaf] * forest_.leaves[leaf].weight / cluster.weight, leaf_out_[leaf]);
      }
    }
    if (cluster.parent != kNone) {
      add(cluster_out_[cluster.parent], cluster.weight / clusters[cluster.parent].weight, cluster_out_[i]);
    }
  }
}

void RadiositySolver::index(std::span<const Link> links) {
  first_.assign(forest_.clusters.size() + 1, 0);
  for (const Link& link : links) {
    ++first_[link.a + 1];
    if (link.a != link.b) ++first_[link.b + 1];
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  own_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t i = 0; i < links.size(); ++i) {
    own_[next[links[i].a]++] = i;
    if (links[i].a != links[i].b) own_[next[links[i].b]++] = i;
  }
}

void RadiositySolver::reach(std::span<const Link> links) {
  const auto& clusters = forest_.clusters;
  std::vector<double> taken(clusters.size());  // of what comes to a cluster
  for (std::size_t i = clusters.size(); i-- > 0;) {
    const Cluster& cluster = clusters[i];
    if (cluster.child == kNone) {
      for (std::uint32_t leaf = cluster.first; leaf < cluster.last; ++leaf) {
        taken[i] += factors_[leaf] * forest_.leaves[leaf].weight / cluster.weight;
      }
    }
    if (cluster.parent != kNone) taken[cluster.parent] += taken[i] * cluster.weight / clusters[cluster.parent].weight;
  }
  reach_.assign(clusters.size(), 0);
  for (const Link& link : links) {
    reach_[link.a] += link.exchange * taken[link.b];
    if (link.a != link.b) reach_[link.b] += link.exchange * taken[link.a];
  }
}

// Sums of the leaves' exchange areas over their weights.
std::vector<double> RadiositySolver::leaf_sums() const {
  const auto& clusters = forest_.clusters;
  std::vector<double> sums(clusters.size()), leaves(forest_.leaves.size());
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const Cluster& cluster = clusters[i];
    sums[i] = reach_[i] / cluster.weight + (cluster.parent != kNone ? sums[cluster.parent] : 0);
    if (cluster.child != kNone) continue;
    for (std::uint32_t leaf = cluster.first; leaf < cluster.last; ++leaf) leaves[leaf] = factors_[leaf] * sums[i];
  }
  return leaves;
}

// Symmetric scaling to given sums (Sinkhorn 1964).
void RadiositySolver::balance(std::span<const Link> links) {
  constexpr int kMostTurns = 50;
  constexpr double kClosed = 1e-5,
                   kMostFactor = 2;  // chosen: what is further off was not seen well enough to be scaled
  std::fill(factors_.begin(), factors_.end(), 1.0);
  reach(links);
  raw_sums_ = leaf_sums();
  if (!balance_) return;
  for (int turn = 0; turn < kMostTurns; ++turn) {
    const std::vector<double> sums = leaf_sums();
    double worst = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const double factor = sums[i] > 0 ? factors_[i] / std::sqrt(sums[i]) : 1;
      const double kept = std::clamp(factor, 1 / kMostFactor, kMostFactor);
      if (kept == factor) worst = std::max(worst, std::abs(sums[i] - 1));
      factors_[i] = kept;
    }
    reach(links);
    if (worst < kClosed) return;
  }
}

void RadiositySolver::gather(std::span<const Link> links) {
  sent_ = cluster_out_;
  std::fill(received_.begin(), received_.end(), Power{});
  for (const Link& link : links) {
    add(received_[link.a], link.exchange, sent_[link.b]);
    if (link.a != link.b) add(received_[link.b], link.exchange, sent_[link.a]);
  }
  push_pull();
}

// All clusters that have at least half as much to send as the one that has most.
void RadiositySolver::shoot(std::span<const Link> links) {
  std::vector<double> unsent(forest_.clusters.size());
  for (std::uint32_t i = 0; i < unsent.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) unsent[i] += std::abs(under_way(i, c));
  }
  const double least = 0.5 * *std::max_element(unsent.begin(), unsent.end());
  for (std::uint32_t i = 0; i < unsent.size(); ++i) {
    if (unsent[i] < least || unsent[i] == 0) continue;
    Power shot = cluster_out_[i];
    add(shot, -1, sent_[i]);
    for (std::uint32_t k = first_[i]; k < first_[i + 1]; ++k) {
      const Link& link = links[own_[k]];
      add(received_[link.a == i ? link.b : link.a], link.exchange, shot);
    }
    sent_[i] = cluster_out_[i];
  }
  push_pull();
}

double RadiositySolver::residual() const {
  double sum = 0;
  for (std::uint32_t i = 0; i < reach_.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(under_way(i, c));
  }
  return sum / total(emitted_);
}

void RadiositySolver::solve(std::span<const Link> links, Solver solver, double convergence, int most_iterations,
                            std::vector<Iteration>& iterations) {
  index(links);
  balance(links);
  push_pull();
  gather(links);  // all links may be new
  for (int i = 0;; ++i) {
    iterations.push_back({static_cast<std::uint32_t>(links.size()), residual()});
    if (iterations.back().residual <= convergence || i >= most_iterations) return;
    solver == Solver::kGathering ? gather(links) : shoot(links);
  }
}

void RadiositySolver::results(RadiosityResult& result) const {
  result.incident = leaf_in_;
  result.outgoing = leaf_out_;
  EnergyBalance& energy = result.statistics.energy;
  energy = {};
  energy.emitted = emitted_;
  for (std::size_t i = 0; i < leaf_in_.size(); ++i) {
    const Leaf& leaf = forest_.leaves[i];
    Power& where = leaf.tag == kOutside     ? energy.escaped
                   : leaf.facing == kMedium ? energy.absorbed_by_medium
                                            : energy.absorbed_by_faces;
    for (std::size_t c = 0; c < 3; ++c) where[c] += (1 - leaf.albedo[c]) * leaf.weight * leaf_in_[i][c];
    add(energy.closure, leaf.weight, leaf_out_[i]);
  }
  const auto& clusters = forest_.clusters;
  std::vector<double> variance(clusters.size());
  for (std::uint32_t i = 0; i < clusters.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) energy.under_way[c] += under_way(i, c);
    add(energy.closure, -reach_[i], cluster_out_[i]);
  }
  for (const Link& link : result.links) {
    const auto error = [&](std::uint32_t from, std::uint32_t to) {
      const double off = link.standard_error * total(cluster_out_[from]) / clusters[to].weight;
      return off * off;
    };
    variance[link.a] += error(link.b, link.a);
    if (link.a != link.b) variance[link.b] += error(link.a, link.b);
  }
  double squares = 0, weight = 0;
  result.standard_error.assign(forest_.leaves.size(), 0);
  for (std::uint32_t i = 0; i < clusters.size(); ++i) {
    const Cluster& cluster = clusters[i];
    if (cluster.parent != kNone) variance[i] += variance[cluster.parent];
    if (cluster.child != kNone) continue;
    for (std::uint32_t leaf = cluster.first; leaf < cluster.last; ++leaf) {
      result.standard_error[leaf] = std::sqrt(variance[i]);
      const double off = 1 - raw_sums_[leaf], w = forest_.leaves[leaf].weight;
      squares += w * off * off;
      weight += w;
      add(energy.measured_closure, w * off, leaf_out_[leaf]);
    }
  }
  result.statistics.closure_rms = std::sqrt(squares / weight);
}

}  // namespace gicube::samples
