#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "form_factors/radiosity/radiosity.h"
#include "scene/common/whole_file.h"

namespace gicube::samples {
namespace {

constexpr const char* kFacings[] = {"-x", "+x", "-y", "+y", "-z", "+z", "medium"};

std::string row_of(const RadiosityResult& result, std::size_t i) {
  const Cluster& cluster = result.clusters[i];
  const bool outside = result.leaves[cluster.first].tag == kOutside;
  return fmt::format("{},{},{},{},{},{:.9g},{:.9g},{},{},{}\n", i + 1, kFacings[cluster.facing],
                     outside ? "outside" : std::to_string(result.leaves[cluster.first].tag),
                     fmt::join(cluster.low, ","), fmt::join(cluster.high, ","), cluster.measure, cluster.weight,
                     cluster.first + 1, cluster.last, cluster.parent == kNone ? 0 : cluster.parent + 1);
}

// By leaf: the sum of its own and its ancestors' exchange areas over its weight.
std::vector<double> closures(const RadiosityResult& result) {
  std::vector<double> sums(result.clusters.size()), leaves(result.leaves.size());
  for (const Link& link : result.links) {
    both_ways(link, [&](std::uint32_t to, std::uint32_t) { sums[to] += link.exchange / result.clusters[to].weight; });
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {  // parents come before their children
    const Cluster& cluster = result.clusters[i];
    if (cluster.parent != kNone) sums[i] += sums[cluster.parent];
    if (cluster.child == kNone) std::fill_n(leaves.begin() + cluster.first, cluster.last - cluster.first, sums[i]);
  }
  return leaves;
}

double furthest_off(const std::vector<double>& closures) {
  double off = 0;
  for (const double closure : closures) off = std::max(off, std::abs(closure - 1));
  return off;
}

// Multiplies all links by factors of their clusters, like symmetric scaling of the rows of a full matrix (Sinkhorn
// 1964). A factor follows from the closure of the cluster's leaves. Some sums cannot close: elements without their own
// links beside others that have some.
void balance(RadiosityResult& result) {
  constexpr int kMaxPasses = 500;   // chosen
  constexpr double kClosed = 1e-4;  // chosen
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const std::vector<double> sums = closures(result);
    if (furthest_off(sums) < kClosed) return;
    std::vector<double> factors;
    for (const Cluster& cluster : result.clusters) {
      double lacks = 0;
      for (std::uint32_t leaf = cluster.first; leaf < cluster.last; ++leaf) {
        lacks += (sums[leaf] > 0 ? std::log(sums[leaf]) : 0) / (cluster.last - cluster.first);
      }
      factors.push_back(std::exp(-0.5 * lacks));
    }
    for (Link& link : result.links) link.exchange *= factors[link.a] * factors[link.b];
  }
}

}  // namespace

std::filesystem::path clusters_file(const std::filesystem::path& file) { return file.string() + ".clusters.csv"; }

void write_factors(const RadiosityResult& measured, const std::filesystem::path& file) {
  RadiosityResult result = measured;
  balance(result);
  const double off = furthest_off(closures(result));
  WholeFiles files;
  files.write(file, [&](WholeFile& out) {
    out.write(
        "%%MatrixMarket matrix coordinate real symmetric\n"
        "% Exchange areas X of the links between clusters, smallest voxel edges squared; form factor F_ij = X_ij "
        "/ w_i.\n");
    out.write(fmt::format("% Balanced: the sums of all elements are w_i within {:.2g} of it.\n", off));
    out.write(fmt::format("% Rows: {}\n", clusters_file(file.filename()).string()));
    out.write(fmt::format("{} {} {}\n", result.clusters.size(), result.clusters.size(), result.links.size()));
    for (const Link& link : result.links) {
      out.write(
          fmt::format("{} {} {:.9g}\n", std::max(link.a, link.b) + 1, std::min(link.a, link.b) + 1, link.exchange));
    }
  });
  files.write(clusters_file(file), [&](WholeFile& out) {
    out.write("row,facing,tag,low_x,low_y,low_z,high_x,high_y,high_z,measure,weight,first_leaf,last_leaf,parent\n");
    for (std::size_t i = 0; i < result.clusters.size(); ++i) out.write(row_of(result, i));
  });
  files.commit();
}

void write_elements(const RadiosityResult& result, const std::filesystem::path& file) {
  std::string text = "x,y,z,facing,tag,weight,red,green,blue,standard_error\n";
  for (std::size_t i = 0; i < result.leaves.size(); ++i) {
    const Leaf& leaf = result.leaves[i];
    const Power& light = result.incident[i];
    text += fmt::format("{},{},{},{},{},{},{},{},{},{}\n", leaf.cell[0], leaf.cell[1], leaf.cell[2], leaf.facing,
                        leaf.tag, leaf.weight, light[0], light[1], light[2], result.standard_error[i]);
  }
  write_whole(file, text);
}

}  // namespace gicube::samples
