// A board that is stopped, looked into and told to go on, by another thread than the one that works on its command.
#include "observe/debugger.h"

#include "observe/observation.h"
#include "observed_scene.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr int kImage = 24;

// A board with a scene, whose pictures another thread renders.
class DebuggedBoard {
 public:
  explicit DebuggedBoard(const v1::BoardConfig& config, std::chrono::milliseconds max_pause = Debugger::kMaxPause)
      : debugger(max_pause), observation_({}, &debugger), board(config, &observation_) {
    board.load_volume(kObservedSize, observed_voxel);
    board.write_segmentation([](unsigned, unsigned density) { return observed_material(density); });
  }
  ~DebuggedBoard() {
    debugger.detach();
    if (renderer_.joinable()) renderer_.join();
  }

  void render() {
    if (renderer_.joinable()) renderer_.join();
    renderer_ = std::thread([this] { image = board.render(corner_view(kObservedSize, kImage)); });
  }
  void finish() { renderer_.join(); }

  std::string say(const std::string& line) {
    const Debugger::Answer answer = debugger.carry_out(line, [] { return false; });
    EXPECT_FALSE(answer.is_fault) << line << ": " << answer.text;
    is_paused = answer.is_paused;
    return answer.text;
  }
  std::string refused(const std::string& line) {
    const Debugger::Answer answer = debugger.carry_out(line, [] { return false; });
    EXPECT_TRUE(answer.is_fault) << line << ": " << answer.text;
    return answer.text;
  }

  Debugger debugger;
  std::vector<wire::Pixel> image;
  bool is_paused = false;

 private:
  Observation observation_;

 public:
  BareBoard board;

 private:
  std::thread renderer_;
};

std::vector<wire::Pixel> plain_image(const v1::BoardConfig& config, std::vector<wire::Counter>& counters,
                                     std::uint64_t& now_ps) {
  DebuggedBoard plain(config);
  plain.render();
  plain.finish();
  counters = plain.board.counters();
  now_ps = plain.board.now_ps;
  return plain.image;
}

TEST(Debugger, StopsAtEachKindOfBreakAndChangesNoBitNoCounterAndNoTime) {
  const v1::BoardConfig config = observed_config({"asic.queue_rays=3"});
  std::vector<wire::Counter> counters;
  std::uint64_t now_ps = 0;
  const std::vector<wire::Pixel> expected = plain_image(config, counters, now_ps);
  const std::vector<std::pair<std::string, std::string>> breaks{
      {"cycle 2500", "cycle 2500"},
      {"ray 300", "ray 300 was made"},
      {"pixel 12 12", "was made"},
      {"voxel 12 10 8", "reads voxel 12 10 8"},
      {"block 1 1 1", "passes through block 1 1 1"},

      {"overflow", "a queue overflowed"},
      {"conflict", "close another row"},
      {"counter processor.samples 700", "processor.samples is 70"},
      {"command", "command 1 begins, ticket "}};
  for (const auto& [text, why] : breaks) {
    DebuggedBoard board(config);
    ASSERT_TRUE(board.debugger.attach());
    board.say("break " + text);
    board.render();
    EXPECT_THAT(board.say("continue 20"), HasSubstr(why));
    EXPECT_TRUE(board.is_paused) << text;
    board.say("delete 1");
    board.debugger.detach();
    board.finish();
    EXPECT_EQ(board.image, expected) << text;
    EXPECT_EQ(board.board.now_ps, now_ps) << text;
    EXPECT_EQ(board.board.counters(), counters) << text;
  }
}

TEST(Debugger, StopsWhereAQueueHasSoManyRays) {
  DebuggedBoard board(observed_config());
  ASSERT_TRUE(board.debugger.attach());
  for (int queue = 0; queue < 9; ++queue) board.say("break queue 1 " + std::to_string(queue) + " 3");
  board.render();
  const std::string why = board.say("continue 20");
  EXPECT_THAT(why, ContainsRegex("queue [0-8] of processor 1 has 3 rays"));
  EXPECT_THAT(board.say("queue 1"), HasSubstr(": 3 rays"));
}

