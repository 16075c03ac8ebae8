// The README says what is there: its host program is the one that is built, and its links lead somewhere.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

namespace {

const std::filesystem::path kSource = GICUBE_SOURCE_DIR;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  EXPECT_TRUE(stream) << file;
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Readme, ShowsTheHostProgramThatIsBuilt) {
  const std::string readme = text_of(kSource / "README.md");
  const std::string open = "```cpp\n";
  const std::size_t begin = readme.find(open) + open.size();
  EXPECT_EQ(readme.substr(begin, readme.find("```", begin) - begin), text_of(kSource / "samples/small/hello/main.cpp"));
}

TEST(Readme, AndTheDocumentsLinkOnlyToWhatExists) {
  const std::regex link(R"(\]\(([^)#:]+)\))");
  std::size_t links = 0;
  std::vector<std::filesystem::path> documents{kSource / "README.md", kSource / "proto/gicube/wire/README.md"};
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kSource / "docs")) {
    if (entry.path().extension() == ".md") documents.push_back(entry.path());
  }
  for (const auto& document : documents) {
    const std::string text = text_of(document);
    for (std::sregex_iterator match(text.begin(), text.end(), link), end; match != end; ++match, ++links) {
      EXPECT_TRUE(std::filesystem::exists(document.parent_path() / (*match)[1].str()))
          << document << " links to " << (*match)[1].str();
    }
  }
  EXPECT_GT(links, 5u);
}

}  // namespace
