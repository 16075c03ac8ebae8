// gicube-smi without a command: the boards of this user on this machine; and where its options may stand.
#include <csignal>
#include <nlohmann/json.hpp>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/write.hpp>

#include "board_process.h"
#include "gicube/board.h"
#include "gicube/c_api.h"
#include "gicube/enumerate.h"
#include "own_registry.h"
#include "run_program.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::tools_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using reference::OwnRegistry;
using reference::TemporaryDirectory;
using system_test::BoardProcess;
using testing::Not;

// A board process that listens.
struct Listening {
  explicit Listening(std::vector<std::string> more = {})
      : process([&] {
          more.insert(more.end(), {"--listen", bus});
          return more;
        }()) {
    if (process.read_line().empty()) throw std::runtime_error("no board: " + process.read_errors());
  }

  TemporaryDirectory folder;
  const std::string bus = "unix:" + folder.file("bus");
  BoardProcess process;
};

TEST(LocalBoards, AreListedWithoutACommandWithAndWithoutAManagementPlane) {
  const OwnRegistry registry;
  const TemporaryDirectory folder;
  const std::string management = "unix:" + folder.file("mgmt");
  const Listening managed({"--management", management, "--boards", "2", "--set", "bus.model=agp2x"});
  const Listening plain;
  const Board owner = Board::open(plain.bus);
  const Board alone = Board::open("emu:?fidelity=cycle");
  const Finished run = run_program("gicube-smi", {});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, ContainsRegex("PID +BOARD +NAME +OPEN WITH +FIDELITY +BUS +SIMULATED +CONFIGURATION"));
  EXPECT_THAT(run.out, ContainsRegex(" 0 +GI-Cube .emulated. +" + managed.bus + " +functional +agp2x .*" + management +
                                     " +free"));
  EXPECT_THAT(run.out, ContainsRegex(" 1 +GI-Cube .emulated. +" + managed.bus + ".1 +functional"));
  EXPECT_THAT(run.out, ContainsRegex(plain.bus + " +functional +pci33 .* none +in use by process [0-9]+ since "));
  EXPECT_THAT(run.out, ContainsRegex("private +cycle +pci33 .* none +in use by "));

  const json list = json::parse(run_program("gicube-smi", {"--json"}).out);
  EXPECT_EQ(list["registry"], registry.folder());
  ASSERT_EQ(list["processes"].size(), 3u);
  std::size_t boards = 0;
  for (const json& process : list["processes"]) {
    EXPECT_TRUE(process["answers"]);
    EXPECT_EQ(process["counters"].size(), process["boards"].size());
    boards += process["boards"].size();
  }
  EXPECT_EQ(boards, 4u);
}

TEST(Enumerate, FindsTheBoardsThatListenAndTheyCanBeOpened) {
  const OwnRegistry registry;
  EXPECT_THAT(enumerate(), IsEmpty());
  const Listening two({"--boards", "2"}), plain;
  Listening killed;
  const Board owner = Board::open(plain.bus), alone = Board::open("emu:");
  killed.process.send_signal(SIGKILL);
  killed.process.exit_code();
  const std::vector<FoundBoard> found = enumerate();
  gicube_found_list* list = nullptr;
  ASSERT_EQ(gicube_enumerate(&list), GICUBE_OK) << gicube_last_error();
  ASSERT_EQ(gicube_found_count(list), found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    gicube_found_board each;
    ASSERT_EQ(gicube_found_board_init(&each, sizeof each), GICUBE_OK);
    ASSERT_EQ(gicube_found_at(list, i, &each), GICUBE_OK);
    EXPECT_EQ(each.uri, found[i].uri);
    EXPECT_EQ(each.product, found[i].product);
    EXPECT_EQ(each.version, found[i].version);
    EXPECT_EQ(std::string(each.owner).empty(), found[i].owner.empty());
    EXPECT_EQ(each.in_use, found[i].in_use);
    EXPECT_EQ(each.process, found[i].process);
  }
  gicube_found_board none{};
  EXPECT_EQ(gicube_found_at(list, found.size(), &none), GICUBE_BAD_ARGUMENT);
  EXPECT_STREQ(gicube_last_error_field(), "index");
  gicube_found_free(list);

  std::vector<std::string> uris;
  for (const FoundBoard& each : found) {
    uris.push_back(each.uri);
    EXPECT_EQ(each.in_use, each.uri == plain.bus);
    EXPECT_EQ(each.owner.empty(), !each.in_use);
    EXPECT_EQ(each.product, "GI-Cube (emulated)");
    EXPECT_FALSE(each.version.empty());
    if (!each.in_use) {
      EXPECT_NO_THROW(Board::open(each.uri));
    }
  }
  EXPECT_THAT(uris, testing::UnorderedElementsAre(two.bus, two.bus + ".1", plain.bus));
}