TEST(Debugger, StepsByCyclesSamplesRaysAndCommands) {
  DebuggedBoard board(observed_config());
  ASSERT_TRUE(board.debugger.attach());
  board.say("break cycle 3000");
  board.render();
  board.say("continue 20");
  EXPECT_THAT(board.say("step"), HasSubstr("cycle 3001,"));
  EXPECT_THAT(board.say("step cycle 9"), HasSubstr("cycle 3010,"));
  const auto count = [&](const std::string& name) {
    const std::string text = board.say("counters " + name);
    return std::stoull(text.substr(text.rfind(' ')));
  };
  const auto samples = count("processor.samples");
  board.say("step sample 5");
  EXPECT_GE(count("processor.samples"), samples + 5);
  EXPECT_LT(count("processor.samples"), samples + 8);  // three processors
  const auto taken = count("dsp.rays_taken");
  board.say("step ray");
  EXPECT_EQ(count("dsp.rays_taken"), taken + 1);
  EXPECT_THAT(board.say("continue 1"), HasSubstr("nothing has stopped"));
  board.say("break command");
  board.render();
  EXPECT_THAT(board.say("continue 20"), HasSubstr("command 2 begins"));
}

TEST(Debugger, ShowsARaysWordsAndHistoryAndSetsAWord) {
  DebuggedBoard board(observed_config());
  ASSERT_TRUE(board.debugger.attach());
  board.say("break voxel 12 10 2");
  board.render();
  const std::string why = board.say("continue 20");
  ASSERT_TRUE(board.is_paused) << why;
  const std::string ray = why.substr(why.find("ray ") + 4, why.find(" reads") - why.find("ray ") - 4);
  EXPECT_THAT(board.say("history " + ray), AllOf(HasSubstr("made"), HasSubstr("queued"), HasSubstr("sampled")));
  EXPECT_THAT(board.say("ray " + ray), HasSubstr("opacity"));
  EXPECT_THAT(board.say("set ray " + ray + " opacity 16777215"), HasSubstr("opacity 16777215"));
  EXPECT_THAT(board.refused("set ray " + ray + " opacity 16777216"), HasSubstr("expected 0 to 16777215"));
  EXPECT_THAT(board.refused("ray 100000"), HasSubstr("expected one that break or watch selected"));
  EXPECT_THAT(board.refused("history x:1"), HasSubstr("expected a ticket, got \"x\""));
}

TEST(Debugger, KnowsARayByItsTicketAndNumber) {
  DebuggedBoard board(observed_config());
  ASSERT_TRUE(board.debugger.attach());
  board.say("break command");
  board.render();
  const std::string first = board.say("continue 20");
  const unsigned long ticket = std::stoul(first.substr(first.find("ticket ") + 7));
  board.say("delete 1");
  board.say("break ray " + std::to_string(ticket + 1) + ":300");
  board.say("continue 0");
  board.finish();  // though this picture has a ray 300 too
  const std::string now = std::to_string(board.board.next_ticket());
  board.say("break ray " + now + ":300");
  board.render();
  EXPECT_THAT(board.say("continue 20"), HasSubstr("command 2, "));
  EXPECT_EQ(board.say("ray " + now + ":300"), board.say("ray 300"));
  EXPECT_THAT(board.refused("history " + std::to_string(ticket) + ":300"),
              HasSubstr("ticket: expected that of the latest command, " + now + ", got " + std::to_string(ticket)));
}

TEST(Debugger, StopsWhereTheDspGetsARayToScatter) {
  DebuggedBoard board(observed_config());
  wire::Material material;
  material.bsdf = wire::Bsdf::kTrap;
  material.scattering = wire::kScatteringOne;
  material.flags = wire::kScattersRenderingRays;
  material.routine = wire::kHostRoutine;
  const auto record = wire::encoded(material);
  board.board.write_memory(wire::kMaterials.base, record);
  board.board.write_register(wire::reg::kPipeline, wire::kPipelineScatter);
  board.board.write_register(wire::reg::kLifetime, 4);
  ASSERT_TRUE(board.debugger.attach());
  board.say("break trap");
  board.render();
  const std::string why = board.say("continue 20");
  EXPECT_THAT(why, HasSubstr("is trapped"));
  const std::string ray = why.substr(why.find("): ray ") + 7, why.find(" is trapped") - why.find("): ray ") - 7);
  EXPECT_THAT(board.say("history " + ray), HasSubstr("sampled"));
}

TEST(Debugger, ShowsASetOfACache) {
  DebuggedBoard board(observed_config({"cache.ways=2"}));
  ASSERT_TRUE(board.debugger.attach());
  board.say("break cycle 3000");
  board.render();
  board.say("continue 20");
  const std::string set = board.say("cache 0 set 1");
  EXPECT_THAT(set, ContainsRegex("way 0: (empty|block [0-9]+ [0-9]+ [0-9]+, tile [0-9]+)"));
  EXPECT_THAT(set, HasSubstr("way 1: "));
  EXPECT_THAT(board.refused("cache 0 set 100000"), HasSubstr("set: expected 0 to "));
}

