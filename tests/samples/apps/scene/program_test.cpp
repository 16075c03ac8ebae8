#include "scene/program/program.h"

#include <pty.h>
#include <unistd.h>

#include <cstdio>
#include <new>

#include "full_disk.h"
#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/names.h"
#include "scene/program/board_options.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"
#include "test.h"

namespace gicube::samples {
namespace {

std::string here() { return std::filesystem::current_path().filename().string(); }

TEST(Program, GivesTheBodysExitCodeAndSaysNothing) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_program("gicube-x", [] { return 7; }), 7);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Program, MakesALineAndACodeOfWhatIsThrown) {
  const auto expect = [](const auto& error, int code, const char* text) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_program("gicube-x", [&]() -> int { throw error; }), code);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), text);
  };
  expect(UsageError("--size: no"), 2, "gicube-x: --size: no\n");
  expect(InputError("a file", "one", "none"), 1, "gicube-x: a file: expected one, got none\n");
  expect(std::bad_alloc(), 1, "gicube-x: out of memory\n");
}

TEST(Program, LooksForTheFolderBeforeTheWork) {
  EXPECT_NO_THROW(check_outputs({{"-o", ""}, {"--stats", ""}}));
  EXPECT_NO_THROW(check_outputs({{"-o", "a.png"}}));
  EXPECT_NO_THROW(check_outputs({{"-o", "/tmp/a.png"}}));
  EXPECT_THROW(check_outputs({{"-o", "/nowhere/a.png"}}), InputError);
}

TEST(Program, RefusesOneFileForTwoOptionsBeforeTheWork) {
  EXPECT_THAT(
      [] {
        check_outputs({{"-o", "a.png"}, {"--stats", "./../" + here() + "/a.png"}});
      },
      ThrowsMessage<UsageError>(StartsWith("--stats: expected another file than -o, got ")));
  EXPECT_NO_THROW(check_outputs({{"-o", "a.png"}, {"-o", "a.png"}, {"--stats", "b.png"}}));
  EXPECT_NO_THROW(check_outputs({{"-o", "/dev/null"}, {"--stats", "/dev/null"}}));
}

TEST(Program, RefusesToReplaceWhatIsReadAlsoByNamesThatItDerives) {
  const auto clean = [] {
    for (const char* name : {"in.raw", "in.textproto", "link.textproto", "slices"}) std::filesystem::remove_all(name);
  };
  clean();
  std::filesystem::create_directory("slices");
  for (const char* name : {"in.raw", "in.textproto", "slices/s_0001.png", "slices/notes.json"})
    std::ofstream(name) << 1;
  std::filesystem::create_symlink("in.textproto", "link.textproto");
  const auto expect_refused = [](const Output& output, const std::filesystem::path& input) {
    EXPECT_THROWS(UsageError, ": expected a name whose files are not read, got",
                  check_outputs({output}, {"", "builtin:buckyball", input}))
        << output.file;
  };
  expect_refused({"-o", "in.textproto"}, "./../" + here() + "/in.textproto");
  expect_refused({"-o", "in.textproto"}, "link.textproto");
  expect_refused({"-o", "in.mhd"}, "in.raw");  // which an .mhd has beside it
  expect_refused({"-o", "slices/s_0001.png"}, "slices");
  EXPECT_NO_THROW(check_outputs({{"-o", "slices/s_0002.png"}, {"--stats", "slices/notes.json"}}, {"slices", "in.raw"}));
  EXPECT_THROW(check_outputs({{"-o", "a.mhd"}, {"--stats", "a.raw"}}), UsageError);
  clean();
}

TEST(Program, RefusesAReadOnlyFileBeforeTheWorkAndKnowsOneByItsLinks) {
  const reference::TemporaryDirectory folder;
  std::ofstream(folder.file("a")) << "before";
  std::filesystem::create_symlink("a", folder.file("b"));
  EXPECT_THROW(check_outputs({{"-o", folder.file("a")}, {"--stats", folder.file("b")}}), UsageError);
  std::filesystem::permissions(folder.file("a"), std::filesystem::perms(0444));
  EXPECT_THAT(
      [&] {
        check_outputs({{"-o", folder.file("b")}});
      },
      ThrowsMessage<InputError>(folder.file("b") + ": expected a file that may be written to, got a read-only one"));
}

TEST(Program, PrintsWarningsOfFiles) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_program("gicube-x",
                        [] {
                          scene::warn("a.raw", "data", "1 byte", "2");
                          return 0;
                        }),
            0);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "gicube-x: warning: a.raw: data: expected 1 byte, got 2\n");
}

// The bytes of a line of progress on a terminal of this kind.
std::string shown_on(const char* terminal) {
  int master = -1, slave = -1;
  EXPECT_EQ(::openpty(&master, &slave, nullptr, nullptr, nullptr), 0);
  const std::string before = std::getenv("TERM") != nullptr ? std::getenv("TERM") : "";
  ::setenv("TERM", terminal, 1);
  std::FILE* const stream = ::fdopen(slave, "w");
  ProgressLine(true, stream).show("reading");
  std::fputs("end", stream);
  std::fclose(stream);
  ::setenv("TERM", before.c_str(), 1);
  std::array<char, 64> text{};
  const auto read = ::read(master, text.data(), text.size());
  ::close(master);
  return {text.data(), static_cast<std::size_t>(std::max<ssize_t>(read, 0))};
}

TEST(ProgressLine, SendsNoCodesToATerminalThatHasNone) {
  EXPECT_EQ(shown_on("xterm"), "\r\x1b[Kreading\r\x1b[Kend");
  EXPECT_EQ(shown_on("dumb"), "end");
}

TEST(Program, FailsIfWhatItPrintedGotNowhere) {
  EXPECT_EXIT(
      {
        if (std::freopen("/dev/full", "w", stdout) == nullptr) std::_Exit(3);
        std::_Exit(run_program("gicube-x", [] { return std::printf("a figure\n") > 0 ? 0 : 4; }));
      },
      testing::ExitedWithCode(1), "gicube-x: standard output: No space left on device");
}

TEST(Program, LeavesNoStatisticsOnAFullDisk) {
  reference::expect_full_disk_leaves_nothing("a.json", 0, [](const std::string& file) {
    write_json({{"rays", 3}}, {}, file);
  });
}

TEST(Program, WritesStatisticsWithTextsThatAreNoUtf8) {
  const reference::TemporaryDirectory folder;
  write_json({{"name", "gr\xfc"}}, {}, folder.file("a.json"));
  EXPECT_EQ(reference::files_in(folder.path()).at("a.json"), "{\n  \"name\": \"gr\ufffd\"\n}\n");
}

TEST(TimeLeft, IsWhatThePartDonePromises) {
  EXPECT_EQ(time_left(1.9, 50, 100), "");  // too early to say
  EXPECT_EQ(time_left(10, 0, 100), "");
  EXPECT_EQ(time_left(10, 100, 100), "");
  EXPECT_EQ(time_left(10, 25, 100), ", 30 s left");
  EXPECT_EQ(time_left(100, 1, 3), ", 3 min 20 s left");
  EXPECT_EQ(time_left(600, 2, 27), ", 2 h 5 min left");
}

}  // namespace
}  // namespace gicube::samples
