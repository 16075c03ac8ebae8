#include "firmware/routines/routine_table.h"

#include "fickle_bsdf.h"
#include "test.h"

namespace gicube::emu {
namespace {

std::unique_ptr<PlugIn> plug_in() { return PlugIn::load(GICUBE_TEST_DIR "/fickle_bsdf.so"); }

TEST(RoutineTable, NumbersUserRoutinesFromEightInTheirOrder) {
  RoutineTable table;
  EXPECT_TRUE(table.has(0) && table.has(1) && table.has(2));
  EXPECT_FALSE(table.has(3) || table.has(8) || table.has(wire::kHostRoutine));
  table.add(plug_in());
  table.add(PlugIn::load(GICUBE_BIN_DIR "/brushed_metal.so"));
  EXPECT_TRUE(table.has(8) && table.has(9));
  EXPECT_FALSE(table.has(10));
  const auto list = table.list();
  ASSERT_EQ(list.size(), 5u);
  EXPECT_EQ(list[0].name, "fresnel");
  EXPECT_EQ(list[1].cycles, 200u);
  EXPECT_EQ(list[4].number, 9);
  EXPECT_EQ(list[3].cycle_budget, kFickleBudget);
  EXPECT_EQ(list[4].name, "brushed metal");
  EXPECT_EQ(list[4].file, GICUBE_BIN_DIR "/brushed_metal.so");
}

TEST(RoutineTable, LeavesTheHostsNumberFree) {
  const std::shared_ptr<const PlugIn> one = plug_in();
  RoutineTable table;
  for (int number = kFirstUserRoutine; number < wire::kHostRoutine; ++number) {
    table.add(one);
  }
  EXPECT_TRUE(table.has(254));
  EXPECT_FALSE(table.has(255));
  EXPECT_THROW(table.add(one), PlugInFault);
}

TEST(RoutineTable, NamesTheRoutineWhoseParametersAreWrong) {
  const float g = 2;
  EXPECT_EQ(built_in_routines().fault(1, {}), std::nullopt);
  EXPECT_THAT(built_in_routines().fault(1, std::span(&g, 1)),
              testing::Optional(HasSubstr("routine 1 \"henyey_greenstein\": g: expected")));
}

}  // namespace
}  // namespace gicube::emu