// The log of the C interface, and of the C++ one below it.
TEST(Log, IsToldOfASessionThatWasLostAndResumed) {
  const OwnRegistry registry;
  const TemporaryDirectory folder;
  std::ofstream(folder.file("plan")) << "fault { direction: up message: 30 kind: link_loss }\n";
  const Listening faulty({"--faults", folder.file("plan")});
  std::vector<std::string> told;
  gicube_open_options options;
  ASSERT_EQ(gicube_open_options_init(&options, sizeof options), GICUBE_OK);
  options.reopen_attempts = 3;
  options.log = [](void* user, const char* sentence) {
    static_cast<std::vector<std::string>*>(user)->emplace_back(sentence);
  };
  options.log_user = &told;
  gicube_board* board = nullptr;
  ASSERT_EQ(gicube_open(faulty.bus.c_str(), &options, &board), GICUBE_OK) << gicube_last_error();
  for (int i = 0; i < 40; ++i) {
    gicube_counter_list* list = nullptr;
    ASSERT_EQ(gicube_get_counters(board, &list), GICUBE_OK) << gicube_last_error();
    gicube_counters_free(list);
  }
  gicube_close(board);
  EXPECT_THAT(told, ElementsAre(HasSubstr("the session continues")));
}

// A listener that is no board may say anything: it is left out, and nobody waits for ever.
TEST(Enumerate, LeavesOutWhatAnswersSomethingElse) {
  const OwnRegistry registry;
  const Listening plain;
  const std::string good("\x1a\x08\x12\x02GI\x22\x02x:", 10);  // a board that listens nowhere
  for (const std::string& answer : {std::string("\xff\xff\xff"), std::string("\x1a\x7f"), std::string("\x0b"), good}) {
    const std::string path = registry.folder() + "/1";
    boost::asio::io_context io;
    boost::asio::local::stream_protocol::acceptor acceptor(io, path);
    std::jthread answers([&] {
      boost::system::error_code ignored;
      auto socket = acceptor.accept(ignored);
      if (!ignored) boost::asio::write(socket, boost::asio::buffer(answer), ignored);
    });
    const auto found = enumerate();
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].uri, plain.bus);
    fs::remove(path);
  }
}

TEST(Enumerate, AProcessThatHangsHidesNoOther) {
  const OwnRegistry registry;
  const Listening plain;
  boost::asio::io_context io;
  const boost::asio::local::stream_protocol::acceptor never_answers(io, registry.folder() + "/1");
  const auto found = enumerate();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].uri, plain.bus);
}

TEST(LocalBoards, TheOnlyManagementPlaneNeedNotBeNamed) {
  const OwnRegistry registry;
  const TemporaryDirectory folder;
  const auto list = [] { return run_program("gicube-smi", {"list"}, {"GICUBE_MANAGEMENT="}); };
  const Listening plain;
  const Finished none = list();
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("--management: expected a management plane, got none"));

  const std::string first = "unix:" + folder.file("first"), second = "unix:" + folder.file("second");
  const Listening managed({"--management", first});
  const Finished one = list();
  EXPECT_EQ(one.code, 0) << one.err;
  EXPECT_THAT(one.out, HasSubstr(managed.bus));

  const Listening other({"--management", second});
  const Finished two = list();
  EXPECT_EQ(two.code, 2);
  EXPECT_THAT(two.err, AllOf(HasSubstr("--management: expected one of "), HasSubstr(first), HasSubstr(second)));
}

TEST(LocalBoards, AreNoneBeforeOneRuns) {
  const OwnRegistry registry;
  const Finished run = run_program("gicube-smi", {});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "no board of this user runs on this machine (" + registry.folder() + ")\n");
  EXPECT_EQ(json::parse(run_program("gicube-smi", {"--json"}).out)["processes"].size(), 0u);
}

TEST(LocalBoards, AKilledProcessIsNotListedAndItsSocketRemoved) {
  const OwnRegistry registry;
  Listening killed;
  const Listening living;
  killed.process.send_signal(SIGKILL);
  EXPECT_EQ(killed.process.exit_code(), 128 + SIGKILL);
  const auto sockets = [&] {
    return std::distance(fs::directory_iterator(registry.folder()), fs::directory_iterator());
  };
  EXPECT_EQ(sockets(), 2);
  EXPECT_THAT(run_program("gicube-smi", {}).out, AllOf(HasSubstr(living.bus), Not(HasSubstr(killed.bus))));
  EXPECT_EQ(sockets(), 1);
}

TEST(LocalBoards, ANewBoardRemovesTheSocketOfAKilledOne) {
  const OwnRegistry registry;
  {
    const Listening killed;  // by its destructor
  }
  EXPECT_FALSE(fs::is_empty(registry.folder()));
  Listening ended;
  ended.process.send_signal(SIGTERM);
  EXPECT_EQ(ended.process.exit_code(), 0);
  EXPECT_TRUE(fs::is_empty(registry.folder()));
}

