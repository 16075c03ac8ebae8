#include "scene/program/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <new>

#include "gicube/scene/error.h"
#include "scene/names.h"
#include "scene/program/board_options.h"
#include "scene/program/progress.h"

namespace gicube::samples {
namespace {

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
  EXPECT_NO_THROW(check_folder(""));
  EXPECT_NO_THROW(check_folder("a.png"));
  EXPECT_NO_THROW(check_folder("/tmp/a.png"));
  EXPECT_THROW(check_folder("/nowhere/a.png"), InputError);
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
