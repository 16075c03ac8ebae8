#include "form_factors/radiosity/radiosity.h"

#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples {
namespace {

// A medium element in two clusters, one the other's parent, and an end of the volume; their sums close.
RadiosityResult three_clusters() {
  RadiosityResult result;
  result.leaves.resize(2);
  result.leaves[0].facing = kMedium;
  result.leaves[1].tag = kOutside;
  for (const std::uint32_t leaf : {0u, 0u, 1u}) {
    Cluster cluster;
    cluster.first = leaf, cluster.last = leaf + 1;
    cluster.facing = result.leaves[leaf].facing;
    cluster.high = {1, 2, 3};
    cluster.weight = 0.5;
    result.clusters.push_back(cluster);
  }
  result.clusters[0].child = 1, result.clusters[0].children = 1;
  result.clusters[1].parent = 0;
  result.links = {{0, 2, 0.15, 0, 0, 8}, {2, 1, 0.2, 0, 0, 8}, {1, 1, 0.15, 0, 0, 8}, {2, 2, 0.15, 0, 0, 8}};
  return result;
}

TEST(Matrix, IsTheLowerHalfOfASymmetricOneWithItsRowsBesideIt) {
  const reference::TemporaryDirectory folder;
  const std::filesystem::path file = folder.file("factors.mtx");
  write_factors(three_clusters(), file);
  std::istringstream lines(text_of(file));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "%%MatrixMarket matrix coordinate real symmetric");
  while (lines.peek() == '%') std::getline(lines, line);
  EXPECT_EQ(line, "% Rows: factors.mtx.clusters.csv");
  std::size_t rows = 0, columns = 0, entries = 0;
  lines >> rows >> columns >> entries;
  EXPECT_EQ(rows, 3u);
  EXPECT_EQ(columns, 3u);
  ASSERT_EQ(entries, 4u);
  const double expected[4][3] = {{3, 1, 0.15}, {3, 2, 0.2}, {2, 2, 0.15}, {3, 3, 0.15}};
  for (const auto& entry : expected) {
    double row = 0, column = 0, value = 0;
    lines >> row >> column >> value;
    EXPECT_EQ(row, entry[0]);
    EXPECT_EQ(column, entry[1]);
    EXPECT_NEAR(value, entry[2], 1e-8 * entry[2]);
  }
  const std::string table = text_of(clusters_file(file));
  EXPECT_THAT(table, HasSubstr("\n1,medium,0,0,0,0,1,2,3,0,0.5,1,1,0\n"));
  EXPECT_THAT(table, HasSubstr("\n2,medium,0,0,0,0,1,2,3,0,0.5,1,1,1\n"));
  EXPECT_THAT(table, HasSubstr("\n3,-x,outside,"));
}

TEST(Matrix, SaysWhereItCouldNotBeWritten) {
  EXPECT_THROW(write_factors(three_clusters(), "/nowhere/factors.mtx"), FileError);
}

}  // namespace
}  // namespace gicube::samples