TEST(LocalBoards, AProcessThatEndsTakesItsSocketWithIt) {
  const OwnRegistry registry;
  Listening ended;
  ended.process.send_signal(SIGTERM);
  EXPECT_EQ(ended.process.exit_code(), 0);
  EXPECT_TRUE(fs::is_empty(registry.folder()));
}

TEST(LocalBoards, AStoppedProcessDoesNotAnswerButStaysListed) {
  const OwnRegistry registry;
  Listening stopped;
  stopped.process.send_signal(SIGSTOP);
  const Finished run = run_program("gicube-smi", {});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, ContainsRegex("^.*\n *[0-9]+ +does not answer\n$"));
  stopped.process.send_signal(SIGCONT);
  EXPECT_THAT(run_program("gicube-smi", {}).out, HasSubstr(stopped.bus));
}

TEST(LocalBoards, ARegistryThatOthersMayEnterIsNotTrusted) {
  const OwnRegistry registry;
  fs::create_directory(registry.folder());
  fs::permissions(registry.folder(), fs::perms::all);
  Listening board;
  Board::open(board.bus).counters();  // serves all the same
  const Finished run = run_program("gicube-smi", {});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr(registry.folder() + ": expected a folder of user"));
  EXPECT_THAT(run.err, HasSubstr("mode 700, got mode 777"));
  board.process.send_signal(SIGTERM);
  EXPECT_THAT(board.process.read_errors(), HasSubstr("gicube-smi cannot find this process"));
}

TEST(Options, StandBeforeTheCommandOrBehindIt) {
  const OwnRegistry registry;
  const TemporaryDirectory folder;
  const std::string management = "unix:" + folder.file("mgmt");
  Listening board({"--management", management, "--boards", "2"});
  while (board.process.read_line().find("management ready") == std::string::npos) {
  }
  const std::string expected = run_program("gicube-smi", {"info", "-m", management, "-b", "1", "--json"}).out;
  EXPECT_EQ(json::parse(expected)["board"], 1);
  const std::vector<std::vector<std::string>> orders{{"-m", management, "-b", "1", "--json", "info"},
                                                     {"--json", "-b1", "info", "--management=" + management},
                                                     {"--management", management, "info", "--board=1", "--json"}};
  for (const std::vector<std::string>& words : orders) EXPECT_EQ(run_program("gicube-smi", words).out, expected);
  EXPECT_THAT(run_program("gicube-smi", {"--json", "faults", "-m", management, "show"}).out,
              HasSubstr("\"plan_text\""));
  const Finished top = run_program("gicube-smi", {"-i", "20ms", "-m", management, "-n", "2", "--json", "top"});
  EXPECT_EQ(std::ranges::count(top.out, '\n'), 2) << top.err;
}

TEST(Options, ThatTheCommandDoesNotKnowAreRefusedOnBothSides) {
  const Finished before = run_program("gicube-smi", {"-n", "2", "validate"});
  EXPECT_EQ(before.code, 2);
  EXPECT_THAT(before.err, HasSubstr("-n"));
  EXPECT_THAT(run_program("gicube-smi", {"--json", "export", "--listen", "nowhere"}).err, HasSubstr("--json"));
  const Finished behind = run_program("gicube-smi", {"validate", "-n", "2"});
  EXPECT_EQ(behind.code, 2);
  EXPECT_THAT(behind.err, HasSubstr("-n"));
}

TEST(Options, TimesHaveUnits) {
  for (const char* good : {"10ms", "60s", "1min", "0.5s", "1e3ms"}) {
    const Finished run = run_program("gicube-smi", {"top", "-m", "unix:/no/such/socket", "-i", good});
    EXPECT_EQ(run.code, 1) << good << run.err;  // nobody answers there
  }
  for (const char* bad : {"20", "ms", "5 s", "1h", "-1s", "nans", ""}) {
    const Finished run = run_program("gicube-smi", {"top", "-m", "unix:/no/such/socket", "-i", bad});
    EXPECT_EQ(run.code, 2) << bad;
    EXPECT_THAT(run.err, AllOf(HasSubstr("--interval: expected a time with its unit (ms, s, min), as 500ms, got"),
                               HasSubstr(bad)));
  }
  for (const char* outside : {"9ms", "61s", "2min"}) {
    EXPECT_THAT(run_program("gicube-smi", {"top", "-m", "unix:/no/such/socket", "-i", outside}).err,
                HasSubstr("--interval: expected 10ms to 60s, got " + std::string(outside)));
  }
}

}  // namespace
}  // namespace gicube::tools_test
