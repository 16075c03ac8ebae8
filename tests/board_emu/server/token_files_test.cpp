#include "server/token_files.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>

#include "gicube/access.h"
#include "own_registry.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

namespace fs = std::filesystem;

TEST(TokenFiles, AreThereForEachTcpEndpointAsLongAsTheProcessIs) {
  const reference::OwnRegistry registry;
  const std::string token = new_token();
  {
    const TokenFiles files(
        {parse_endpoint("tcp:127.0.0.1:4711"), parse_endpoint("unix:/tmp/b"), parse_endpoint("tcp:[::1]:4712")}, token);
    EXPECT_EQ(files.paths().size(), 2u);
    EXPECT_EQ(local_token("127.0.0.1", 4711), token);
    EXPECT_EQ(local_token("::1", 4712), token);
  }
  EXPECT_TRUE(fs::is_empty(registry.folder()));
}

TEST(TokenFiles, OfTheNextProcessAtThatPortAreLeftAlone) {
  const reference::OwnRegistry registry;
  const std::string next = new_token();
  {
    const TokenFiles files({parse_endpoint("tcp:127.0.0.1:4711")}, new_token());
    write_token(files.paths().front(), next);
  }
  EXPECT_EQ(local_token("127.0.0.1", 4711), next);
}

TEST(TokenFiles, NeedARegistryThatNobodyElseMayEnter) {
  const reference::OwnRegistry registry;
  fs::create_directory(registry.folder());
  fs::permissions(registry.folder(), fs::perms::owner_all | fs::perms::others_exec);
  EXPECT_THROW(TokenFiles({parse_endpoint("tcp:127.0.0.1:4711")}, new_token()), std::runtime_error);
  EXPECT_NO_THROW(TokenFiles({parse_endpoint("unix:/tmp/b")}, new_token()));
}

// Needs root, which can be two users: in a process of its own.
TEST(TokenFiles, AreThereEvenIfAnotherUserHasTakenTheNameOfTheirFolder) {
  constexpr uid_t kUser = 61'234;
  if (::geteuid() != 0) GTEST_SKIP() << "expected root, got user " << ::geteuid();
  const reference::TemporaryDirectory home;
  ASSERT_EQ(::chown(home.path().c_str(), kUser, kUser), 0);
  const std::string taken = "/tmp/gicube-" + std::to_string(kUser);
  fs::create_directory(taken);  // root's
  const pid_t child = ::fork();
  if (child == 0) {
    ::unsetenv("XDG_RUNTIME_DIR");
    ::setenv("HOME", home.path().c_str(), 1);
    bool is_good = ::setgid(kUser) == 0 && ::setuid(kUser) == 0;
    const std::string token = new_token();
    try {
      const TokenFiles files({parse_endpoint("tcp:127.0.0.1:4711")}, token);
      is_good = is_good && files.paths().front().starts_with(home.path()) && local_token("127.0.0.1", 4711) == token;
    } catch (const std::runtime_error& error) {
      std::fputs(error.what(), stderr);
      is_good = false;
    }
    ::_exit(is_good ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  fs::remove(taken);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

}  // namespace
}  // namespace gicube::emu
