// The documents say what is there: the README's host program is the one that is built, links and anchors lead
// somewhere, and no document names a file or folder that the tree does not have. And the tree is as
// docs/ARCHITECTURE.md says.
#include <cctype>
#include <regex>

#include "test.h"

namespace {

namespace fs = std::filesystem;

const fs::path kSource = GICUBE_SOURCE_DIR;

using gicube::text_of;

// Paths from the root, folders too, without what builds and programs leave there.
std::set<std::string> tree() {
  std::set<std::string> paths;
  for (fs::recursive_directory_iterator entry(kSource), end; entry != end; ++entry) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(".") || (entry.depth() == 0 && (name == "build" || name == "out"))) {
      entry.disable_recursion_pending();
    } else {
      paths.insert(entry->path().lexically_relative(kSource).generic_string());
    }
  }
  return paths;
}

const std::set<std::string>& paths() {
  static const std::set<std::string> all = tree();
  return all;
}

std::vector<std::string> documents() {
  std::vector<std::string> found;
  std::copy_if(paths().begin(), paths().end(), std::back_inserter(found),
               [](const std::string& path) { return path.ends_with(".md"); });
  return found;
}

// Each match's `group` in `text`.
std::vector<std::string> matches(const std::string& text, const std::string& pattern, int group) {
  const std::regex regex(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), regex), end; match != end; ++match) {
    found.push_back((*match)[group]);
  }
  return found;
}

// As GitHub makes it of a heading: lower case, blanks are hyphens, no punctuation.
std::string anchor(std::string_view heading) {
  std::string made;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == ' ') {
      made += '-';
    } else if (byte >= 0x80 || std::isalnum(byte) != 0 || c == '-' || c == '_') {
      made += static_cast<char>(std::tolower(byte));
    }
  }
  return made;
}

std::set<std::string> anchors(const std::string& document) {
  std::ifstream lines(kSource / document);
  std::set<std::string> found;
  bool code = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) code = !code;
    if (!code && line.starts_with("#")) found.insert(anchor(line.substr(line.find_first_not_of("# "))));
  }
  return found;
}

TEST(Readme, ShowsTheHostProgramThatIsBuilt) {
  const std::string readme = text_of(kSource / "README.md");
  const std::string open = "```cpp\n";
  const std::size_t begin = readme.find(open) + open.size();
  EXPECT_EQ(readme.substr(begin, readme.find("```", begin) - begin), text_of(kSource / "samples/small/hello/main.cpp"));
}

TEST(Documents, LinkOnlyToFilesAndAnchorsThatExist) {
  std::size_t links = 0;
  for (const std::string& document : documents()) {
    for (const std::string& link : matches(text_of(kSource / document), R"(\]\(([^)\s]+)\))", 1)) {
      if (link.find("://") != std::string::npos) continue;
      ++links;
      const std::string file = link.substr(0, link.find('#'));
      const std::string target =
          file.empty() ? document : (fs::path(document).parent_path() / file).lexically_normal().generic_string();
      EXPECT_TRUE(paths().contains(target)) << document << " links to " << link;
      if (link.size() == file.size()) continue;
      EXPECT_TRUE(anchors(target).contains(link.substr(file.size() + 1))) << document << " links to " << link;
    }
  }
  EXPECT_GT(links, 100u);
}

// NAME stands for any name, TARGET for a fuzzer's.
bool is_placeholder(const std::string& name) {
  return name.find("NAME") != std::string::npos || name.find("TARGET") != std::string::npos;
}

TEST(Documents, NameOnlyPathsThatExist) {
  // A path from the root, wherever it stands; build/release/tests/... is no path of ours, "samples/s" is a unit.
  const std::string path = R"((^|[^\w/.$-])((board_emu|driver|proto|samples|tests|docs|script)/[\w./-]{2,}))";
  std::size_t named = 0;
  for (const std::string& document : documents()) {
    for (std::string name : matches(text_of(kSource / document), path, 2)) {
      while (name.ends_with('.') || name.ends_with('/') || name.ends_with('-')) name.pop_back();
      ++named;
      EXPECT_TRUE(paths().contains(is_placeholder(name) ? name.substr(0, name.rfind('/')) : name))
          << document << " names " << name;
    }
  }
  EXPECT_GT(named, 50u);
}

TEST(Documents, NameOnlySourceFilesThatExist) {
  std::size_t named = 0;
  for (const std::string& document : documents()) {
    for (const std::string& name : matches(text_of(kSource / document), R"(`([\w/-]+\.(h|cpp|proto|md))`)", 1)) {
      if (is_placeholder(name)) continue;
      ++named;
      EXPECT_TRUE(std::any_of(paths().begin(), paths().end(),
                              [&](const std::string& path) { return path == name || path.ends_with("/" + name); }))
          << document << " names " << name;
    }
  }
  EXPECT_GT(named, 20u);
}

TEST(Sources, CiteOnlyDocumentsThatExist) {
  for (const std::string& path : paths()) {
    const fs::path file = kSource / path;
    const std::string extension = file.extension().string();
    const bool source = path.starts_with("script/") || file.filename() == "CMakeLists.txt" || extension == ".h" ||
                        extension == ".cpp" || extension == ".proto" || extension == ".scene";
    if (!source || !fs::is_regular_file(file)) continue;
    const std::string text = text_of(file);
    if (text.find("docs/") == std::string::npos) continue;
    for (const std::string& cited : matches(text, R"(docs/[\w/-]+\.md)", 0)) {
      EXPECT_TRUE(paths().contains(cited)) << path << " cites " << cited;
    }
  }
}

TEST(Sources, CiteOnlyRulesThatExist) {
  const std::string page = text_of(kSource / "docs/reference/hardware.md");
  std::size_t cited = 0;
  for (const std::string& path : paths()) {
    const bool source = path.ends_with(".h") || path.ends_with(".cpp");
    if (!source || !(path.starts_with("board_emu/") || path.starts_with("driver/") || path.starts_with("tests/"))) {
      continue;
    }
    for (const std::string& cites : matches(text_of(kSource / path), R"(\[(C, )?(H\d{3,4}[-, H\d]*)\])", 2)) {
      for (const std::string& rule : matches(cites, R"(H\d{3,4})", 0)) {
        ++cited;
        EXPECT_NE(page.find("**" + rule + "**"), std::string::npos) << path << " cites " << rule;
      }
    }
  }
  EXPECT_GT(cited, 60u);
}

TEST(Tree, ShowsTheProductAtItsRoot) {
  std::vector<std::string> folders;
  std::copy_if(paths().begin(), paths().end(), std::back_inserter(folders), [](const std::string& path) {
    return path.find('/') == std::string::npos && fs::is_directory(kSource / path);
  });
  EXPECT_EQ(folders, (std::vector<std::string>{"board_emu", "docs", "driver", "proto", "samples", "script", "tests"}));
}

}  // namespace
