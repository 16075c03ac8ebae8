#include "report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace gicube::conformance {

extern const char* const kProtocol;  // the text of docs/reference/protocol.md

namespace {

std::string text_of(const Case& tested) {
  const std::string_view page = kProtocol;
  const std::string mark = fmt::format("- **{}** ", tested.rule);
  const std::size_t begin = page.find(mark) + mark.size();
  std::string text(page.substr(begin, std::min(page.find("\n- **P", begin), page.find("\n\n", begin)) - begin));
  for (std::size_t at = 0; (at = text.find("\n  ", at)) != std::string::npos;) text.replace(at, 3, " ");
  return text;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += static_cast<unsigned char>(c) < ' ' && c != '\n' ? '?' : c;
    }
  }
  return out;
}

struct Count {
  std::size_t known = 0, run = 0, passed = 0;
  bool whole() const { return known > 0 && passed == known; }
};

std::array<Count, kClasses> counts_of(std::span<const Outcome> outcomes) {
  std::array<Count, kClasses> counts;
  for (const Case& each : all_cases()) ++counts.at(each.level).known;
  for (const Outcome& outcome : outcomes) {
    Count& count = counts.at(outcome.tested.level);
    ++count.run;
    count.passed += outcome.failure.empty() ? 1 : 0;
  }
  return counts;
}

}  // namespace

std::string line_of(const Outcome& outcome) {
  const Case& tested = outcome.tested;
  if (outcome.failure.empty()) return fmt::format("ok    {}  {}  {}\n", tested.level, tested.rule, tested.name);
  return fmt::format("FAIL  {}  {}  {}\n      rule: {}\n      {}\n", tested.level, tested.rule, tested.name,
                     text_of(tested), outcome.failure);
}

std::string summary(std::span<const Outcome> outcomes) {
  const auto counts = counts_of(outcomes);
  std::string text, claims;
  for (unsigned level = 0; level < kClasses; ++level) {
    const Count& count = counts.at(level);
    text +=
        fmt::format("class {} ({}): {} of {} cases passed{}\n", level, kClassNames[level], count.passed, count.known,
                    count.run < count.known ? fmt::format(", {} not run", count.known - count.run) : "");
    if (counts[0].whole() && count.whole()) claims += fmt::format("{}{}", claims.empty() ? "" : ", ", level);
  }
  return text +
         (claims.empty() ? "this board may claim no class\n" : fmt::format("this board may claim class {}\n", claims));
}

std::string junit(std::span<const Outcome> outcomes, const std::string& uri) {
  std::string cases;
  double seconds = 0;
  std::size_t failures = 0;
  for (const Outcome& outcome : outcomes) {
    seconds += outcome.seconds;
    cases += fmt::format("  <testcase classname=\"class{}\" name=\"{}\" time=\"{:.3f}\">\n", outcome.tested.level,
                         outcome.tested.name, outcome.seconds);
    cases += fmt::format("    <properties><property name=\"rule\" value=\"{}\"/></properties>\n", outcome.tested.rule);
    if (!outcome.failure.empty()) {
      ++failures;
      cases += fmt::format("    <failure message=\"{}\">{}: {}</failure>\n", escaped(outcome.failure),
                           outcome.tested.rule, escaped(text_of(outcome.tested)));
    }
    cases += "  </testcase>\n";
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<testsuite name=\"gicube-conformance\" hostname=\"{}\" tests=\"{}\" failures=\"{}\" time=\"{:.3f}\">\n{}"
      "</testsuite>\n",
      escaped(uri), outcomes.size(), failures, seconds, cases);
}

std::string listed(std::span<const Case> cases) {
  std::string text;
  for (const Case& each : cases) {
    text += fmt::format("{}  {}  {}\n      {}\n", each.level, each.rule, each.name, text_of(each));
  }
  return text;
}

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (const auto& group :
       {handshake_cases(), frame_cases(), credit_cases(), register_cases(), memory_cases(), command_cases(),
        sample_cases(), picture_cases(), ray_cases(), deposit_cases(), light_cases(), time_cases(), session_cases()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace gicube::conformance
