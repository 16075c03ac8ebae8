// Sources and documents are at most 120 columns wide.
#include "test.h"

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kColumns = 120;

// Code points of UTF-8: bytes that do not continue one.
std::size_t columns(std::string_view line) {
  return static_cast<std::size_t>(
      std::count_if(line.begin(), line.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

bool is_checked(const std::string& path) {
  constexpr std::array kEndings{".h",  ".cpp", ".c",     ".proto",         ".py",        ".pyi",   ".md",
                                ".js", ".tf",  ".cmake", "CMakeLists.txt", ".textproto", ".scene", ".composition"};
  const bool ends = std::any_of(kEndings.begin(), kEndings.end(), [&](const char* end) { return path.ends_with(end); });
  // Inputs of fuzzers and headers of past releases are data.
  return ends && !path.starts_with("tests/fuzz/corpus/") && !path.starts_with("tests/driver/c_api/released/");
}

// Lines that cannot be broken: rows of tables, headings, pictures and code of documents; a name, address or text
// without a blank in which to break it.
class Unbreakable {
 public:
  explicit Unbreakable(bool document) : document_(document) {}

  bool operator()(std::string_view line) {
    const std::string_view text = line.substr(std::min(line.find_first_not_of(' '), line.size()));
    if (document_) {
      const bool fence = text.starts_with("```");
      if (fence) code_ = !code_;
      if (code_ || fence || text.starts_with('|') || text.starts_with('#') || text.starts_with("![")) return true;
      if (line.starts_with("    ")) return true;
    }
    const std::size_t blank = text.find(' ');
    return blank == std::string_view::npos || blank + (line.size() - text.size()) > kColumns;
  }

 private:
  bool document_;
  bool code_ = false;
};

TEST(Columns, AreAtMost120) {
  const fs::path source = GICUBE_SOURCE_DIR;
  std::size_t files = 0;
  for (fs::recursive_directory_iterator entry(source), end; entry != end; ++entry) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(".") || (entry.depth() == 0 && (name == "build" || name == "out"))) {
      entry.disable_recursion_pending();
      continue;
    }
    const std::string path = entry->path().lexically_relative(source).generic_string();
    if (!entry->is_regular_file() || !is_checked(path)) continue;
    ++files;
    std::ifstream lines(entry->path());
    Unbreakable unbreakable(path.ends_with(".md"));
    std::size_t number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      const bool excused = unbreakable(line);
      EXPECT_TRUE(excused || columns(line) <= kColumns)
          << path << ":" << number << " has " << columns(line) << " columns: " << line;
    }
  }
  EXPECT_GT(files, 1500u);
}

}  // namespace
