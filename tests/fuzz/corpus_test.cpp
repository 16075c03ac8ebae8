// Plays every target's corpus without a fuzzer: what once was a finding stays mended.
#include "targets.h"
#include "test.h"

namespace gicube::fuzz {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_of(const std::string& target) {
  std::vector<fs::path> files;
  const fs::path folder = fs::path(GICUBE_SOURCE_DIR) / "tests/fuzz/corpus" / target;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::uint8_t> bytes_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class FuzzCorpus : public testing::TestWithParam<Target> {};

TEST_P(FuzzCorpus, EveryInputIsTakenOrRefusedInWords) {
  const Target& target = GetParam();
  const std::vector<fs::path> files = files_of(target.name);
  ASSERT_FALSE(files.empty()) << "no corpus for " << target.name;
  for (const fs::path& file : files) {
    SCOPED_TRACE(file.filename());
    const std::vector<std::uint8_t> input = bytes_of(file);
    EXPECT_NO_THROW(target.run(input));
  }
}

TEST_P(FuzzCorpus, NoInputAtAllIsAnInput) { EXPECT_NO_THROW(GetParam().run({})); }

INSTANTIATE_TEST_SUITE_P(All, FuzzCorpus, testing::ValuesIn(targets()),
                         [](const testing::TestParamInfo<Target>& target) { return std::string(target.param.name); });

TEST(FuzzCorpus, EveryFolderBelongsToATarget) {
  for (const auto& entry : fs::directory_iterator(fs::path(GICUBE_SOURCE_DIR) / "tests/fuzz/corpus")) {
    const std::string name = entry.path().filename();
    const bool known = std::any_of(targets().begin(), targets().end(), [&](const Target& t) { return t.name == name; });
    EXPECT_TRUE(known) << name;
  }
}

}  // namespace
}  // namespace gicube::fuzz
