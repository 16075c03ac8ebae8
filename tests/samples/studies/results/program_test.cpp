// The program itself on tiny volumes: the page is whole, and its numbers are those of its CSV files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "studies/results/page.h"
#include "temporary_directory.h"

namespace gicube::samples::results {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// "| a | b |" -> a, b
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  for (std::size_t start = 2; start < line.size();) {
    const std::size_t end = line.find(" |", start);
    cells.push_back(line.substr(start, end - start));
    start = end + 3;
  }
  return cells;
}

// Tables by the file that the line after them names.
std::vector<Table> tables_of(const std::string& page) {
  std::vector<Table> tables;
  Table table;
  const std::regex link("\\[results/([a-z0-9-]+)\\.csv\\]\\(results/\\1\\.csv\\)");
  for (const std::string& line : lines_of(page)) {
    std::smatch match;
    if (line.starts_with("| --- |")) continue;
    if (line.starts_with("| ") && table.columns.empty()) {
      table.columns = cells_of(line);
    } else if (line.starts_with("| ")) {
      table.rows.push_back(cells_of(line));
    } else if (std::regex_match(line, match, link)) {
      table.name = match[1];
      tables.push_back(table);
      table = {};
    }
  }
  return tables;
}

void expect_every_row(const std::string& page) {
  for (const int row : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23}) {
    EXPECT_THAT(page, HasSubstr("\n| " + std::to_string(row) + " | ")) << row;
  }
  EXPECT_THAT(page, HasSubstr("script/results"));
  EXPECT_THAT(page, Not(testing::ContainsRegex("[^a-z](nan|inf)[^a-z]")));
}

void expect_the_files_numbers(const std::vector<Table>& tables, const std::filesystem::path& folder) {
  ASSERT_GE(tables.size(), 12u);
  for (const Table& table : tables) {
    EXPECT_FALSE(table.rows.empty()) << table.name;
    EXPECT_EQ(text_of(folder / (table.name + ".csv")), to_csv(table)) << table.name;
  }
}

void expect_sources_of_pictures(const std::string& page, const std::filesystem::path& folder) {
  const std::regex picture("!\\[[^\\]]*\\]\\(results/([a-z0-9-]+)\\.(svg|png)\\)");
  int pictures = 0;
  for (std::sregex_iterator at(page.begin(), page.end(), picture), end; at != end; ++at, ++pictures) {
    const std::string name = (*at)[1];
    const std::string file = name + ((*at)[2] == "svg" ? ".gp" : ".png");
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  }
  EXPECT_GE(pictures, 12);
}

void expect_causes_of_all_cycles(const std::vector<Table>& tables, const std::string& name) {
  const auto causes = std::find_if(tables.begin(), tables.end(), [&](const Table& t) { return t.name == name; });
  ASSERT_NE(causes, tables.end());
  for (std::size_t column = 1; column < causes->columns.size(); ++column) {
    double sum = 0;
    for (const auto& row : causes->rows) sum += std::stod(row[column]);
    EXPECT_NEAR(sum, 100, 0.05 * static_cast<double>(causes->rows.size())) << causes->columns[column];
  }
}

// One test: its program takes seconds.
TEST(ResultsProgram, WritesAWholePageOfItsFilesNumbers) {
  const reference::TemporaryDirectory temporary;
  const std::filesystem::path folder = temporary.file("results");
  const int status = std::system(
      (GICUBE_BIN_DIR "/gicube-results --edge 32 --image 32 --quiet " + folder.parent_path().string()).c_str());
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_EQ(WEXITSTATUS(status), 0);
  const std::string page = text_of(temporary.file("RESULTS.md"));
  const std::vector<Table> tables = tables_of(page);
  expect_every_row(page);
  expect_the_files_numbers(tables, folder);
  expect_sources_of_pictures(page, folder);
  expect_causes_of_all_cycles(tables, "causes");
  expect_causes_of_all_cycles(tables, "lit-causes");
  // Row 19 is exact at any size: a block of 8^3 voxels has 9^3 words.
  const std::vector<std::string> blocks = lines_of(text_of(folder / "one-block.csv"));
  ASSERT_GT(blocks.size(), 3u);
  for (std::size_t i = 1; i < blocks.size(); ++i) EXPECT_THAT(blocks[i], HasSubstr(",729,729,"));
}

TEST(ResultsProgram, WritesThePageOfOneSection) {
  const reference::TemporaryDirectory temporary;
  const std::string folder = std::filesystem::path(temporary.file("results")).parent_path().string();
  const int status = std::system((GICUBE_BIN_DIR "/gicube-results --only cost --quiet " + folder).c_str());
  ASSERT_EQ(WEXITSTATUS(status), 0);
  const std::string page = text_of(temporary.file("RESULTS.md"));
  EXPECT_THAT(page, HasSubstr("\n| 22 | "));
  EXPECT_THAT(page, Not(HasSubstr("\n| 21 | ")));
}

TEST(ResultsProgram, RefusesASizeThatIsNoPowerOfTwo) {
  const int status = std::system(GICUBE_BIN_DIR "/gicube-results --edge 33 . >/dev/null 2>&1");
  EXPECT_EQ(WEXITSTATUS(status), 2);
}

}  // namespace
}  // namespace gicube::samples::results
