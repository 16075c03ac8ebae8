// Which layer may include which: the rules of docs/ARCHITECTURE.md as a table, and a checker over #include lines.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace gicube::layout {

// A file obeys the rule with the longest `where` that it begins with. A `where` that ends in "/*" holds only for the
// files directly in that folder; a file that no rule fits is a fault.
struct Rule {
  std::string_view where;
  std::vector<std::string_view> ours;  // folders and files of the tree, by their beginning; "/*" as above
  std::vector<std::string_view>
      outside;  // third-party headers, by their beginning; the standard library goes without saying
};

inline constexpr std::string_view kAnything;

const std::vector<Rule>& rules();

// Paths from the root of the tree, with '/'.
using Files = std::set<std::string>;

// One sentence for each include of `text`, the content of `file`, that the rules forbid or that names no file of ours.
std::vector<std::string> faults(const Files& files, const std::string& file, std::string_view text);

}  // namespace gicube::layout
