#include "server/options.h"

#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

using testing::Contains;

CommandLine parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "gicube-board");
  return parse_command_line(static_cast<int>(arguments.size()), arguments.data());
}

TEST(CommandLine, TakesAListeningBoardWithOverrides) {
  const CommandLine line = parse({"--listen", "unix:/tmp/b", "--boards", "3", "--set", "asic.processors=8", "--set",
                                  "bus.model=agp2x", "--quiet"});
  EXPECT_THAT(line.errors, IsEmpty());
  EXPECT_EQ(to_string(line.options.listen), "unix:/tmp/b");
  EXPECT_EQ(line.options.boards, 3u);
  EXPECT_EQ(line.options.config.asic().processors(), 8u);
  EXPECT_EQ(line.options.config.bus().model(), v1::agp2x);
  EXPECT_TRUE(line.options.config.has_threads());
  EXPECT_TRUE(line.options.quiet);
  EXPECT_FALSE(line.options.management);
}

TEST(CommandLine, SaysHowLongASessionMayBeResumed) {
  EXPECT_EQ(parse({"--listen", "unix:/tmp/b"}).options.bus.resume_limit, std::chrono::seconds(10));
  EXPECT_EQ(parse({"--listen", "unix:/tmp/b", "--resume-seconds", "0"}).options.bus.resume_limit.count(), 0);
  EXPECT_THAT(parse({"--listen", "unix:/tmp/b", "--resume-seconds", "86401"}).errors,
              Contains(HasSubstr("--resume-seconds")));
}

TEST(CommandLine, PutsTheProcessIntoABoxUnlessAskedNotTo) {
  EXPECT_TRUE(parse({"--listen", "unix:/tmp/b"}).options.is_boxed);
  EXPECT_FALSE(parse({"--listen", "unix:/tmp/b", "--box", "off"}).options.is_boxed);
  EXPECT_THAT(parse({"--listen", "unix:/tmp/b", "--box", "on"}).errors,
              Contains(HasSubstr("--box: on not in {auto,off}")));
}

TEST(CommandLine, LimitsMemoryAndResultsInMebibytes) {
  const Options none = parse({"--listen", "unix:/tmp/b"}).options;
  EXPECT_EQ(none.max_memory_bytes, kUnlimitedMemory);
  EXPECT_EQ(none.bus.max_held_bytes, std::uint64_t{1} << 30);
  const Options some = parse({"--listen", "unix:/tmp/b", "--max-memory", "4096", "--max-results", "2"}).options;
  EXPECT_EQ(some.max_memory_bytes, std::uint64_t{4} << 30);
  EXPECT_EQ(some.bus.max_held_bytes, std::uint64_t{2} << 20);
  EXPECT_THAT(parse({"--listen", "unix:/tmp/b", "--max-results", "0"}).errors, Contains(HasSubstr("--max-results")));
  EXPECT_THAT(parse({"--listen", "unix:/tmp/b", "--max-memory", "-1"}).errors, Contains(HasSubstr("--max-memory")));
}

TEST(CommandLine, LimitsConnectionsAndHowLongTheyWait) {
  const Options usual = parse({"--listen", "unix:/tmp/b"}).options;
  EXPECT_EQ(usual.bus.max_unowned, 32u);
  EXPECT_EQ(usual.bus.max_unowned_of_peer, 16u);
  EXPECT_EQ(usual.bus.max_wait, std::chrono::hours(1));
  const Options own =
      parse({"--listen", "unix:/tmp/b", "--max-connections", "9", "--max-connections-of-peer", "3", "--max-wait", "2"})
          .options;
  EXPECT_EQ(own.bus.max_unowned, 9u);
  EXPECT_EQ(own.bus.max_unowned_of_peer, 3u);
  EXPECT_EQ(own.bus.max_wait, std::chrono::seconds(2));
  for (const char* flag : {"--max-connections", "--max-connections-of-peer", "--max-wait"}) {
    EXPECT_THAT(parse({"--listen", "unix:/tmp/b", flag, "0"}).errors, Contains(HasSubstr(flag)));
  }
}

