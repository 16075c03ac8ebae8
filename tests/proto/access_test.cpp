#include "gicube/access.h"

#include <sys/stat.h>

#include <ios>

#include "gicube/registry.h"
#include "own_registry.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube {
namespace {

class TokenFile : public testing::Test {
 protected:
  std::string write(const std::string& text, mode_t mode = 0600) const {
    std::ofstream(path_) << text;
    ::chmod(path_.c_str(), mode);
    return path_;
  }
  std::string refusal() const {
    return message_of<std::runtime_error>([&] { read_tokens(path_); });
  }

  reference::TemporaryDirectory folder_;
  std::string path_ = folder_.file("token");
};

TEST_F(TokenFile, IsReadWithoutItsLineEnd) {
  EXPECT_EQ(read_tokens(write("0123456789abcdef\r\n")).front().token, "0123456789abcdef");
  EXPECT_EQ(read_tokens(write("0123456789abcdef", 0400)).front().token, "0123456789abcdef");
}

TEST_F(TokenFile, SaysWhatTheHolderOfEachTokenMayDo) {
  const auto tokens =
      read_tokens(write("0123456789abcdef\n\nread 0123456789abcde1\nuse 0123456789abcde2\ncontrol 0123456789abcde3\n"));
  EXPECT_EQ(right_of(tokens, "0123456789abcdef"), Right::kControl);
  EXPECT_EQ(right_of(tokens, "0123456789abcde1"), Right::kRead);
  EXPECT_EQ(right_of(tokens, "0123456789abcde2"), Right::kUse);
  EXPECT_EQ(right_of(tokens, "0123456789abcde3"), Right::kControl);
  for (const char* wrong : {"", "0123456789abcde", "0123456789abcdef0", "0123456789abcdeg", "read 0123456789abcde1"}) {
    EXPECT_EQ(right_of(tokens, wrong), std::nullopt) << wrong;
  }
}

TEST_F(TokenFile, ThatOthersCanReadIsRefused) {
  for (const mode_t mode : {0640u, 0604u, 0660u, 0644u}) {
    write("0123456789abcdef", mode);
    EXPECT_THAT(refusal(), HasSubstr("only its owner can read (mode 600), got mode 6")) << std::oct << mode;
  }
}

TEST_F(TokenFile, ThatIsMissingShortHugeOrNoFileIsRefused) {
  EXPECT_THAT(refusal(), HasSubstr("No such file"));
  write("0123456789abcde\n");
  EXPECT_THAT(refusal(), HasSubstr("16 to 512 characters, got 15"));
  write(std::string(513, 'x'));
  EXPECT_THAT(refusal(), HasSubstr("16 to 512 characters, got 513"));
  write(std::string(100'000, '\n'));
  EXPECT_THAT(refusal(), HasSubstr("at most 65536 bytes"));
  write("\n");
  EXPECT_THAT(refusal(), HasSubstr("expected a token, got none"));
  write("write 0123456789abcdef");
  EXPECT_THAT(refusal(), HasSubstr("expected read, use or control before a token"));
  write("use 0123456789\tabcdef");
  EXPECT_THAT(refusal(), HasSubstr("printable characters"));
  EXPECT_THROW(read_tokens("/"), std::runtime_error);
  EXPECT_THROW(read_tokens("/dev/zero"), std::runtime_error);
}

TEST_F(TokenFile, IsWrittenForItsOwnerAloneInPlaceOfWhatWasThere) {
  write("another one, that all may read", 0644);
  write_token(path_, "0123456789abcdef");
  struct stat status {};
  ASSERT_EQ(::stat(path_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  EXPECT_EQ(read_tokens(path_).front().token, "0123456789abcdef");
  EXPECT_THROW(write_token("/nowhere/token", "0123456789abcdef"), std::runtime_error);
}

TEST(Token, ANewOneHas256BitsOfWhichNoneStands) {
  const std::string first = new_token(), second = new_token();
  EXPECT_EQ(first.size(), 64u);
  EXPECT_EQ(first.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(first.substr(0, 32), second.substr(0, 32));
  EXPECT_NE(first.substr(32), second.substr(32));
}

// Another user may listen at the same port of another address: he must not be sent it.
TEST(LocalToken, IsForTheAddressesThatTheBoardListensAtAndNoOthers) {
  const reference::OwnRegistry registry;
  EXPECT_EQ(local_token("127.0.0.1", 4711), "") << "there is no registry";
  ASSERT_EQ(::mkdir(registry.folder().c_str(), 0700), 0);
  write_token(token_file(registry.folder(), "127.0.0.1", 4711), "token_of_127.0.0.1");
  write_token(token_file(registry.folder(), "0.0.0.0", 4712), "token_of_all_of_4");
  write_token(token_file(registry.folder(), "::", 4713), "token_of_all_of_6");
  write_token(token_file(registry.folder(), "192.0.2.1", 4714), "token_of_192.0.2.1");
  EXPECT_EQ(local_token("127.0.0.1", 4711), "token_of_127.0.0.1");
  EXPECT_EQ(local_token("127.0.0.1", 4712), "token_of_all_of_4");
  EXPECT_EQ(local_token("::1", 4713), "token_of_all_of_6");
  EXPECT_EQ(local_token("127.0.0.2", 4711), "");
  EXPECT_EQ(local_token("::1", 4711), "");
  EXPECT_EQ(local_token("::1", 4712), "");
  EXPECT_EQ(local_token("127.0.0.1", 4713), "");
  EXPECT_EQ(local_token("192.0.2.1", 4714), "");
  EXPECT_EQ(local_token("127.0.0.1", 4715), "");
  ASSERT_EQ(::chmod(registry.folder().c_str(), 0755), 0);
  EXPECT_EQ(local_token("127.0.0.1", 4711), "") << "others may have been in the folder";
}

}  // namespace
}  // namespace gicube
