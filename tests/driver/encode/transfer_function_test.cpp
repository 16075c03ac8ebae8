#include "gicube/transfer_function.h"

#include "encode/look_up_tables.h"
#include "refusal.h"
#include "test.h"

namespace gicube {
namespace {

TransferFunction ramp() { return {{{0, {0, 0.25, 1}}, {100, {1, 0.75, 0}}}, {{10, 0}, {20, 0.5}, {20, 1}, {40, 0.2}}}; }

TEST(TransferFunction, IsLinearBetweenPointsAndConstantBeyond) {
  const TransferFunction f = ramp();
  EXPECT_EQ(f.colour_at(50), (Colour{0.5, 0.5, 0.5}));
  EXPECT_EQ(f.colour_at(25), (Colour{0.25, 0.375, 0.75}));
  EXPECT_EQ(f.colour_at(-1000), (Colour{0, 0.25, 1}));
  EXPECT_EQ(f.colour_at(1000), (Colour{1, 0.75, 0}));
  EXPECT_DOUBLE_EQ(f.opacity_at(15), 0.25);
  EXPECT_DOUBLE_EQ(f.opacity_at(30), 0.6);
}

TEST(TransferFunction, AStepTakesTheSecondPointsSide) {
  const TransferFunction f = ramp();
  EXPECT_EQ(f.opacity_at(20), 1);
  EXPECT_NEAR(f.opacity_at(19.999999), 0.5, 1e-6);
  const TransferFunction at_the_ends{{{0, {}}}, {{0, 0.1}, {0, 0.3}, {1, 0.4}, {1, 0.9}}};
  EXPECT_EQ(at_the_ends.opacity_at(0), 0.3);
  EXPECT_EQ(at_the_ends.opacity_at(-1), 0.1);
  EXPECT_EQ(at_the_ends.opacity_at(1), 0.9);
}

TEST(TransferFunction, OnePointIsAConstant) {
  const TransferFunction f{{{7, {0.1, 0.2, 0.3}}}, {{7, 0.4}}};
  for (const double value : {-1.0, 7.0, 8.0}) {
    EXPECT_EQ(f.opacity_at(value), 0.4);
    EXPECT_EQ(f.colour_at(value), (Colour{0.1, 0.2, 0.3}));
  }
}

TEST(TransferFunction, WithoutPointsItHasNoValue) {
  EXPECT_EQ(refusal([] { (void)TransferFunction{}.opacity_at(1); }),
            "opacities: expected at least one point, got none");
  EXPECT_EQ(refusal([] { (void)TransferFunction{}.colour_at(1); }), "colours: expected at least one point, got none");
}

TEST(TransferFunctionCheck, AcceptsAStepAndEveryTag) {
  for (int tag = 0; tag < 4; ++tag) EXPECT_EQ(refusal([tag] { check(ramp(), tag); }), "accepted");
  EXPECT_EQ(refusal([] { check(ramp(), 4); }), "tag: expected 0..3, got 4");
  EXPECT_EQ(refusal([] { check(ramp(), -1); }), "tag: expected 0..3, got -1");
}

// The refusal of ramp() after `edit`.
template <typename Edit>
std::string refusal_after(Edit&& edit) {
  TransferFunction f = ramp();
  edit(f);
  return refusal([&f] { check(f, 0); });
}

TEST(TransferFunctionCheck, NamesThePointThatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal_after([](auto& f) { f.opacities[3].opacity = 1.7; }),
            "opacities[3].opacity: expected 0..1, got 1.7");
  EXPECT_EQ(refusal_after([&](auto& f) { f.opacities[0].opacity = nan; }),
            "opacities[0].opacity: expected 0..1, got nan");
  EXPECT_EQ(refusal_after([](auto& f) { f.colours[1].colour[2] = -0.1; }),
            "colours[1].colour[2]: expected 0..1, got -0.1");
  EXPECT_EQ(refusal_after([&](auto& f) { f.colours[1].value = nan; }),
            "colours[1].value: expected a finite number, got nan");
  EXPECT_EQ(refusal_after([](auto& f) { f.opacities[1].value = 5; }),
            "opacities[1].value: expected at least 10, the value before it, got 5");
  EXPECT_EQ(refusal_after([](auto& f) { f.opacities[3].value = 20; }),
            "opacities[3].value: expected at most two points at one value, got a third at 20");
  EXPECT_EQ(refusal_after([](auto& f) { f.colours.clear(); }), "colours: expected at least one point, got none");
  EXPECT_EQ(refusal_after([](auto& f) {
              f = {.colours = {}, .opacities = {{0, 0}, {1, 0.1}}};
            }),
            "colours: expected at least one point, got none");
  EXPECT_EQ(refusal_after([](auto& f) { f.opacities.clear(); }), "opacities: expected at least one point, got none");
}

TEST(TransferFunctionCheck, ReadsNoFurtherThanTheLastPoint) {
  TransferFunction function = ramp();
  function.colours.push_back({200, {7, 7, 7}});
  function.colours.pop_back();  // what was there still is
  function.opacities.push_back({50, 7});
  function.opacities.pop_back();
  EXPECT_NO_THROW(check(function, 1));
}

TEST(TransferFunctionCheck, RefusesASpanThatIsNotFinite) {
  EXPECT_EQ(refusal_after([](auto& f) {
              f.colours = {{-1.5e308, {}}, {1.5e308, {}}};
            }),
            "colours: expected values whose span is finite, got inf");
}

}  // namespace
}  // namespace gicube
