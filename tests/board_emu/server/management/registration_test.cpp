// What a board process tells those who find its socket in the registry.
#include "server/management/registration.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/asio/local/stream_protocol.hpp>

#include "../bus/served_boards.h"
#include "gicube/registry.h"
#include "gicube/v1/management.pb.h"
#include "own_registry.h"
#include "test.h"

namespace gicube::emu {
namespace {

namespace fs = std::filesystem;

v1::BoardProcess told_by(const std::string& path) {
  boost::asio::local::stream_protocol::iostream stream{boost::asio::local::stream_protocol::endpoint(path)};
  v1::BoardProcess told;
  EXPECT_TRUE(told.ParseFromIstream(&stream)) << path;
  return told;
}

std::string refusal_of(const std::vector<BoardSlot*>& boards) {
  try {
    const Registration registration("", boards);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

// The registry's folder, as a board would make it.
std::string private_folder(const reference::OwnRegistry& registry) {
  fs::create_directory(registry.folder());
  fs::permissions(registry.folder(), fs::perms::owner_all);
  return registry.folder();
}

std::set<std::string> names_in(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

// The number of a process that is no more.
pid_t ended_process() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  return child;
}

// A socket on which nobody listens.
void leave_socket(const std::string& path) {
  boost::asio::io_context io;
  boost::asio::local::stream_protocol::socket(io, boost::asio::local::stream_protocol::endpoint(path));
}

TEST(Registration, TellsEveryCallerWhatTheBoardsAre) {
  const reference::OwnRegistry registry;
  ServedBoards boards(2);
  const Registration registration("unix:/somewhere", boards.all());
  EXPECT_EQ(registration.path(), registry.folder() + "/" + std::to_string(::getpid()));
  for (int call = 0; call < 3; ++call) {
    const v1::BoardProcess told = told_by(registration.path());
    EXPECT_EQ(told.pid(), static_cast<std::uint32_t>(::getpid()));
    EXPECT_EQ(told.management_endpoint(), "unix:/somewhere");
    ASSERT_EQ(told.boards_size(), 2);
    ASSERT_EQ(told.counters_size(), 2);
    EXPECT_EQ(told.boards(1).bus_endpoint(), boards.all()[1]->info().endpoint);
    EXPECT_EQ(told.counters(1).board(), 1u);
    EXPECT_GT(told.counters(1).counters_size(), 0);
  }
}

TEST(Registration, TellsWhatTheAuditLogCounts) {
  const reference::OwnRegistry registry;
  ServedBoards boards(1);
  Audit audit;
  audit.note(AuditEvent::kReset, "somebody", "");
  const Registration registration("", boards.all(), &audit);
  std::map<std::string, std::uint64_t> counts;
  const v1::BoardProcess told = told_by(registration.path());
  for (const v1::AuditCount& each : told.events()) counts[each.event()] = each.count();
  EXPECT_EQ(counts.size(), 15u);
  EXPECT_EQ(counts["reset"], 1u);
  EXPECT_EQ(counts["connected"], 0u);
}

TEST(Registration, TellsHowMuchOfEachLimitIsTaken) {
  const reference::OwnRegistry registry;
  ServedBoards boards(2);
  const Registration registration("", boards.all(), nullptr, [&boards] { return boards.server.quotas(); });
  using Key = std::pair<std::string, int>;  // the board; -1: none
  const auto quotas = [&registration] {
    std::map<Key, std::pair<std::uint64_t, std::uint64_t>> all;
    const v1::BoardProcess told = told_by(registration.path());
    for (const v1::Quota& each : told.quotas()) {
      all[{each.name(), each.has_board() ? static_cast<int>(each.board()) : -1}] = {each.used(), each.limit()};
    }
    return all;
  };
  const std::uint64_t results = patient().max_held_bytes;
  EXPECT_EQ(quotas(), (std::map<Key, std::pair<std::uint64_t, std::uint64_t>>{{{"connections", -1}, {0, 32}},
                                                                              {{"results_bytes", 0}, {0, results}},
                                                                              {{"results_bytes", 1}, {0, results}}}))
      << "no board has a limit of memory";
  const reference::RawClient silent = boards.connect();
  while (quotas()[{"connections", -1}].first == 0) std::this_thread::yield();
  reference::RawClient client = boards.open({}, 1);
  const std::vector<std::uint8_t> none(1);
  for (std::uint32_t id = 1; id <= 3; ++id) client.send(wire::FrameType::kCommand, id, wire::kPosted, none);
  client.read_register(wire::reg::kId);
  EXPECT_GT((quotas()[{"results_bytes", 1}].first), 0u) << "completions whose credit has not returned";
  EXPECT_EQ((quotas()[{"results_bytes", 0}].first), 0u);
}

TEST(Registration, SaysWhoOwnsABoard) {
  const reference::OwnRegistry registry;
  ServedBoards boards(1);
  const Registration registration("", boards.all());
  EXPECT_FALSE(told_by(registration.path()).boards(0).in_use());
  EXPECT_EQ(told_by(registration.path()).boards(0).owner(), "");
  Claimant who;
  who.name = "somebody";
  ASSERT_EQ(boards.all()[0]->claim(who), Claim::kGranted);
  EXPECT_TRUE(told_by(registration.path()).boards(0).in_use());
  EXPECT_EQ(told_by(registration.path()).boards(0).owner().substr(0, 15), "somebody since ");
  boards.all()[0]->release();
}

TEST(Registration, LeavesAnEmptyAndPrivateFolderBehind) {
  const reference::OwnRegistry registry;
  ServedBoards boards(1);
  { const Registration registration("", boards.all()); }
  EXPECT_TRUE(fs::is_empty(registry.folder()));
  EXPECT_EQ(fs::status(registry.folder()).permissions(), fs::perms::owner_all);
}

TEST(Registration, ReplacesTheSocketOfADeadProcessWithItsNumber) {
  const reference::OwnRegistry registry;
  ServedBoards boards(1);
  private_folder(registry);
  for (const std::string name : {"/", "/."}) std::ofstream(registry.folder() + name + std::to_string(::getpid()));
  const Registration registration("", boards.all());
  EXPECT_EQ(told_by(registration.path()).boards_size(), 1);
}

TEST(Registration, LeavesNoSocketBehindIfItsNameIsTaken) {
  const reference::OwnRegistry registry;
  ServedBoards boards(1);
  const fs::path name = fs::path(private_folder(registry)) / std::to_string(::getpid());
  fs::create_directory(name);
  EXPECT_EQ(refusal_of(boards.all()), name.string() + ": Is a directory");
  EXPECT_EQ(names_in(registry.folder()), std::set{name.filename().string()});
}

TEST(Registration, RemovesWhatKilledProcessesHaveLeftAndNothingElse) {
  const reference::OwnRegistry registry;
  ServedBoards boards(1);
  const std::string folder = private_folder(registry) + '/';
  const std::string killed = std::to_string(ended_process()), living = std::to_string(::getppid()),
                    elsewhere = std::to_string(ended_process()), file = std::to_string(ended_process());
  for (const std::string& name : {killed, "." + killed, living, "." + living, std::string("notes")})
    leave_socket(folder + name);
  boost::asio::io_context io;
  const boost::asio::local::stream_protocol::acceptor listening(
      io, boost::asio::local::stream_protocol::endpoint(folder + elsewhere));
  std::ofstream(folder + file) << "";
  const Registration registration("", boards.all());
  EXPECT_EQ(names_in(registry.folder()),
            (std::set{living, "." + living, std::string("notes"), elsewhere, file, std::to_string(::getpid())}));
}

TEST(Registration, UsesNoFolderThatOthersMayEnter) {
  const reference::OwnRegistry registry;
  ServedBoards boards(1);
  fs::create_directory(registry.folder());
  fs::permissions(registry.folder(), fs::perms::owner_all | fs::perms::group_read);
  EXPECT_EQ(refusal_of(boards.all()), registry.folder() + ": expected a folder of user " + std::to_string(::geteuid()) +
                                          ", mode 700, got mode 740");
  fs::remove(registry.folder());
  fs::create_directory(registry.folder() + "_of_another");
  fs::create_directory_symlink(registry.folder() + "_of_another", registry.folder());
  EXPECT_NE(refusal_of(boards.all()).find("got a file"), std::string::npos);
}

TEST(Registry, OfATestIsNotItsUsers) {
  EXPECT_EQ(fs::path(registry_folder()).parent_path().parent_path(), fs::temp_directory_path());
}

TEST(Registry, IsInTheRuntimeFolderIfThatIsTheUsersOwn) {
  const std::string in_tmp = "/tmp/gicube-" + std::to_string(::geteuid());
  const reference::OwnRegistry registry;
  EXPECT_EQ(registry_folder(), registry.folder());
  ::setenv("XDG_RUNTIME_DIR", "relative", 1);
  EXPECT_EQ(registry_folder(), in_tmp);
  ::setenv("XDG_RUNTIME_DIR", "/no/such/folder", 1);
  EXPECT_EQ(registry_folder(), in_tmp);
  ::unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(registry_folder(), in_tmp);
}

}  // namespace
}  // namespace gicube::emu
