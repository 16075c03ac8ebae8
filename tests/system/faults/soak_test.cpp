// Rays through every fault that a plan can name. script/soak runs it at length, by these environment variables.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iostream>

#include "sanitizers.h"
#include "soak.h"

namespace gicube::system_test {
namespace {

std::uint64_t number(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

SoakPlan plan() {
  SoakPlan plan;
  plan.seed = number("GICUBE_SOAK_SEED", plan.seed);
  plan.batches = number("GICUBE_SOAK_BATCHES", plan.batches);
  plan.rays = number("GICUBE_SOAK_RAYS", plan.rays);
  plan.kills = static_cast<std::uint32_t>(number("GICUBE_SOAK_KILLS", plan.kills));
  return plan;
}

void show(const SoakReport& report) {
  std::cout << report.rays << " rays: " << report.lost << " lost, " << report.doubled << " doubled, " << report.wrong
            << " wrong; " << report.faults << " faults:";
  for (const auto& [kind, count] : report.kinds) std::cout << ' ' << kind << ' ' << count;
  std::cout << "; " << report.processes << " processes, " << report.memory_faults << " memory faults met, "
            << report.volumes_mended << " volumes mended, " << report.given_up << " resumptions given up, "
            << (report.peak_memory >> 20) << " MiB at most\n"
            << std::flush;
}

void expect_sound(const SoakReport& report, const SoakPlan& plan) {
  EXPECT_EQ(report.rays, plan.batches * plan.rays);
  EXPECT_EQ(report.lost, 0u);
  EXPECT_EQ(report.doubled, 0u);
  EXPECT_EQ(report.wrong, 0u);
  EXPECT_EQ(report.carried_out_twice, 0u);
  EXPECT_EQ(report.processes, plan.kills + 1);
  EXPECT_EQ(report.kinds.size(), 10u) << "a kind of fault did not come up";
  constexpr bool kIsPlain = !reference::kHasAddressSanitizer && !reference::kHasThreadSanitizer;
  if (kIsPlain) {
    EXPECT_LT(report.peak_memory, std::uint64_t{128} << 20) << "chosen: a board at its start, and its limits";
  }
  EXPECT_GE(report.faults, number("GICUBE_SOAK_FAULTS", 100));
}

TEST(Soak, NoRayIsLostDoubledOrWrongAndTheSameSeedGivesTheSameLog) {
  const SoakReport first = soak(plan());
  show(first);
  expect_sound(first, plan());
  const SoakReport second = soak(plan());
  show(second);
  expect_sound(second, plan());
  EXPECT_TRUE(first.log == second.log) << "given up: " << first.given_up << " and " << second.given_up;
  if (const char* folder = std::getenv("GICUBE_SOAK_LOGS")) {
    std::ofstream(std::string(folder) + "/first.log") << first.log;
    std::ofstream(std::string(folder) + "/second.log") << second.log;
  }
}

}  // namespace
}  // namespace gicube::system_test
