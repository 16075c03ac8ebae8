// Shared objects that the board is given: what they answer is checked, and none of them stops it.
#include "firmware/routines/plug_in.h"

#include <stdlib.h>
#include <sys/prctl.h>

#include "fickle_bsdf.h"
#include "firmware/routines/routine_table.h"
#include "test.h"

namespace gicube::emu {
namespace {

using testing::Optional;

const std::string kFickle = GICUBE_TEST_DIR "/fickle_bsdf.so";

ScatterEvent event_with(const std::vector<float>& parameters) {
  ScatterEvent event;
  event.direction = {0, 0.6, -0.8};
  event.normal = {0, 0, 1};
  event.parameters = parameters;
  return event;
}

RoutineTable fickle_table(bool is_boxed = true) {
  RoutineTable table;
  table.add(PlugIn::load(kFickle, is_boxed));
  return table;
}

std::string fault_of(const RoutineTable& table, Whim whim, float second = 1) {
  const std::vector<float> parameters{static_cast<float>(whim), second};
  return message_of<RoutineFault>([&] { table.scatter(kFirstUserRoutine, event_with(parameters)); });
}

std::string load_fault(const std::string& file) {
  return message_of<PlugInFault>([&] { PlugIn::load(file); });
}

ScatterAnswer answer_of(const PlugIn& plug_in, ScatterEvent event, std::vector<float> parameters) {
  event.parameters = parameters;
  ScatterAnswer answer;
  plug_in.scatter({&event, 1}, {&answer, 1});
  return answer;
}

double told(const PlugIn& plug_in, const ScatterEvent& event, int number) {
  return answer_of(plug_in, event, {static_cast<float>(Whim::kTell), static_cast<float>(number), 7.5f}).direction[0];
}

TEST(PlugIn, IsToldAllOfTheEvent) {
  const auto plug_in = PlugIn::load(kFickle);
  ScatterEvent event;
  event.position = {1, 2, 3};
  event.direction = {0, 0.6, -0.8};
  event.normal = {0, 0, 1};
  event.random = {0.1, 0.2, 0.3, 0.4};
  event.opacity = 0.25;
  event.density = 77;
  event.tag = 2;
  event.lighting = true;
  event.generation = 4;
  const std::vector<double> all{
      1, 2, 3, 0, 0.6, -0.8, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.25, 77, 2, 1, 4, 3, sizeof(gicube_bsdf_event), 0, 7.5};
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(told(*plug_in, event, static_cast<int>(i)), all[i]) << i;
}

TEST(PlugIn, MayReportOneCycleToItsBudget) {
  const auto plug_in = PlugIn::load(kFickle);
  const auto cycles = [&](unsigned said) {
    return answer_of(*plug_in, {}, {static_cast<float>(Whim::kCostly), static_cast<float>(said)}).cycles;
  };
  EXPECT_EQ(cycles(1), 1u);
  EXPECT_EQ(cycles(kFickleBudget), kFickleBudget);
  EXPECT_THROW(cycles(0), RoutineFault);
  EXPECT_THROW(cycles(kFickleBudget + 1), RoutineFault);
}

TEST(RoutineAnswer, HasALengthOfAMillionthToAMillionAndAShare) {
  const auto faulty = [](double length, double passes) {
    return fault({.direction = {0, length, 0}, .passes = passes}).has_value();
  };
  EXPECT_FALSE(faulty(1e6, 1));
  EXPECT_FALSE(faulty(1e-6, 0));
  EXPECT_TRUE(faulty(1.01e6, 1));
  EXPECT_TRUE(faulty(0.99e-6, 1));
  EXPECT_TRUE(faulty(1, 1.001));
  EXPECT_TRUE(faulty(1, -0.001));
}

TEST(PlugIn, AnswersAsItsCodeSays) {
  const RoutineTable table = fickle_table();
  const std::vector<float> parameters{static_cast<float>(Whim::kRetroreflect), 0.25f};
  const ScatterAnswer answer = table.scatter(kFirstUserRoutine, event_with(parameters));
  EXPECT_THAT(answer.direction, ElementsAre(0, -0.6, 0.8));
  EXPECT_EQ(answer.passes, 0.25);
  EXPECT_EQ(answer.cycles, kFickleCycles) << "declared";
  const std::vector<float> costly{static_cast<float>(Whim::kCostly), kFickleBudget};
  EXPECT_EQ(table.scatter(kFirstUserRoutine, event_with(costly)).cycles, kFickleBudget);
}

TEST(PlugIn, WhatItMustNotAnswerIsAFaultWithItsNameAndTheValue) {
  const RoutineTable table = fickle_table();
  const std::string title = "routine 8 \"fickle\": ";
  EXPECT_THAT(fault_of(table, Whim::kNan), AllOf(HasSubstr(title + "direction: expected a length"), HasSubstr("nan")));
  EXPECT_THAT(fault_of(table, Whim::kInfinite), AllOf(HasSubstr(title + "direction"), HasSubstr("inf")));
  EXPECT_THAT(fault_of(table, Whim::kZero), HasSubstr(title + "direction: expected a length of 1e-6 to 1e6, got 0.0"));
  EXPECT_THAT(fault_of(table, Whim::kPassesMore), HasSubstr(title + "passes: expected 0..1, got 1.5"));
  EXPECT_THAT(fault_of(table, Whim::kPassesLess), HasSubstr(title + "passes: expected 0..1, got -0.25"));
  EXPECT_THAT(fault_of(table, Whim::kPassesNan), HasSubstr("nan"));
  EXPECT_THAT(fault_of(table, Whim::kCostly, 1001), HasSubstr(title + "cycles: expected 1..1000, got 1001"));
  EXPECT_THAT(fault_of(table, Whim::kCostly, 0), HasSubstr("got 0"));
  EXPECT_THAT(fault_of(table, Whim::kThrow), HasSubstr(title + "threw an exception: no mood"));
  EXPECT_EQ(fault_of(table, Whim::kRetroreflect), "none") << "and the routine is asked again";
}

// What ends a call, and what the next one says of it.
TEST(PlugIn, ThatEndsItsProcessHasANewOneForTheNextCall) {
  const RoutineTable table = fickle_table();
  const std::string title = "routine 8 \"fickle\": ";
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(fault_of(table, Whim::kSegfault), title + "its process was ended by signal 11 (Segmentation fault)");
    EXPECT_EQ(fault_of(table, Whim::kAbort), title + "its process was ended by signal 6 (Aborted)");
    EXPECT_EQ(fault_of(table, Whim::kExit, 0), title + "it ended its process, with exit code 0");
    EXPECT_EQ(fault_of(table, Whim::kExit, 3), title + "it ended its process, with exit code 3");
    EXPECT_EQ(fault_of(table, Whim::kRetroreflect), "none");
  }
}

TEST(PlugIn, ThatNeverReturnsIsEndedAndHasANewProcessForTheNextCall) {
  const RoutineTable table = fickle_table();
  EXPECT_EQ(fault_of(table, Whim::kEndless), "routine 8 \"fickle\": did not return within 1000 ms of processor time");
  EXPECT_EQ(fault_of(table, Whim::kRetroreflect), "none");
  EXPECT_EQ(table.fault(kFirstUserRoutine, {}), std::nullopt);
}

TEST(PlugIn, ThatNeverReturnsHoldsUpOnlyTheThreadThatCallsIt) {
  const RoutineTable table = fickle_table();
  std::vector<std::string> faults(3);
  std::atomic<int> answered = 0;
  std::vector<std::jthread> threads;
  for (std::string& fault : faults) threads.emplace_back([&] { fault = fault_of(table, Whim::kEndless); });
  threads.emplace_back([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) answered += fault_of(table, Whim::kRetroreflect) == "none" ? 1 : -1'000'000;
  });
  for (std::size_t i = 0; i < faults.size(); ++i) threads[i].join();
  threads.back().request_stop();
  threads.back().join();
  for (const std::string& fault : faults) EXPECT_THAT(fault, HasSubstr("routine 8 \"fickle\": did not return"));
  EXPECT_GT(answered, 0);
}

