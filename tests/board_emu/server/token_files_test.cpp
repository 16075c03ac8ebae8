#include "server/token_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>

#include "gicube/access.h"
#include "own_registry.h"

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

}  // namespace
}  // namespace gicube::emu
