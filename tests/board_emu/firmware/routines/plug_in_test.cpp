// Shared objects that the board is given: what they answer is checked, and none of them stops it.
#include "firmware/routines/plug_in.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

#include "fickle_bsdf.h"
#include "firmware/routines/routine_table.h"
#include "firmware/routines/time_limit.h"
#include "sanitizers.h"

namespace gicube::emu {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Optional;

const std::string kFickle = GICUBE_TEST_DIR "/fickle_bsdf.so";

ScatterEvent event_with(const std::vector<float>& parameters) {
  ScatterEvent event;
  event.direction = {0, 0.6, -0.8};
  event.normal = {0, 0, 1};
  event.parameters = parameters;
  return event;
}

RoutineTable fickle_table() {
  RoutineTable table;
  table.add(PlugIn::load(kFickle));
  return table;
}

std::string fault_of(const RoutineTable& table, Whim whim, float second = 1) {
  const std::vector<float> parameters{static_cast<float>(whim), second};
  try {
    table.scatter(kFirstUserRoutine, event_with(parameters));
  } catch (const RoutineFault& fault) {
    return fault.what();
  }
  return "no fault";
}

std::string load_fault(const std::string& file) {
  try {
    PlugIn::load(file);
  } catch (const PlugInFault& fault) {
    return fault.what();
  }
  return "no fault";
}

gicube_bsdf_event last_event{};

TEST(PlugIn, IsToldAllOfTheEventAndMayReportAsFewAsOneCycle) {
  gicube_bsdf description{};
  description.abi = GICUBE_BSDF_ABI;
  description.size = sizeof description;
  description.name = "told";
  description.cycles = 50;
  description.cycle_budget = 60;
  description.scatter = [](const gicube_bsdf_event* event, gicube_bsdf_answer* answer) {
    last_event = *event;
    answer->direction[1] = 1;
    answer->cycles = static_cast<std::uint32_t>(event->parameters[0]);
  };
  const PlugIn plug_in(description, "linked in");
  const std::vector<float> parameters{1, 7};
  ScatterEvent event = event_with(parameters);
  event.position = {1, 2, 3};
  event.opacity = 0.25;
  event.density = 77;
  event.tag = 2;
  event.lighting = true;
  event.generation = 4;
  event.random = {0.1, 0.2, 0.3, 0.4};
  EXPECT_EQ(plug_in.scatter(event).cycles, 1u);
  EXPECT_EQ(plug_in.scatter(event).direction, (std::array<double, 3>{0, 1, 0}));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(last_event.position[i], event.position[i]);
    EXPECT_EQ(last_event.direction[i], event.direction[i]);
    EXPECT_EQ(last_event.normal[i], event.normal[i]);
  }
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(last_event.random[i], event.random[i]);
  EXPECT_EQ(last_event.size, sizeof last_event);
  EXPECT_EQ(last_event.tag, 2u);
  EXPECT_EQ(last_event.opacity, 0.25);
  EXPECT_EQ(last_event.density, 77);
  EXPECT_EQ(last_event.lighting, 1u);
  EXPECT_EQ(last_event.generation, 4u);
  EXPECT_EQ(last_event.parameter_count, 2u);
  const std::vector<float> none{0}, most{60}, more{61};
  event.parameters = most;
  EXPECT_EQ(plug_in.scatter(event).cycles, 60u);
  for (const auto* wrong : {&none, &more}) {
    event.parameters = *wrong;
    EXPECT_THROW(plug_in.scatter(event), RoutineFault);
  }
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
  EXPECT_THAT(answer.direction, testing::ElementsAre(0, -0.6, 0.8));
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
  EXPECT_EQ(fault_of(table, Whim::kRetroreflect), "no fault") << "and the routine is asked again";
}

