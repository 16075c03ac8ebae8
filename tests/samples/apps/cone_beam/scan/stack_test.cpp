#include "cone_beam/scan/description.h"

#include "full_disk.h"
#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples {
namespace {

Stack ramp(int columns, int rows, int views) {
  Stack stack{columns, rows, {}, false};
  for (int i = 0; i < columns * rows * views; ++i) stack.values.push_back(0.25F * static_cast<float>(i) - 3);
  return stack;
}

class StackFormat : public testing::TestWithParam<const char*> {};

TEST_P(StackFormat, ComesBackAsItWasWritten) {
  const reference::TemporaryDirectory folder;
  const Stack stack = ramp(5, 4, 3);
  StackFiles files{write_stack(stack, folder.file(std::string("a") + GetParam())), {}};
  if (std::string(GetParam()) == ".raw") {
    files.raw = RawLayout{};
    files.raw->dims = {5, 4, 0};
    files.raw->type = SampleType::kFloat32;
  }
  const Stack read = read_stack(files);
  EXPECT_EQ(read.columns, 5);
  EXPECT_EQ(read.rows, 4);
  EXPECT_EQ(read.views(), 3u);
  EXPECT_EQ(read.values, stack.values);
  EXPECT_FALSE(read.counts);
}

INSTANTIATE_TEST_SUITE_P(All, StackFormat, testing::Values(".raw", ".nrrd", ".mhd", ".mha", ".pfm", ".tif"),
                         [](const auto& format) { return std::string(format.param).substr(1); });

TEST_P(StackFormat, LeavesNothingOnAFullDisk) {
  const Stack stack = ramp(40, 40, 4);  // 6400 bytes a view
  const bool views_apart = std::string(GetParam()) == ".pfm" || std::string(GetParam()) == ".tif";
  const auto write = [&](const std::string& folder) { write_stack(stack, folder + "/a" + GetParam()); };
  for (const std::size_t room : {std::size_t{0}, reference::kDiskBlock}) {
    reference::expect_full_disk_leaves_nothing(
        (views_apart ? "a_0000" : "a") + std::string(GetParam()), room,
        [&](const std::string& file) { write(std::filesystem::path(file).parent_path().string()); });
  }
  // Room for the first views, but not for all.
  reference::on_full_disks("b", 4 * reference::kDiskBlock, [&](const std::string& folder, const std::string& reason) {
    if (reason == "File too large" && views_apart) return;  // each of them is small enough
    EXPECT_THROW(write(folder), FileError);
    EXPECT_EQ(reference::files_in(folder).size(), 1u);
  });
}

class StackFile : public testing::Test {
 protected:
  StackFiles raw(const std::string& bytes, SampleType type = SampleType::kUint16) const {
    StackFiles files{{folder_.write("a.raw", bytes)}, RawLayout{}};
    files.raw->dims = {2, 1, 0};
    files.raw->type = type;
    return files;
  }
  static std::string error_of(const StackFiles& files) {
    return message_of<FileError>([&] { read_stack(files); });
  }

  const reference::TemporaryDirectory folder_;
};

TEST_F(StackFile, HasAsManyRawViewsAsItsBytesHold) {
  const Stack stack = read_stack(raw(std::string("\1\0\2\0\3\0\4\0", 8)));
  EXPECT_EQ(stack.views(), 2u);
  EXPECT_THAT(stack.values, ElementsAre(1, 2, 3, 4));
  EXPECT_TRUE(stack.counts);
}

TEST_F(StackFile, FollowsTheOnesBeforeIt) {
  StackFiles files = raw(std::string("\1\0\2\0", 4));
  files.files.push_back(folder_.write("b.raw", std::string("\5\0\6\0\7\0\10\0", 8)));
  EXPECT_THAT(read_stack(files).values, ElementsAre(1, 2, 5, 6, 7, 8));
}

TEST_F(StackFile, IsRefusedWithWhatIsWrong) {
  EXPECT_THAT(error_of(raw("abc")), HasSubstr("a.raw: size: expected 0 bytes and 1 to 4096 views of 2 x 1 pixels"));
  EXPECT_THAT(error_of(raw("")), HasSubstr("got 0 bytes"));
  EXPECT_THAT(error_of({{folder_.file("none.raw")}, {}}), HasSubstr("none.raw"));
  const float bad = std::numeric_limits<float>::quiet_NaN();
  const std::string bytes = std::string(4, '\0') + std::string(reinterpret_cast<const char*>(&bad), 4);
  EXPECT_THAT(error_of(raw(bytes, SampleType::kFloat32)),
              HasSubstr("view 0, pixel 1: expected a finite value, got nan"));
  StackFiles mixed = raw(std::string("\1\0\2\0", 4));
  mixed.files.push_back(write_stack(ramp(3, 1, 1), folder_.file("c.mha")).front());
  EXPECT_THAT(error_of(mixed), HasSubstr("c.mha: size: expected 2 x 1 as in the first file, got 3 x 1"));
}

}  // namespace
}  // namespace gicube::samples