TEST(PlugIn, AnswersEachOfManyThreads) {
  const auto plug_in = PlugIn::load(kFickle);
  std::vector<std::jthread> threads;
  for (int thread = 0; thread < 6; ++thread) {
    threads.emplace_back([&plug_in, thread] {
      ScatterEvent event;
      for (int i = 0; i < 300; ++i) {
        event.position[0] = thread * 1000 + i;
        ASSERT_EQ(told(*plug_in, event, 0), event.position[0]);
      }
    });
  }
}

TEST(PlugIn, AnswersEachOfMoreEventsThanACallHas) {
  const RoutineTable table = fickle_table();
  std::vector<std::vector<float>> parameters;
  std::vector<ScatterEvent> events;
  for (std::size_t i = 0; i < 2 * kMaxEvents + 3; ++i) {
    parameters.push_back({static_cast<float>(Whim::kRetroreflect), static_cast<float>(i) / 256});
    if (i % 3 == 0) parameters.back().resize(1);
    events.push_back(event_with(parameters.back()));
    events.back().direction[0] = static_cast<double>(i);
  }
  std::vector<ScatterAnswer> answers(events.size());
  table.scatter_all(kFirstUserRoutine, events, answers);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    EXPECT_EQ(answers[i].direction[0], -static_cast<double>(i));
    EXPECT_EQ(answers[i].passes, i % 3 == 0 ? 1 : static_cast<double>(i) / 256);
    EXPECT_EQ(answers[i].cycles, kFickleCycles);
  }
}

