#include "server/audit.h"

#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

namespace fs = std::filesystem;
using testing::MatchesRegex;

std::vector<std::string> lines_of(const std::string& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::uint64_t count_of(const Audit& audit, const std::string& event) {
  for (const Audit::Count& each : audit.counts()) {
    if (each.event == event) return each.count;
  }
  throw std::runtime_error("no such event: " + event);
}

Audit::Options to_file(const std::string& path) {
  Audit::Options options;
  options.file = path;
  return options;
}

TEST(Audit, SaysWhenWhoDidWhatInOneLine) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("audit");
  for (int process = 0; process < 2; ++process) {
    Audit audit(to_file(path));
    audit.note(AuditEvent::kForced, "127.0.0.1:5", "board 0: ends another client's session");
    audit.note(AuditEvent::kTraced, "a\nb", "\x1b[2J{}");
  }
  const auto when = "[0-9]+-[0-9]+-[0-9]+T[0-9]+:[0-9]+:[0-9]+\\.[0-9]+Z ";
  const auto first = MatchesRegex(std::string(when) + "forced: 127.0.0.1:5: board 0: ends another client's session");
  const auto second = EndsWith("traced: a?b: ?[2J{}");
  EXPECT_THAT(lines_of(path), ElementsAre(first, second, first, second)) << "it is appended to";
}

TEST(Audit, AFloodOfOneKindIsCountedAndHidesNoOther) {
  const reference::TemporaryDirectory folder;
  Audit::Options options = to_file(folder.file("audit"));
  options.burst = 3;
  options.refill = std::chrono::hours(1);
  Audit audit(options);
  for (int i = 0; i < 1000; ++i) audit.note(AuditEvent::kUnknown, "somebody", "its token is wrong");
  audit.note(AuditEvent::kReset, "the owner", "");
  const auto guess = EndsWith("unknown: somebody: its token is wrong");
  EXPECT_THAT(lines_of(options.file), ElementsAre(guess, guess, guess, EndsWith("reset: the owner")));
  EXPECT_EQ(count_of(audit, "unknown"), 1000u);
  EXPECT_EQ(count_of(audit, "reset"), 1u);
  EXPECT_EQ(count_of(audit, "opened"), 0u);
}

TEST(Audit, WhatWasLeftOutIsInTheNextLine) {
  const reference::TemporaryDirectory folder;
  Audit::Options options = to_file(folder.file("audit"));
  options.burst = 0;
  options.refill = std::chrono::hours(1);
  {
    Audit audit(options);
    audit.note(AuditEvent::kRefused, "a", "b");
    EXPECT_EQ(count_of(audit, "refused"), 1u);
  }
  EXPECT_THAT(lines_of(options.file), ElementsAre());
  options.burst = 1;
  options.refill = std::chrono::milliseconds(1);
  Audit audit(options);
  std::vector<std::string> lines;
  while (lines.empty() ||
         lines.back().find("more left out") == std::string::npos) {  // by the clock: once a millisecond
    audit.note(AuditEvent::kRefused, "a", "b");
    lines = lines_of(options.file);
  }
  EXPECT_THAT(lines.back(), MatchesRegex(".*refused: a: b \\([0-9]+ more left out\\)"));
}

TEST(Audit, TheFileAndTheFormerOneStayWithinTheirBounds) {
  const reference::TemporaryDirectory folder;
  Audit::Options options = to_file(folder.file("audit"));
  options.max_file_bytes = 2000;
  options.burst = 1000;
  Audit audit(options);
  for (int i = 0; i < 500; ++i) audit.note(AuditEvent::kConnected, "somebody", std::to_string(i));
  EXPECT_LE(fs::file_size(options.file), 2000u);
  EXPECT_LE(fs::file_size(folder.file("audit.1")), 2000u);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 2);
  EXPECT_THAT(lines_of(options.file).back(), EndsWith("connected: somebody: 499"));
}

TEST(Audit, AFileThatCannotBeWrittenIsNamed) {
  EXPECT_THAT([] { const Audit audit(to_file("/proc/nowhere/audit")); },
              ThrowsMessage<std::runtime_error>(AllOf(StartsWith("--audit-log: "), HasSubstr("/proc/nowhere"))));
}

}  // namespace
}  // namespace gicube::emu
