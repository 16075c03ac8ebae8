// gicube::Projector against double precision: any orbit, both directions, and that they are each other's transpose.
#include "gicube/projector.h"
#include "open_board.h"
#include "reference/tomography.h"
#include "test.h"

namespace gicube::samples {
namespace {

// Long voxels; views from all sides and from above, tilted, turned, shifted, with skewed pixels.
ProjectorSetup any_orbit() {
  ProjectorSetup setup{.dims = {14, 12, 10}, .spacing = {1, 1.2, 1.5}, .columns = 13, .rows = 11, .step = 0.125};
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> part(-1, 1);
  for (int i = 0; i < 6; ++i) {
    const Vec3 out = normalise(Vec3{part(engine), part(engine), 0.6 * part(engine)});
    const Vec3 across = normalise(cross(out, Vec3{part(engine), part(engine), part(engine)})), up = cross(out, across);
    const Vec3 tilt = 0.1 * out;
    setup.views.push_back({(40 + 10 * part(engine)) * out,
                           -20.0 * out + 3 * part(engine) * across + 2 * part(engine) * up, 2.0 * (across + tilt),
                           2.2 * (up + 0.1 * across)});
  }
  return setup;
}

template <typename Value>
std::vector<Value> random_values(std::size_t count, double low, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> value(low, 1);
  std::vector<Value> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(static_cast<Value>(value(engine)));
  return out;
}

template <typename A, typename B>
double relative(const A& found, const B& wanted) {
  double off = 0, all = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    off += std::pow(double(found[i]) - double(wanted[i]), 2);
    all += std::pow(double(wanted[i]), 2);
  }
  return std::sqrt(off / all);
}

TEST(OperatorPair, IsThatOfDoublePrecisionOnAnyOrbit) {
  const ProjectorSetup setup = any_orbit();
  Board board = open_board();
  Projector projector(board, setup);
  for (const double low : {0.0, -1.0}) {
    const auto volume = random_values<float>(14 * 12 * 10, low, 1);
    const auto found = projector.project(volume);
    const auto wanted = reference::project(setup, std::vector<double>(volume.begin(), volume.end()));
    EXPECT_LT(relative(found, wanted), 4e-3) << low;
    const auto values = random_values<float>(found.size(), low, 2);
    const auto back = projector.backproject(values);
    EXPECT_LT(relative(back, reference::backproject(setup, std::vector<double>(values.begin(), values.end()))), 4e-3);
  }
  EXPECT_GT(projector.counts().rays, 1000u);
  EXPECT_GT(projector.counts().deposits, 10'000u);
  EXPECT_EQ(projector.counts().overflowed, 0u);
}

// <A x, y> = <x, A^T y>, to the rounding of volumes to 12 bits.
TEST(OperatorPair, IsEachOthersTranspose) {
  Board board = open_board();
  Projector projector(board, any_orbit());
  const auto x = random_values<float>(14 * 12 * 10, 0, 3);
  const auto seen = projector.project(x), y = random_values<float>(seen.size(), 0, 4), back = projector.backproject(y);
  double left = 0, right = 0;
  for (std::size_t i = 0; i < y.size(); ++i) left += double{seen[i]} * double{y[i]};
  for (std::size_t i = 0; i < x.size(); ++i) right += double{x[i]} * double{back[i]};
  EXPECT_NEAR(left / right, 1, 5e-4);
}

TEST(OperatorPair, TakesSomeViewsInAnyOrder) {
  Board board = open_board();
  Projector projector(board, any_orbit());
  const auto volume = random_values<float>(14 * 12 * 10, 0, 5);
  const std::vector<std::size_t> some{4, 1};
  const auto all = projector.project(volume), few = projector.project(volume, some);
  ASSERT_EQ(few.size(), 2u * 143);
  for (std::size_t i = 0; i < 143; ++i) {
    EXPECT_EQ(few[i], all[4 * 143 + i]);
    EXPECT_EQ(few[143 + i], all[143 + i]);
  }
  std::vector<float> alone(all.size());
  std::copy_n(all.begin() + 4 * 143, 143, alone.begin() + 4 * 143);
  const std::vector<std::size_t> one{4};
  EXPECT_LT(relative(projector.backproject(std::span(all).subspan(4 * 143, 143), one), projector.backproject(alone)),
            1e-4);
}

TEST(OperatorPair, OfAViewThatMissesTheVolumeIsNothing) {
  ProjectorSetup setup = any_orbit();
  for (ViewPose& view : setup.views) view.centre = view.centre + 1000.0 * view.u;
  Board board = open_board();
  Projector projector(board, setup);
  const auto seen = projector.project(random_values<float>(14 * 12 * 10, 0, 6));
  EXPECT_THAT(seen, testing::Each(0.0F));
  EXPECT_THAT(projector.backproject(std::vector<float>(seen.size(), 1.0F)), testing::Each(0.0F));
}

// The pixel (column, row) of the doc's formula: a small ball off all axes shows where the pose puts it.
TEST(OperatorPair, ShowsABallInThePixelOfTheFormula) {
  const ProjectorSetup setup{.dims = {32, 30, 28},
                             .columns = 60,
                             .rows = 50,
                             .views = {{{80, 10, -5}, {-70, 3, 4}, {0.2, 1.4, 0.1}, {0.1, 0.0, 1.5}}}};
  std::vector<float> volume(32 * 30 * 28);
  volume[(20 * 30 + 8) * 32 + 25] = 1;  // at (9.5, -6.5, 6.5)
  Board board = open_board();
  const auto seen = Projector(board, setup).project(volume);
  const ViewPose& view = setup.views[0];
  const Vec3 way = Vec3{9.5, -6.5, 6.5} - view.source;
  double column = 0, row = 0, sum = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    column += double{seen[i]} * double(i % 60);
    row += double{seen[i]} * double(i / 60);
    sum += double{seen[i]};
  }
  // Where the line through the voxel meets the detector, by solving for it.
  const Vec3 normal = cross(view.u, view.v);
  const Vec3 on = view.source + (dot(view.centre - view.source, normal) / dot(way, normal)) * way - view.centre;
  const double uu = dot(view.u, view.u), vv = dot(view.v, view.v), uv = dot(view.u, view.v);
  const double a = dot(on, view.u), b = dot(on, view.v), square = uu * vv - uv * uv;
  EXPECT_NEAR(column / sum, 29.5 + (vv * a - uv * b) / square, 0.05);
  EXPECT_NEAR(row / sum, 24.5 + (uu * b - uv * a) / square, 0.05);
}

TEST(OperatorPair, NamesWhatIsWrong) {
  Board board = open_board();
  const auto made = [&](const auto& change) {
    ProjectorSetup setup = any_orbit();
    change(setup);
    return [&board, setup] { Projector(board, setup); };
  };
  const auto saying = [](const char* text) { return ThrowsMessage<BadArgument>(HasSubstr(text)); };
  EXPECT_THAT(made([](auto& setup) { setup.dims[1] = 1; }), saying("dims: expected at least 2, got 1"));
  EXPECT_THAT(made([](auto& setup) { setup.spacing.y = 0; }), saying("spacing: expected finite numbers above 0"));
  EXPECT_THAT(made([](auto& setup) { setup.columns = 0; }), saying("columns"));
  EXPECT_THAT(made([](auto& setup) { setup.step = 40; }), saying("step"));
  EXPECT_THAT(made([](auto& setup) { setup.views.clear(); }), saying("views: expected at least one"));
  EXPECT_THAT(made([](auto& setup) { setup.views[2].source = {}; }),
              saying("views[2].source: expected a position outside of the volume"));
  EXPECT_THAT(made([](auto& setup) { setup.views[3].v = setup.views[3].u; }),
              saying("views[3].v: expected a direction"));
  EXPECT_THAT(made([](auto& setup) { setup.views[1].centre.x = NAN; }), saying("views[1].centre.x"));
  EXPECT_THAT(made([](auto& setup) { setup.views[0].centre = setup.views[0].source; }),
              saying("views[0].centre: expected a plane that does not contain the source"));
  Projector projector(board, any_orbit());
  EXPECT_THAT([&] { projector.project(std::vector<float>(5)); }, saying("volume: expected 1680 values, got 5"));
  EXPECT_THAT([&] { projector.backproject(std::vector<float>(5)); }, saying("values: expected 858 values, got 5"));
  EXPECT_THAT([&] { projector.backproject(std::vector<float>(858, NAN)); }, saying("values: expected finite values"));
  const std::vector<std::size_t> wrong{6};
  EXPECT_THAT([&] { projector.project(std::vector<float>(1680), wrong); },
              saying("views: expected indices below 6, got 6"));
}

}  // namespace
}  // namespace gicube::samples
