#include "server/management/management.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <stdexcept>

#include "temporary_directory.h"

namespace gicube::emu {
namespace {

class TokenFile : public testing::Test {
 protected:
  std::string write(const std::string& text, mode_t mode) const {
    std::ofstream(path_) << text;
    ::chmod(path_.c_str(), mode);
    return path_;
  }
  std::string refusal() const {
    try {
      read_token(path_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  reference::TemporaryDirectory folder_;
  std::string path_ = folder_.file("token");
};

TEST_F(TokenFile, IsReadWithoutItsLineEnd) {
  EXPECT_EQ(read_token(write("0123456789abcdef\r\n", 0600)), "0123456789abcdef");
  EXPECT_EQ(read_token(write("0123456789abcdef", 0400)), "0123456789abcdef");
}

TEST_F(TokenFile, ThatOthersCanReadIsRefused) {
  for (const mode_t mode : {0640u, 0604u, 0660u, 0644u}) {
    write("0123456789abcdef", mode);
    EXPECT_THAT(refusal(), testing::HasSubstr("only its owner can read")) << std::oct << mode;
  }
}

TEST_F(TokenFile, ThatIsMissingShortHugeOrNoFileIsRefused) {
  EXPECT_THAT(refusal(), testing::HasSubstr("No such file"));
  write("0123456789abcde\n", 0600);
  EXPECT_THAT(refusal(), testing::HasSubstr("16 to 4095 characters, got 15"));
  write(std::string(5000, 'x'), 0600);
  EXPECT_THAT(refusal(), testing::HasSubstr("16 to 4095"));
  EXPECT_THROW(read_token("/"), std::runtime_error);
}

TEST(Token, OnlyTheWholeTokenAuthorizes) {
  const std::string token = "0123456789abcdef";
  EXPECT_TRUE(is_authorized("Bearer 0123456789abcdef", token));
  for (const char* wrong :
       {"", "Bearer ", "Bearer 0123456789abcdeg", "Bearer 1123456789abcdef", "Bearer 0123456789abcde",
        "Bearer 0123456789abcdef0", "bearer 0123456789abcdef", "0123456789abcdef"}) {
    EXPECT_FALSE(is_authorized(wrong, token)) << wrong;
  }
}

}  // namespace
}  // namespace gicube::emu