TEST(CommandLine, LimitsCommandsAndNamesTheAuditLog) {
  const Options usual = parse({"--listen", "unix:/tmp/b"}).options;
  EXPECT_EQ(usual.bus.max_command_time.count(), 0);
  EXPECT_EQ(usual.audit_log_file, "");
  const Options own = parse({"--listen", "unix:/tmp/b", "--max-command-time", "5", "--audit-log", "a"}).options;
  EXPECT_EQ(own.bus.max_command_time, std::chrono::seconds(5));
  EXPECT_EQ(own.audit_log_file, "a");
}

TEST(CommandLine, AFileThatNeverEndsIsReadNoFurtherThanATextMayBe) {
  for (const char* flag : {"--config", "--faults"}) {
    EXPECT_THAT(parse({"--listen", "fd:3", flag, "/dev/zero"}).errors,
                ElementsAre(HasSubstr("expected at most 1048576 bytes of text, got 1048577")));
  }
}

TEST(CommandLine, ThePaceIsNoPartOfTheConfigurationsHash) {
  const auto paced = parse({"--listen", "unix:/tmp/b", "--set", "pace=realtime"}).options.config;
  EXPECT_EQ(paced.pace(), v1::realtime);
  EXPECT_EQ(config_hash(paced), config_hash(parse({"--listen", "unix:/tmp/b"}).options.config));
  EXPECT_THAT(parse({"--listen", "unix:/tmp/b", "--set", "pace=PACE_UNSPECIFIED"}).errors, Contains(HasSubstr("pace")));
}

TEST(CommandLine, ReportsAllFaultsAtOnce) {
  const reference::TemporaryDirectory folder;
  const std::string file = folder.file("board.textproto");
  std::ofstream(file) << "asic { processors: 99\n colour: 3 }\n";
  const CommandLine line = parse({"--listen", "tcp:0.0.0.0:1", "--boards", "65", "--private", "--config", file.c_str(),
                                  "--set", "dsp.clock=3", "--management", "tcp:0.0.0.0:2"});
  EXPECT_THAT(line.errors, SizeIs(7));
  EXPECT_THAT(line.errors, Contains(HasSubstr("--boards: expected 1 to 64, got 65")));
  EXPECT_THAT(line.errors,
              Contains(AllOf(HasSubstr("--listen: expected a loopback address"), HasSubstr("--tls-cert"))));
  EXPECT_THAT(line.errors, Contains(HasSubstr("--private: expected --listen fd:N")));
  EXPECT_THAT(line.errors, Contains(AllOf(HasSubstr(file), HasSubstr("line 2: asic.colour: expected one of"))));
  EXPECT_THAT(line.errors, Contains(AllOf(HasSubstr(file), HasSubstr("line 1: asic.processors: expected 1 to 16"))));
  EXPECT_THAT(line.errors, Contains(HasSubstr("--set dsp.clock=3: dsp.clock: expected one of clock_khz")));
  EXPECT_THAT(line.errors,
              Contains(HasSubstr("or TLS and a token by --tls-cert, --tls-key, --token-file, got tcp:0.0.0.0:2")));
}

TEST(CommandLine, AnOverrideWinsOverTheFile) {
  const reference::TemporaryDirectory folder;
  const std::string file = folder.file("board.textproto");
  std::ofstream(file) << "asic { processors: 99 queue_rays: 7 }\n";
  const CommandLine line = parse({"--print-config", "--config", file.c_str(), "--set", "asic.processors=2"});
  EXPECT_THAT(line.errors, IsEmpty());
  EXPECT_EQ(line.options.config.asic().processors(), 2u);
  EXPECT_EQ(line.options.config.asic().queue_rays(), 7u);
}

