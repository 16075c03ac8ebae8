#include "gicube/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <system_error>

#include "full_disk.h"
#include "test.h"

namespace gicube {
namespace {

namespace fs = std::filesystem;
using reference::files_in;
using Files = std::map<std::string, std::string>;

class WholeFileTest : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.file(name); }
  Files files() const { return files_in(folder_.path()); }
  static void write(const std::string& file, const std::string& text) {
    WholeFile whole(file);
    whole.write(text);
    whole.commit();
  }

 private:
  const reference::TemporaryDirectory folder_;
};

TEST_F(WholeFileTest, HasItsNameOnlyWhenItIsWhole) {
  std::ofstream(path("a")) << "before";
  WholeFile whole(path("a"));
  whole.write("what comes");
  whole.close();
  const Files open = files();
  ASSERT_EQ(open.size(), 2u);
  EXPECT_EQ(open.at("a"), "before");
  EXPECT_THAT(open.rbegin()->first, AllOf(StartsWith("a."), EndsWith(".part")));
  EXPECT_EQ(open.rbegin()->second, "what comes");
  whole.commit();
  EXPECT_EQ(files(), (Files{{"a", "what comes"}}));
}

TEST_F(WholeFileTest, LeavesNothingWithoutACommit) {
  std::ofstream(path("a")) << "before";
  {
    WholeFile whole(path("a")), fresh(path("b"));
    whole.write("what comes");
    fresh.write(std::string(1 << 20, 'x'));
  }
  EXPECT_EQ(files(), (Files{{"a", "before"}}));
}

TEST_F(WholeFileTest, LeavesNothingOnAFullDisk) {
  for (const std::size_t room : {std::size_t{0}, reference::kDiskBlock}) {
    reference::expect_full_disk_leaves_nothing("a", room, [](const std::string& file) {
      WholeFile whole(file);
      for (int i = 0; i < 1000; ++i) whole.write("some words and more");
      whole.commit();
    });
  }
}

TEST_F(WholeFileTest, HoldsAllThatWasWrittenInPiecesOfAnySize) {
  std::string all;
  WholeFile whole(path("a"));
  for (const std::size_t size : {1u, 65535u, 3u, 65536u, 200'000u, 0u, 7u}) {
    const std::string piece(size, static_cast<char>('a' + all.size() % 26));
    whole.write(piece);
    all += piece;
  }
  const std::array<float, 2> numbers{1.5F, -2};
  whole.write(std::span(numbers));
  all.append(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
  whole.commit();
  EXPECT_EQ(files().at("a"), all);
}

TEST_F(WholeFileTest, FollowsLinksAlsoToWhatIsNotThereYet) {
  std::ofstream(path("far")) << "before";
  fs::create_directory(path("folder"));
  fs::create_symlink("../far", path("folder/near"));
  fs::create_symlink("folder/near", path("link"));
  fs::create_symlink("folder/new", path("dangling"));
  write(path("link"), "what comes");
  write(path("dangling"), "new");
  EXPECT_TRUE(fs::is_symlink(path("link")) && fs::is_symlink(path("folder/near")) && fs::is_symlink(path("dangling")));
  EXPECT_FALSE(fs::is_symlink(path("far")));
  EXPECT_EQ(files_in(path("folder")), (Files{{"near", "what comes"}, {"new", "new"}}));
  fs::create_symlink("round", path("round"));
  EXPECT_THAT([&] { write(path("round"), "a"); },
              ThrowsMessage<std::system_error>(path("round") + ": Too many levels of symbolic links"));
}

TEST_F(WholeFileTest, KeepsTheModeOfWhatItReplaces) {
  for (const unsigned mode : {0755U, 0640U, 0604U, 0200U}) {
    std::ofstream(path("a")) << "before";
    fs::permissions(path("a"), fs::perms(mode));
    write(path("a"), "what comes");
    EXPECT_EQ(fs::status(path("a")).permissions(), fs::perms(mode));
    fs::remove(path("a"));
  }
}

TEST_F(WholeFileTest, RefusesWhatIsReadOnly) {
  std::ofstream(path("a")) << "before";
  fs::permissions(path("a"), fs::perms(0444));
  fs::create_symlink("a", path("link"));
  for (const char* name : {"a", "link"}) {
    EXPECT_THAT([&] { write(path(name), "b"); }, ThrowsMessage<std::system_error>(path(name) + ": Permission denied"));
    EXPECT_FALSE(may_be_written(path(name)));
  }
  EXPECT_EQ(files(), (Files{{"a", "before"}, {"link", "before"}}));
  EXPECT_TRUE(may_be_written(path("none")) && may_be_written(path("")));
}

TEST_F(WholeFileTest, CanBeItsOwnersAlone) {
  std::ofstream(path("a")) << "before";
  fs::permissions(path("a"), fs::perms(0644));
  WholeFile whole(path("a"), 0600);
  whole.close();
  ASSERT_EQ(files().size(), 2u);
  EXPECT_EQ(fs::status(path(files().rbegin()->first)).permissions(), fs::perms(0600));
  whole.commit();
  EXPECT_EQ(fs::status(path("a")).permissions(), fs::perms(0600));
}

TEST_F(WholeFileTest, GoesIntoAPipeDirectly) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const int reader = ::open(path("pipe").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  write(path("pipe"), "what comes");
  std::array<char, 64> text{};
  EXPECT_EQ(::read(reader, text.data(), text.size()), 10);
  EXPECT_STREQ(text.data(), "what comes");
  ::close(reader);
  EXPECT_TRUE(fs::is_fifo(path("pipe")));
}

// The case of `--stats /dev/stdout >> FILE`.
TEST_F(WholeFileTest, GoesOnWhereThisProcessIsInAFile) {
  const int own = ::open(path("a").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  ASSERT_GE(own, 0);
  EXPECT_EQ(::write(own, "one ", 4), 4);
  write("/dev/fd/" + std::to_string(own), "two ");
  fs::create_symlink("/proc/self/fd/" + std::to_string(own), path("stdout"));
  write(path("stdout"), "three");
  EXPECT_TRUE(fs::is_symlink(path("stdout")));
  fs::remove(path("stdout"));
  ::close(own);
  EXPECT_EQ(files().at("a"), "one two three");
}

TEST_F(WholeFileTest, SaysWhatIsFullOrCannotBeWritten) {
  EXPECT_THAT([] { write("/dev/full", "a"); }, ThrowsMessage<std::system_error>("/dev/full: No space left on device"));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  EXPECT_THAT([] { write("/nowhere/a", "a"); },
              ThrowsMessage<std::system_error>("/nowhere/a: No such file or directory"));
  fs::create_directory(path("folder"));
  EXPECT_THAT([&] { write(path("folder"), "a"); },
              ThrowsMessage<std::system_error>(path("folder") + ": Is a directory"));
}

}  // namespace
}  // namespace gicube