// The limit is that of an event, not of all that are told at once.
TEST(PlugIn, MayTakeItsTimeForEachEventOfACallAndEndsAtTheFirstThatDoesNotReturn) {
  const RoutineTable table = fickle_table();
  const std::vector<float> slow{static_cast<float>(Whim::kSlow), 0.4f}, endless{static_cast<float>(Whim::kEndless)};
  std::vector<ScatterEvent> events(4, event_with(slow));
  std::vector<ScatterAnswer> answers(events.size());
  table.scatter_all(kFirstUserRoutine, events, answers);
  EXPECT_EQ(answers.back().cycles, kFickleCycles);
  events.assign(kMaxEvents, event_with(endless));
  answers.resize(events.size());
  EXPECT_THROW(table.scatter_all(kFirstUserRoutine, events, answers), RoutineFault);
  EXPECT_EQ(fault_of(table, Whim::kRetroreflect), "none");
}

TEST(PlugIn, ThatKillsTheProcessThatItCameFromIsNotCalledAgain) {
  const RoutineTable table = fickle_table(false), other = fickle_table(false);
  const auto lost = AllOf(HasSubstr("routine 8 \"fickle\": its process was ended"), HasSubstr("not called again"));
  EXPECT_THAT(fault_of(table, Whim::kKillParent), lost);
  EXPECT_THAT(fault_of(table, Whim::kRetroreflect), lost);
  EXPECT_THAT(table.fault(kFirstUserRoutine, {}), Optional(lost));
  EXPECT_EQ(fault_of(other, Whim::kRetroreflect), "none");
}

TEST(PlugIn, CannotReadTheProcessThatCallsIt) {
  const RoutineTable free = fickle_table(false), boxed = fickle_table(true);
  const int before = ::prctl(PR_GET_DUMPABLE);
  ::prctl(PR_SET_DUMPABLE, 0);  // as gicube-board
  EXPECT_EQ(fault_of(free, Whim::kReadBoard), "none");
  EXPECT_EQ(fault_of(boxed, Whim::kReadBoard), "none");
  ::prctl(PR_SET_DUMPABLE, before);
}

TEST(PlugIn, GetsNoVariableThatMayHoldASecret) {
  ::setenv("GICUBE_TOKEN_FILE", "/secret", 1);
  const RoutineTable table = fickle_table();
  ::unsetenv("GICUBE_TOKEN_FILE");
  EXPECT_EQ(fault_of(table, Whim::kLookAround), "none");
}

// Many short calls take longer than any one may.
TEST(PlugIn, MayBeCalledForAsLongAsItReturns) {
  using Clock = std::chrono::steady_clock;
  const RoutineTable table = fickle_table();
  const auto end = Clock::now() + kCpuLimit + 2 * kTick;
  while (Clock::now() < end) {
    for (int i = 0; i < 100; ++i) table.scatter(kFirstUserRoutine, event_with({}));
  }
  EXPECT_EQ(fault_of(table, Whim::kRetroreflect), "none");
  EXPECT_THAT(fault_of(table, Whim::kEndless), HasSubstr("did not return"));
}

TEST(PlugIn, ChecksItsParameters) {
  const RoutineTable table = fickle_table();
  const std::vector<float> bad{static_cast<float>(Whim::kRefuse)};
  EXPECT_THAT(table.fault(kFirstUserRoutine, bad), Optional(HasSubstr("routine 8 \"fickle\": mood: expected good")));
  EXPECT_FALSE(table.fault(kFirstUserRoutine, {}));
}