TEST(PlugIn, ThatNeverReturnsIsLeftAndNotCalledAgain) {
  if (reference::kHasThreadSanitizer) GTEST_SKIP() << "ThreadSanitizer delivers no signal to a loop without calls";
  const RoutineTable table = fickle_table();
  EXPECT_THAT(fault_of(table, Whim::kEndless), HasSubstr("routine 8 \"fickle\": did not return"));
  EXPECT_THAT(fault_of(table, Whim::kRetroreflect), HasSubstr("did not return"));
  EXPECT_THAT(table.fault(kFirstUserRoutine, {}), Optional(HasSubstr("did not return")));
  const RoutineTable other = fickle_table();
  EXPECT_EQ(fault_of(other, Whim::kRetroreflect), "no fault") << "this thread can call others";
}

TEST(PlugIn, ThatNeverReturnsIsLeftByEachThreadThatCallsIt) {
  if (reference::kHasThreadSanitizer) GTEST_SKIP() << "ThreadSanitizer delivers no signal to a loop without calls";
  const RoutineTable table = fickle_table();
  std::vector<std::string> faults(3);
  {
    std::vector<std::jthread> threads;  // as the emulator's
    for (std::string& fault : faults) threads.emplace_back([&] { fault = fault_of(table, Whim::kEndless); });
  }
  for (const std::string& fault : faults) EXPECT_THAT(fault, HasSubstr("routine 8 \"fickle\": did not return"));
}

// Many short calls take longer than any one may.
TEST(PlugIn, MayBeCalledForAsLongAsItReturns) {
  using Clock = std::chrono::steady_clock;
  const RoutineTable table = fickle_table();
  const auto end = Clock::now() + kCpuLimit + 2 * kTick;
  while (Clock::now() < end) {
    for (int i = 0; i < 1000; ++i) table.scatter(kFirstUserRoutine, event_with({}));
  }
  std::this_thread::sleep_for(3 * kTick);  // without calls the ticks end, and begin again
  EXPECT_EQ(fault_of(table, Whim::kRetroreflect), "no fault");
  if (reference::kHasThreadSanitizer) return;  // it delivers no signal to a loop without calls
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
}

TEST(PlugIn, IsRefusedWithADescriptionThatHoldsNonsense) {
  const gicube_bsdf good{
      GICUBE_BSDF_ABI, sizeof(gicube_bsdf), "good", 10, 20, [](const gicube_bsdf_event*, gicube_bsdf_answer*) {},
      nullptr};
  const auto refusal = [&](auto change) -> std::string {
    gicube_bsdf description = good;
    change(description);
    try {
      const PlugIn plug_in(description, "f");
    } catch (const PlugInFault& fault) {
      return fault.what();
    }
    return "none";
  };
  EXPECT_EQ(refusal([](gicube_bsdf&) {}), "none");
  EXPECT_EQ(refusal([](gicube_bsdf& d) { d.cycles = 1; }), "none");
  EXPECT_EQ(refusal([](gicube_bsdf& d) { d.cycles = d.cycle_budget = 1; }), "none");
  EXPECT_THAT(refusal([](gicube_bsdf& d) { d.size = 8; }), HasSubstr("f: size: expected at least"));
  EXPECT_THAT(refusal([](gicube_bsdf& d) { d.name = nullptr; }), HasSubstr("f: name"));
  EXPECT_THAT(refusal([](gicube_bsdf& d) { d.scatter = nullptr; }), HasSubstr("f: scatter"));
  EXPECT_THAT(refusal([](gicube_bsdf& d) { d.cycles = 0; }), HasSubstr("f: cycles: expected 1..20, got 0"));
  EXPECT_THAT(refusal([](gicube_bsdf& d) { d.cycles = 21; }), HasSubstr("f: cycles: expected 1..20, got 21"));
  EXPECT_THAT(refusal([](gicube_bsdf& d) { d.cycle_budget = 0; }), HasSubstr("f: cycle_budget"));
}

TEST(PlugIn, HasAPrintableName) {
  const gicube_bsdf description{GICUBE_BSDF_ABI,
                                sizeof(gicube_bsdf),
                                "a b~\n\x7f\xe9",
                                10,
                                20,
                                [](const gicube_bsdf_event*, gicube_bsdf_answer*) {},
                                nullptr};
  EXPECT_EQ(PlugIn(description, "f").name(), "a b~???");
}

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
