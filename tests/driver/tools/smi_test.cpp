// gicube-smi as its users run it.
#include <sys/stat.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "board_process.h"
#include "gicube/board.h"
#include "run_program.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::tools_test {
namespace {

using nlohmann::json;
using reference::TemporaryDirectory;
using system_test::BoardProcess;
using testing::Not;

// A board process with its management plane.
struct Boards {
  explicit Boards(const std::vector<std::string>& more = {})
      : process([&] {
          std::vector<std::string> arguments{"--listen", bus, "--management", management, "--quiet"};
          arguments.insert(arguments.end(), more.begin(), more.end());
          return arguments;
        }()) {
    for (std::string line = process.read_line(); !line.empty(); line = process.read_line()) {
      if (line.find("management ready") != std::string::npos) return;
    }
    throw std::runtime_error("no board: " + process.read_errors());
  }

  Finished smi(const std::vector<std::string>& words) const {
    return run_program("gicube-smi", words, {"GICUBE_MANAGEMENT=" + management});
  }

  TemporaryDirectory folder;
  const std::string bus = "unix:" + folder.file("bus"), management = "unix:" + folder.file("mgmt");
  BoardProcess process;
};

TEST(Smi, ListsTheBoardsOfAProcess) {
  const Boards boards({"--boards", "2", "--set", "bus.model=agp2x"});
  const Finished run = boards.smi({"list"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, ContainsRegex("BOARD +OPEN WITH +STATE +FIDELITY +BUS"));
  EXPECT_THAT(run.out, ContainsRegex(" 0 +" + boards.bus + " +free +functional +agp2x +4 +256\\^3"));
  EXPECT_THAT(run.out, ContainsRegex(" 1 +" + boards.bus + ".1 +free"));
  const json list = json::parse(boards.smi({"list", "--json"}).out);
  ASSERT_EQ(list["boards"].size(), 2u);
  EXPECT_EQ(list["boards"][1]["bus_endpoint"], boards.bus + ".1");
}

TEST(Smi, InfoShowsWhatIsNotTheDefault) {
  const Boards boards({"--set", "asic.processors=8"});
  const Finished run = boards.smi({"info"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, ContainsRegex("asic.processors +8 +\\(default 4\\)"));
  EXPECT_THAT(run.out, Not(ContainsRegex("block_voxels +32 +\\(default")));
  EXPECT_THAT(run.out, HasSubstr("henyey_greenstein"));
  EXPECT_EQ(json::parse(boards.smi({"info", "--json"}).out)["config"]["asic"]["processors"], 8);
}

TEST(Smi, AnUnknownBoardIsAnError) {
  const Boards boards;
  const Finished run = boards.smi({"info", "-b", "3"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("board: expected 0 to 0, got 3"));
}

TEST(Smi, SaysWhenNobodyAnswers) {
  const Finished run = run_program("gicube-smi", {"list", "-m", "unix:/no/such/socket"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, AllOf(HasSubstr("nobody answers on unix:/no/such/socket"), HasSubstr("--management")));
}

TEST(Smi, WrongUsageEndsWithTwo) {
  EXPECT_EQ(run_program("gicube-smi", {"list", "-m", "/tmp/x"}).code, 2);
  EXPECT_EQ(run_program("gicube-smi", {"top", "-m", "unix:/x", "-i", "3ms"}).code, 2);
  EXPECT_EQ(run_program("gicube-smi", {"--help"}).code, 0);
  EXPECT_THAT(run_program("gicube-smi", {"--version"}).out, HasSubstr("gicube-smi 0."));
}

TEST(Smi, TopShowsWhatABoardDoes) {
  const Boards boards;
  Board board = Board::open(boards.bus);
  const std::vector<std::byte> samples(64 * 64 * 64, std::byte{9});
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {64, 64, 64}});
  board.counters();
  const Finished run = boards.smi({"top", "--once"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, ContainsRegex("board 0: [0-9.]+ (us|ms) simulated"));
  EXPECT_THAT(run.out, ContainsRegex("bus down +[0-9.]+% +[0-9.]+ MB/s +[0-9.]+ MB"));
  EXPECT_THAT(run.out, ContainsRegex("bus.down.bytes +[0-9]{7} "));
  EXPECT_THAT(run.out, Not(HasSubstr("\033")));
}

// script runs it on a terminal of its own. Once the board's process has gone, so does gicube-smi.
TEST(Smi, TopSendsNoCodesToATerminalThatHasNone) {
  for (const char* terminal : {"xterm", "dumb"}) {
    Boards boards;
    const std::string log = boards.folder.file("log");
    const std::string top = GICUBE_BIN_DIR "/gicube-smi top -i 20ms -m " + boards.management;
    const std::string command = "TERM=" + std::string(terminal) + " timeout 3 script -qfec '" + top + "' " + log;
    [[maybe_unused]] const int code = std::system((command + " >/dev/null 2>&1 </dev/null").c_str());
    const std::string shown = text_of(log);
    EXPECT_THAT(shown, HasSubstr("bus down")) << terminal;
    EXPECT_EQ(shown.find("\033[H") != std::string::npos, terminal == std::string("xterm")) << shown;
  }
}

TEST(Smi, TopWritesOneObjectALine) {
  const Boards boards;
  const Finished run = boards.smi({"top", "--json", "-n", "3", "-i", "20ms"});
  EXPECT_EQ(run.code, 0) << run.err;
  std::istringstream lines(run.out);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_TRUE(json::parse(line)["counters"].contains("bus.down.bytes"));
  }
  EXPECT_EQ(count, 3);
}

TEST(Smi, ResetEndsTheSessionThatOwnsTheBoard) {
  const Boards boards;
  Board board = Board::open(boards.bus);
  EXPECT_THAT(boards.smi({"list"}).out, HasSubstr("in use"));
  const Finished run = boards.smi({"reset"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("board 0 is reset and free"));
  EXPECT_THROW(board.counters(), DeviceLost);
}

TEST(Smi, SetsShowsAndClearsAFaultPlan) {
  const Boards boards;
  const std::string plan = boards.folder.file("plan");
  std::ofstream(plan) << "fault { direction: down message: 5 kind: delay delay_ms: 1 }\n";
  EXPECT_THAT(boards.smi({"faults", "show"}).out, HasSubstr("no fault plan"));
  const Finished set = boards.smi({"faults", "set", plan});
  EXPECT_EQ(set.code, 0) << set.err;
  EXPECT_THAT(set.out, HasSubstr("kind: delay"));
  Board::open(boards.bus).counters();
  EXPECT_THAT(boards.smi({"faults", "show"}).out, HasSubstr("1 faults so far"));
  EXPECT_THAT(boards.smi({"faults", "log"}).out,
              HasSubstr("fault { direction: down message: 5 kind: delay delay_ms: 1 }"));
  EXPECT_THAT(boards.smi({"faults", "clear"}).out, HasSubstr("no fault plan"));
}

TEST(Smi, NamesWhatIsWrongInAFaultPlan) {
  const Boards boards;
  const std::string plan = boards.folder.file("plan");
  std::ofstream(plan) << "fault { direction: down message: 5 kind: explode }\n";
  const Finished run = boards.smi({"faults", "set", plan});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("kind"));
  EXPECT_EQ(boards.smi({"faults", "set", "/no/such/plan"}).code, 2);
}

TEST(Smi, TracesTheSessionsBetweenStartAndStop) {
  const TemporaryDirectory traces;
  const Boards boards({"--trace-dir", traces.path()});
  const std::string file = traces.file("trace.json");
  EXPECT_THAT(boards.smi({"trace", "show"}).out, HasSubstr("writes no trace"));
  const Finished start = boards.smi({"trace", "start", "trace.json"});
  EXPECT_EQ(start.code, 0) << start.err;
  Board::open(boards.bus).counters();
  EXPECT_THAT(boards.smi({"trace", "show"}).out, HasSubstr(file));
  Finished stop = boards.smi({"trace", "stop"});
  for (int i = 0; i < 50 && stop.code != 0; ++i) stop = boards.smi({"trace", "stop"});  // while the session ends
  EXPECT_THAT(stop.out, HasSubstr(file + " is complete"));
  EXPECT_TRUE(json::accept(text_of(file))) << text_of(file);
  EXPECT_THAT(text_of(file), HasSubstr("access register"));
}

TEST(Smi, ATraceOverwritesNothingAndNeedsAFreeBoard) {
  const TemporaryDirectory traces;
  const Boards boards({"--trace-dir", traces.path()});
  const std::string file = traces.file("there");
  std::ofstream(file) << "mine";
  EXPECT_THAT(boards.smi({"trace", "start", file}).err, HasSubstr("expected the name of a new file"));
  EXPECT_EQ(text_of(file), "mine");
  EXPECT_THAT(boards.smi({"trace", "start", boards.folder.file("elsewhere")}).err,
              HasSubstr("expected the name of a new file in " + traces.path() + ", got"));
  const Board board = Board::open(boards.bus);
  EXPECT_THAT(boards.smi({"trace", "start", "new"}).err, HasSubstr("has an owner"));
}

// What stands behind "ready on " in the next line.
std::string next_endpoint(BoardProcess& process) {
  const std::string line = process.read_line();
  return line.substr(line.find("ready on ") + 9);
}

TEST(Smi, OverTcpTheUserOfTheBoardNeedsNothingAndOthersNeedAToken) {
  const TemporaryDirectory folder;
  const std::string tokens = folder.file("tokens"), reader = folder.file("reader");
  std::ofstream(tokens) << "read token_of_who_may_read\nuse token_of_who_may_use\n";
  std::ofstream(reader) << "token_of_who_may_read\n";
  for (const std::string& file : {tokens, reader}) ::chmod(file.c_str(), 0600);
  BoardProcess process({"--listen", "tcp:127.0.0.1:0", "--management", "tcp:127.0.0.1:0", "--token-file", tokens});
  const std::string bus = next_endpoint(process), management = next_endpoint(process);
  const std::string stranger = "XDG_RUNTIME_DIR=" + folder.path();
  EXPECT_EQ(run_program("gicube-smi", {"list", "-m", management}).code, 0);
  EXPECT_EQ(run_program("gicube-smi", {"reset", "-m", management}).code, 0);
  EXPECT_EQ(run_program("gicube-smi", {"doctor", bus}).code, 0);
  const Finished refused = run_program("gicube-smi", {"list", "-m", management}, {stranger});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("asks for a token: --token-file"));
  EXPECT_EQ(run_program("gicube-smi", {"list", "-m", management, "--token-file", reader}, {stranger}).code, 0);
  EXPECT_THAT(run_program("gicube-smi", {"reset", "-m", management, "--token-file", reader}, {stranger}).err,
              HasSubstr("expected a token with the right to control, got one with the right to read"));
  EXPECT_THAT(run_program("gicube-smi", {"doctor", bus}, {stranger}).out, HasSubstr("the board refuses access"));
  EXPECT_THAT(run_program("gicube-smi", {"doctor", bus}, {stranger, "GICUBE_TOKEN_FILE=" + reader}).out,
              HasSubstr("expected a token with the right to use"));
  std::ofstream(reader) << "token_of_who_may_use\n";
  EXPECT_EQ(run_program("gicube-smi", {"doctor", bus}, {stranger, "GICUBE_TOKEN_FILE=" + reader}).code, 0);
  EXPECT_THAT(run_program("gicube-smi", {"doctor", bus}, {stranger, "GICUBE_TOKEN_FILE=/nowhere"}).out,
              HasSubstr("GICUBE_TOKEN_FILE: expected a file with a token"));
}

TEST(Smi, SendsATokenOverANetworkByTlsOnly) {
  const Finished run = run_program("gicube-smi", {"list", "-m", "tcp:192.0.2.1:4711", "--token-file", "t"});
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("--ca: expected the board's certificate beside --token-file"));
}

TEST(Smi, ValidatesAGoodBoard) {
  const Finished run = run_program("gicube-smi", {"validate"});
  EXPECT_EQ(run.code, 0) << run.out;
  for (const char* test : {"open", "clock", "memory", "checksums", "picture", "rays", "bandwidth", "refusals"}) {
    EXPECT_THAT(run.out, ContainsRegex(std::string(test) + " +pass"));
  }
  EXPECT_THAT(run.out, HasSubstr("8 of 8 tests passed"));
}

TEST(Smi, APictureIsTheSameOnEveryMachine) {
  const Finished run = run_program(
      "gicube-smi",
      {"validate", "--json",
       "emu:?fidelity=cycle&bus=agp4x&set=asic.block_voxels=16&set=asic.processors=2&set=asic.datapath=wide"});
  EXPECT_EQ(run.code, 0) << run.out;
  const json result = json::parse(run.out);
  EXPECT_TRUE(result["passed"]);
  EXPECT_EQ(result["tests"].size(), 8u);
}

TEST(Smi, ABoardThatForgetsIsNotValid) {
  const TemporaryDirectory folder;
  const std::string plan = folder.file("plan");
  std::ofstream(plan) << "random { kinds: memory_silent mean_messages: 3 seed: 1 }\n";
  const Finished run = run_program("gicube-smi", {"validate", "emu:?faults=" + plan});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, ContainsRegex("(memory|checksums|picture) +FAIL"));
}

TEST(Smi, ValidateSkipsWhatNeedsABoardThatIsNotThere) {
  const Finished run = run_program("gicube-smi", {"validate", "unix:/no/such/socket"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, AllOf(ContainsRegex("open +FAIL"), ContainsRegex("rays +skipped"), HasSubstr("0 of 8")));
}

}  // namespace
}  // namespace gicube::tools_test