TEST(PlugIn, ThatCannotBeUsedSaysWhy) {
  EXPECT_THAT(load_fault("/no/such/bsdf.so"), HasSubstr("/no/such/bsdf.so"));
  EXPECT_THAT(load_fault("fickle_bsdf.so"), HasSubstr("fickle_bsdf.so")) << "no library folder is searched";
  EXPECT_THAT(load_fault(GICUBE_TEST_DIR "/no_bsdf.so"),
              HasSubstr("no_bsdf.so: expected a function gicube_bsdf_describe, got none"));
  EXPECT_THAT(load_fault(GICUBE_TEST_DIR "/old_bsdf.so"), HasSubstr("old_bsdf.so: abi: expected 1, got 2"));
  EXPECT_THAT(load_fault(GICUBE_TEST_DIR "/null_bsdf.so"),
              HasSubstr("null_bsdf.so: gicube_bsdf_describe() returned null"));
  EXPECT_THAT(load_fault(GICUBE_TEST_DIR "/exit_bsdf.so"),
              HasSubstr("exit_bsdf.so: loading it: it ended its process, with exit code 5"));
  EXPECT_THAT(load_fault(GICUBE_TEST_DIR "/endless_bsdf.so"),
              HasSubstr("endless_bsdf.so: its loading or gicube_bsdf_describe() did not return within 1000 ms"));
}

TEST(PlugIn, IsRefusedWithADescriptionThatHoldsNonsense) {
  const RoutineDescription good{.abi = GICUBE_BSDF_ABI,
                                .size = sizeof(gicube_bsdf),
                                .name = "good",
                                .cycles = 10,
                                .cycle_budget = 20,
                                .has_scatter = 1};
  const auto refusal = [&](auto change) {
    RoutineDescription description = good;
    change(description);
    return fault(description).value_or("none");
  };
  EXPECT_EQ(refusal([](RoutineDescription&) {}), "none");
  EXPECT_EQ(refusal([](RoutineDescription& d) { d.cycles = 1; }), "none");
  EXPECT_EQ(refusal([](RoutineDescription& d) { d.cycles = d.cycle_budget = 1; }), "none");
  EXPECT_EQ(refusal([](RoutineDescription& d) { d.abi = 7; }), "abi: expected 1, got 7");
  EXPECT_THAT(refusal([](RoutineDescription& d) { d.size = 8; }), HasSubstr("size: expected at least"));
  EXPECT_THAT(refusal([](RoutineDescription& d) { d.name[0] = '\0'; }), HasSubstr("name"));
  EXPECT_THAT(refusal([](RoutineDescription& d) { d.has_scatter = 0; }), HasSubstr("scatter"));
  EXPECT_EQ(refusal([](RoutineDescription& d) { d.cycles = 0; }), "cycles: expected 1..20, got 0");
  EXPECT_EQ(refusal([](RoutineDescription& d) { d.cycles = 21; }), "cycles: expected 1..20, got 21");
  EXPECT_THAT(refusal([](RoutineDescription& d) { d.cycle_budget = 0; }), HasSubstr("cycle_budget"));
}

TEST(PlugIn, ShowsOnlyPrintableText) { EXPECT_EQ(printable("a b~\n\x7f\xe9 and more", 7), "a b~???"); }

TEST(BrushedMetal, ReflectsMostAcrossItsGrooves) {
  RoutineTable table;
  table.add(PlugIn::load(GICUBE_BIN_DIR "/brushed_metal.so"));
  const std::vector<float> grooves_along_x{1, 0, 0, 0.2f, 0.02f, 0.75f};
  ASSERT_FALSE(table.fault(kFirstUserRoutine, grooves_along_x));
  ScatterEvent event;
  event.direction = {0, 0, -1};
  event.normal = {0, 0, 1};
  event.parameters = grooves_along_x;
  double along = 0, across = 0;
  for (int i = 0; i < 4096; ++i) {
    event.random = {(i % 64 + 0.5) / 64, (i / 64 + 0.5) / 64, 0, 0};
    const ScatterAnswer answer = table.scatter(kFirstUserRoutine, event);
    EXPECT_GT(answer.direction[2], 0);
    EXPECT_FLOAT_EQ(static_cast<float>(answer.passes), 0.75f);
    EXPECT_EQ(answer.cycles, 320u);
    along += answer.direction[0] * answer.direction[0];
    across += answer.direction[1] * answer.direction[1];
  }
  EXPECT_GT(across, 30 * along);
  EXPECT_THAT(table.fault(kFirstUserRoutine, std::vector<float>{1, 2}),
              Optional(HasSubstr("\"brushed metal\": expected no parameters or 6, got 2")));
}

}  // namespace
}  // namespace gicube::emu
