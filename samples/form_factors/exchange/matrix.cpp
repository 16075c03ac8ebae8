#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "form_factors/radiosity/radiosity.h"
#include "scene/formats/whole_file.h"

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

}  // namespace

std::filesystem::path clusters_file(const std::filesystem::path& file) { return file.string() + ".clusters.csv"; }

void write_factors(const RadiosityResult& result, const std::filesystem::path& file) {
  write_whole(file, [&](std::ostream& stream) {
    stream << "%%MatrixMarket matrix coordinate real symmetric\n"
              "% Exchange areas X of the links between clusters, smallest voxel edges squared; form factor F_ij = X_ij "
              "/ w_i.\n"
              "% Rows: "
           << clusters_file(file.filename()).string() << '\n'
           << fmt::format("{} {} {}\n", result.clusters.size(), result.clusters.size(), result.links.size());
    for (const Link& link : result.links) {
      stream << fmt::format("{} {} {:.9g}\n", std::max(link.a, link.b) + 1, std::min(link.a, link.b) + 1,
                            link.exchange);
    }
  });
  write_whole(clusters_file(file), [&](std::ostream& stream) {
    stream << "row,facing,tag,low_x,low_y,low_z,high_x,high_y,high_z,measure,weight,first_leaf,last_leaf,parent\n";
    for (std::size_t i = 0; i < result.clusters.size(); ++i) stream << row_of(result, i);
  });
}

}  // namespace gicube::samples