TEST(CommandLine, RemoteManagementNeedsWhatIsMissingByName) {
  EXPECT_THAT(parse({"--listen", "fd:3", "--management", "tcp:0.0.0.0:2", "--tls-key", "k", "--tls-cert", "c"}).errors,
              ElementsAre(AllOf(HasSubstr("TLS and a token by --token-file"), testing::Not(HasSubstr("--tls")))));
  EXPECT_THAT(parse({"--listen", "fd:3", "--tls-key", "k"}).errors,
              ElementsAre("--tls-key: expected --tls-cert beside it, got none"));
  EXPECT_THAT(parse({"--listen", "fd:3", "--tls-cert", "c"}).errors,
              ElementsAre("--tls-cert: expected --tls-key beside it, got none"));
  EXPECT_THAT(parse({"--listen", "tcp:127.0.0.1:1", "--management", "tcp:127.0.0.1:2", "--token-file", "t"}).errors,
              IsEmpty());
  EXPECT_THAT(parse({"--listen", "fd:3", "--management", "fd:4"}).errors, ElementsAre(HasSubstr("unix:PATH")));
}

TEST(CommandLine, ABusThatOtherMachinesReachNeedsTlsAndAToken) {
  EXPECT_THAT(parse({"--listen", "tcp:0.0.0.0:1", "--tls-cert", "c", "--tls-key", "k", "--token-file", "t"}).errors,
              IsEmpty());
  for (const std::vector<const char*>& more :
       {std::vector<const char*>{}, {"--token-file", "t"}, {"--tls-cert", "c", "--tls-key", "k"}}) {
    std::vector<const char*> words{"--listen", "tcp:[::]:1"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_THAT(parse(words).errors,
                ElementsAre(HasSubstr("--listen: expected a loopback address or a unix socket, or TLS")));
  }
}

TEST(CommandLine, TakesScatteringRoutinesInTheirOrder) {
  const CommandLine line = parse({"--listen", "fd:3", "--bsdf", "b.so", "--bsdf", "a.so"});
  EXPECT_THAT(line.errors, IsEmpty());
  EXPECT_THAT(line.options.bsdf_files, ElementsAre("b.so", "a.so"));
}

TEST(CommandLine, NeedsSomethingToDo) {
  EXPECT_THAT(parse({}).errors, ElementsAre(HasSubstr("--listen")));
  EXPECT_THAT(parse({"--registers"}).errors, IsEmpty());
  EXPECT_THAT(parse({"--hardware-cost", "--set", "asic.processors=8"}).errors, IsEmpty());
  EXPECT_THAT(parse({"--listne", "fd:3"}).errors, SizeIs(1));
  EXPECT_THAT(parse({"--listen", "fd:3", "--boards", "2"}).errors, ElementsAre(HasSubstr("--boards")));
  EXPECT_THAT(parse({"--listen", "fd:3", "--config", "/nowhere"}).errors, ElementsAre(HasSubstr("/nowhere")));
}

TEST(CommandLine, TakesFilesToObserveTheBoardWith) {
  const CommandLine line = parse({"--listen", "fd:3", "--set", "fidelity=cycle", "--trace", "t.json", "--vcd", "w.vcd",
                                  "--vcd-window", "1000:2500"});
  EXPECT_THAT(line.errors, IsEmpty());
  EXPECT_EQ(line.options.observation.trace_file, "t.json");
  EXPECT_EQ(line.options.observation.vcd_file, "w.vcd");
  EXPECT_EQ(line.options.observation.vcd_window.begin, 1000u);
  EXPECT_EQ(line.options.observation.vcd_window.end, 2500u);
  EXPECT_THAT(parse({"--listen", "fd:3", "--trace", "t.json"}).errors, IsEmpty());  // bus and DSP at any level
}

TEST(CommandLine, TracesForManagementHaveAFolder) {
  const auto folder_of = [](std::vector<const char*> more) {
    more.insert(more.begin(), {"--listen", "fd:3"});
    return parse(more).options.management.value().trace_folder;
  };
  EXPECT_EQ(folder_of({"--management", "unix:/tmp/m"}), std::filesystem::current_path());
  EXPECT_EQ(folder_of({"--management", "unix:/tmp/m", "--trace-dir", "/tmp/../tmp"}), "/tmp");
  EXPECT_EQ(folder_of({"--management", "tcp:127.0.0.1:1"}), "");
  EXPECT_THAT(parse({"--listen", "fd:3", "--management", "unix:/tmp/m", "--trace-dir", "/nowhere"}).errors,
              ElementsAre("--trace-dir: expected a folder, got /nowhere"));
  EXPECT_THAT(parse({"--listen", "fd:3", "--trace-dir", "/tmp"}).errors, ElementsAre(HasSubstr("beside --trace-dir")));
}

TEST(CommandLine, AWaveformNeedsAWindowTheCycleLevelAndAFileOfItsOwn) {
  const auto faults = [](std::vector<const char*> more) {
    more.insert(more.begin(), {"--listen", "fd:3", "--set", "fidelity=cycle"});
    return parse(more).errors;
  };
  EXPECT_THAT(faults({"--vcd", "w"}), ElementsAre(HasSubstr("--vcd: expected --vcd-window BEGIN:END")));
  EXPECT_THAT(faults({"--vcd-window", "1:2"}), ElementsAre(HasSubstr("--vcd-window: expected --vcd FILE")));
  for (const char* window : {"5:5", "6:5", "5", "5:", ":5", "a:b", "-1:5", "1:5x", "1:99999999999999999999999"}) {
    EXPECT_THAT(faults({"--vcd", "w", "--vcd-window", window}),
                ElementsAre(AllOf(HasSubstr("BEGIN < END"), HasSubstr(window))));
  }
  EXPECT_THAT(faults({"--vcd", "w", "--vcd-window", "1:2", "--trace", "w"}),
              ElementsAre(HasSubstr("--vcd: expected another file than --trace, got w")));
  EXPECT_THAT(parse({"--listen", "fd:3", "--vcd", "w", "--vcd-window", "1:2"}).errors,
              ElementsAre(HasSubstr("--vcd: expected fidelity=cycle, got functional")));
}

TEST(CommandLine, TakesTheConfigurationOfACheckpointAndWhatDoesNotShapeItsState) {
  const reference::TemporaryDirectory folder;
  const std::string file = folder.file("warm"), damaged = folder.file("damaged");
  v1::BoardConfig config = parse({"--listen", "fd:3", "--set", "asic.processors=2"}).options.config;
  Board board(config, config_hash(config));
  save_checkpoint(board, std::filesystem::path(file));
  const auto with = [](const std::string& from, std::vector<const char*> more = {}) {
    more.insert(more.begin(), {"--listen", "fd:3", "--restore", from.c_str()});
    return parse(more);
  };
  EXPECT_THAT(with(file).errors, IsEmpty());
  EXPECT_EQ(with(file).options.config.asic().processors(), 2u);
  EXPECT_NE(with(file).options.checkpoint, nullptr);
  const CommandLine fork = with(file, {"--set", "bus.model=agp2x", "--set", "fidelity=cycle"});
  EXPECT_THAT(fork.errors, IsEmpty());
  EXPECT_EQ(fork.options.config.bus().model(), v1::agp2x);
  EXPECT_THAT(with(file, {"--set", "asic.processors=4"}).errors,
              ElementsAre("--restore: asic.processors: expected 2, as in the checkpoint, got 4"));
  std::filesystem::copy_file(file, damaged);
  std::filesystem::resize_file(damaged, 1000);
  EXPECT_THAT(with(damaged).errors,
              ElementsAre("--restore: " + damaged +
                          ": checkpoint: file: expected a checkpoint with its checksum, got 1000 other bytes"));
  EXPECT_THAT(with(folder.file("none")).errors, ElementsAre(HasSubstr("No such file")));
}

TEST(CommandLine, EventsNeedASelectionTheCycleLevelAndSomewhereToGo) {
  const auto faults = [](std::vector<const char*> more) {
    more.insert(more.begin(), {"--listen", "fd:3", "--set", "fidelity=cycle"});
    return parse(more).errors;
  };
  EXPECT_THAT(faults({"--events", "e", "--events-of", "pixel=1:2"}), IsEmpty());
  EXPECT_THAT(faults({"--observer", "o.so", "--events-of", "counters=100"}), IsEmpty());
  EXPECT_THAT(faults({"--events", "e"}), ElementsAre(HasSubstr("--events: expected --events-of ITEM,... beside it")));
  EXPECT_THAT(faults({"--observer", "o"}), ElementsAre(HasSubstr("--observer: expected --events-of ITEM,...")));
  EXPECT_THAT(faults({"--events-of", "rays=0:1"}), ElementsAre(HasSubstr("expected --events FILE or --observer FILE")));
  EXPECT_THAT(faults({"--events", "e", "--events-of", "rays=1:0"}),
              ElementsAre("--events-of: rays: expected BEGIN:END with BEGIN < END, got \"1:0\""));
  EXPECT_THAT(faults({"--events", "e", "--events-of", "rays=0:1", "--trace", "e"}),
              ElementsAre(HasSubstr("--events: expected another file")));
  EXPECT_THAT(parse({"--listen", "fd:3", "--events", "e", "--events-of", "rays=0:1"}).errors,
              ElementsAre(HasSubstr("--events: expected fidelity=cycle, got functional")));
}

TEST(CommandLine, ATracesWindowNeedsATrace) {
  const CommandLine line = parse({"--listen", "fd:3", "--trace", "t", "--trace-window", "5:9"});
  EXPECT_THAT(line.errors, IsEmpty());
  EXPECT_EQ(line.options.observation.trace_window.begin, 5u);
  EXPECT_EQ(line.options.observation.trace_window.end, 9u);
  EXPECT_THAT(parse({"--listen", "fd:3", "--trace-window", "5:9"}).errors,
              ElementsAre("--trace-window: expected --trace FILE beside it, got none"));
  EXPECT_THAT(parse({"--listen", "fd:3", "--trace", "t", "--trace-window", "9:5"}).errors,
              ElementsAre(HasSubstr("--trace-window: expected BEGIN:END in core cycles, with BEGIN < END, got 9:5")));
}

TEST(CommandLine, HelpAndVersionAreTexts) {
  EXPECT_THAT(parse({"--help"}).text.value_or(""), HasSubstr("--token-file"));
  EXPECT_THAT(parse({"--version"}).text.value_or(""), StartsWith("gicube-board "));
}

TEST(CommandLine, ReadsAFaultPlanAndNamesEveryFaultInIt) {
  const reference::TemporaryDirectory folder;
  const std::string good = folder.file("good"), bad = folder.file("bad");
  std::ofstream(good) << "fault { direction: down message: 3 kind: drop }";
  std::ofstream(bad) << "fault { direction: down message: 3 kind: hiccup }\nfoult {}\n";
  const auto with = [](const std::string& file) {
    return parse({"--listen", "unix:/tmp/b", "--faults", file.c_str(), "--fault-log", "faults.log"});
  };
  const CommandLine line = with(good);
  EXPECT_THAT(line.errors, IsEmpty());
  EXPECT_EQ(line.options.fault_plan, "fault { direction: down message: 3 kind: drop }");
  EXPECT_EQ(line.options.fault_log_file, "faults.log");
  EXPECT_THAT(with(bad).errors, ElementsAre(HasSubstr(bad + ": line 1: fault[0].kind: expected one of drop"),
                                            HasSubstr(bad + ": line 2: foult: expected one of fault, random")));
  EXPECT_THAT(with(folder.file("none")).errors, ElementsAre(HasSubstr("--faults: expected a readable file")));
}

}  // namespace
}  // namespace gicube::emu
