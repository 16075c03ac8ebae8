#include "firmware/routines/routine_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gicube::emu {
namespace {

using testing::HasSubstr;

const gicube_bsdf kPlain{GICUBE_BSDF_ABI,
                         sizeof(gicube_bsdf),
                         "plain",
                         10,
                         20,
                         [](const gicube_bsdf_event* event, gicube_bsdf_answer* answer) {
                           for (int i = 0; i < 3; ++i) answer->direction[i] = event->direction[i];
                         },
                         nullptr};

TEST(RoutineTable, NumbersUserRoutinesFromEightInTheirOrder) {
  RoutineTable table;
  EXPECT_TRUE(table.has(0) && table.has(1) && table.has(2));
  EXPECT_FALSE(table.has(3) || table.has(8) || table.has(wire::kHostRoutine));
  table.add(std::make_unique<PlugIn>(kPlain, "a.so"));
  table.add(std::make_unique<PlugIn>(kPlain, "b.so"));
  EXPECT_TRUE(table.has(8) && table.has(9));
  EXPECT_FALSE(table.has(10));
  const auto list = table.list();
  ASSERT_EQ(list.size(), 5u);
  EXPECT_EQ(list[0].name, "fresnel");
  EXPECT_EQ(list[1].cycles, 200u);
  EXPECT_EQ(list[4].number, 9);
  EXPECT_EQ(list[4].file, "b.so");
  EXPECT_EQ(list[4].cycle_budget, 20u);
}

TEST(RoutineTable, LeavesTheHostsNumberFree) {
  RoutineTable table;
  for (int number = kFirstUserRoutine; number < wire::kHostRoutine; ++number) {
    table.add(std::make_unique<PlugIn>(kPlain, "x.so"));
  }
  EXPECT_TRUE(table.has(254));
  EXPECT_FALSE(table.has(255));
  EXPECT_THROW(table.add(std::make_unique<PlugIn>(kPlain, "y.so")), PlugInFault);
}

TEST(RoutineTable, NamesTheRoutineWhoseParametersAreWrong) {
  const float g = 2;
  EXPECT_EQ(built_in_routines().fault(1, {}), std::nullopt);
  EXPECT_THAT(built_in_routines().fault(1, std::span(&g, 1)),
              testing::Optional(HasSubstr("routine 1 \"henyey_greenstein\": g: expected")));
}

}  // namespace
}  // namespace gicube::emu