TEST(Debugger, LetsABoardGoOnThatHasStoodForItsLimit) {
  DebuggedBoard board(observed_config(), std::chrono::milliseconds(100));
  ASSERT_TRUE(board.debugger.attach());
  board.say("break cycle 1000");
  const auto begin = std::chrono::steady_clock::now();
  board.render();
  board.finish();
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(100));
  EXPECT_THAT(board.say("where"), HasSubstr("the board is not paused"));
}

TEST(Debugger, DoesAJobAtTheEndOfTheCycleInWhichTheBoardStands) {
  DebuggedBoard board(observed_config());
  EXPECT_FALSE(board.debugger.offer([] {}));
  ASSERT_TRUE(board.debugger.attach());
  for (const std::string text : {"cycle 1000", "voxel 12 10 8"}) {
    board.say("break " + text);
    board.render();
    const std::string where = board.say("continue 20");
    std::atomic<int> done = 0;
    ASSERT_TRUE(board.debugger.offer([&] { ++done; }));
    while (done == 0) std::this_thread::yield();
    while (!board.debugger.is_paused()) std::this_thread::yield();
    EXPECT_EQ(board.say("where"), where);
    EXPECT_EQ(done, 1);
    board.say("delete " + std::string(text[0] == 'c' ? "1" : "2"));
    board.say("continue 0");
    board.finish();
  }
}

TEST(Debugger, SaysWhatEachPartWaitsFor) {
  DebuggedBoard board(observed_config());
  ASSERT_TRUE(board.debugger.attach());
  EXPECT_THAT(board.refused("break time 3us"), HasSubstr("time: expected a board that is paused in a command"));
  board.say("break cycle 1");
  board.render();
  board.say("continue 20");
  EXPECT_THAT(board.say("why"), AllOf(HasSubstr("processor 2 ("), HasSubstr("DSP: ")));
  EXPECT_THAT(board.say("parts"), HasSubstr("ring: "));
  EXPECT_THAT(board.say("link"), HasSubstr("rays on links"));
  EXPECT_THAT(board.say("bank 0 0 1"), HasSubstr("bank 1: "));
  EXPECT_THAT(board.say("cache 0 0 0 0"), HasSubstr("tiles in its cache"));
  const std::string at = board.say("where");  // "... cycle 1, N ps: ..."
  const std::size_t begin = at.find("1, ", at.find("cycle")) + 3;
  const std::uint64_t now_ps = std::stoull(at.substr(begin));
  board.say("break time " + std::to_string(now_ps + 500'000) + "ps");
  EXPECT_THAT(board.say("continue 20"), HasSubstr("cycle 51, " + std::to_string(now_ps + 500'000) + " ps"));
  EXPECT_THAT(board.refused("queue 3"), HasSubstr("processor: expected 0 to 2, got 3"));
  EXPECT_THAT(board.refused("jump"), HasSubstr("expected a command that help lists, got \"jump\""));
}

TEST(Debugger, LetsTheBoardGoOnWhenTheClientLeavesAndWhenItsSessionEnds) {
  DebuggedBoard board(observed_config());
  for (const bool leaves : {true, false}) {
    ASSERT_TRUE(board.debugger.attach());
    EXPECT_FALSE(board.debugger.attach());
    board.say("stop 0");
    board.render();
    while (board.say("where").find("command") == std::string::npos) std::this_thread::yield();
    leaves ? board.debugger.detach() : board.debugger.let_go();
    board.finish();
    if (!leaves) board.debugger.detach();
    board.render();
    board.finish();
  }
}

TEST(Debugger, SaysWhatALevelWithoutCyclesDoesNotHave) {
  v1::BoardConfig config = observed_config();
  config.set_fidelity(v1::functional);
  DebuggedBoard board(config);
  ASSERT_TRUE(board.debugger.attach());
  EXPECT_THAT(board.refused("break ray 3"), HasSubstr("this level has no cycles"));
  board.say("break counter pipeline.rays 1");
  board.say("break command");
  board.render();
  EXPECT_THAT(board.say("continue 20"), HasSubstr("command 1 begins"));
  EXPECT_THAT(board.refused("why"), HasSubstr("expected a command in progress at fidelity=cycle"));
  EXPECT_THAT(board.say("continue 20"), HasSubstr("pipeline.rays is "));
}

}  // namespace
}  // namespace gicube::emu
