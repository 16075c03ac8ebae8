// The board's answers on the visibility of random pairs of points, against the march in double precision.
#include "accuracy/measure.h"
#include "accuracy/scenes.h"
#include "gicube/board.h"
#include "reference/transmittance.h"
#include "test.h"

namespace gicube::accuracy {
namespace {

constexpr double kStep = 0.5;  // voxels, the board's
constexpr double kReferenceStep = 1 / 16.0;
constexpr double kThinnest = 1 / 64.0;  // to which outliers are taken
constexpr double kMaxMean = 0.002, kMaxEach = 0.05;

struct Case {
  std::string scene;
  std::size_t pairs;
};

struct PointPair {
  Vec3 from, to;
};

std::vector<PointPair> draw_pairs(std::size_t count, Dims dims) {
  std::mt19937 random(1);
  const auto point = [&] {
    const auto axis = [&](std::size_t i) {
      return static_cast<double>(random() % static_cast<unsigned>(dims[i]));  // voxels' centres
    };
    return Vec3{axis(0), axis(1), axis(2)};
  };
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < count; ++i) pairs.push_back({point(), point()});
  return pairs;
}

class Visibility : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const auto all = study_scenes(GICUBE_SOURCE_DIR "/../shared/data", 96);
    const auto found = std::find_if(all.begin(), all.end(), [](const auto& s) { return s.name == GetParam().scene; });
    if (!found->available()) GTEST_SKIP() << found->scene.volume.file << " is not there";
    setup_ = samples::set_up(found->scene);
    board_ = std::make_unique<Board>(Board::open(uri_for(*found, "emu:")));
    board_->load_volume(setup_.volume_view());
    const ValueRange range = board_->value_range();
    for (std::size_t tag = 0; tag < setup_.materials.size(); ++tag) {
      board_->set_transfer_function(samples::in_values_of(range, setup_.materials[tag]), static_cast<int>(tag));
    }
  }

  std::vector<double> by_board(const std::vector<PointPair>& pairs, double step) {
    std::vector<HostRay> rays;
    for (const PointPair& pair : pairs) {
      rays.push_back(ray_between(static_cast<std::uint32_t>(rays.size()), pair.from, pair.to));
    }
    const RayBatch batch = board_->receive(board_->submit(rays, {.type = RayType::kOpacity, .step = step}));
    std::vector<double> through;
    for (const TracedRay& ray : batch.rays) through.push_back(1 - ray.opacity);
    return through;
  }

  std::vector<double> by_doubles(const std::vector<PointPair>& pairs) const {
    const reference::Scene scene = to_reference(setup_);
    const reference::Field field(scene.volume, {});
    std::vector<double> through(pairs.size());
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t i = next++; i < pairs.size(); i = next++) {
        through[i] = reference::transmittance(scene, field, pairs[i].from, pairs[i].to, kReferenceStep);
      }
    };
    std::vector<std::jthread> others;
    for (unsigned t = 1; t < std::thread::hardware_concurrency(); ++t) others.emplace_back(work);
    work();
    others.clear();
    return through;
  }

  samples::SceneSetup setup_;
  std::unique_ptr<Board> board_;
};

TEST_P(Visibility, OfRandomPairsOfVoxelsIsThatOfTheDoublePrecisionMarch) {
  const auto pairs = draw_pairs(GetParam().pairs, setup_.volume.dims);
  const auto got = by_board(pairs, kStep), expected = by_doubles(pairs);
  double sum = 0, visible = 0;
  std::vector<std::size_t> outliers;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double error = std::abs(got[i] - expected[i]);
    sum += error;
    visible += expected[i];
    if (error > kMaxEach) outliers.push_back(i);
  }
  const auto count = static_cast<double>(pairs.size());
  EXPECT_GT(visible / count, 0.02);  // neither all clear nor all hidden
  EXPECT_LT(visible / count, 0.98);
  EXPECT_LT(sum / count, kMaxMean);
  RecordProperty("mean_error", std::to_string(sum / count));
  RecordProperty("outliers", std::to_string(outliers.size()));

  // A thinner step cures every one of them.
  for (double step = kStep / 2; !outliers.empty() && step >= kThinnest; step /= 2) {
    std::vector<PointPair> again;
    for (const std::size_t i : outliers) again.push_back(pairs[i]);
    const auto thinner = by_board(again, step);
    std::vector<std::size_t> left;
    for (std::size_t k = 0; k < outliers.size(); ++k) {
      if (std::abs(thinner[k] - expected[outliers[k]]) > kMaxEach) left.push_back(outliers[k]);
    }
    outliers = left;
    RecordProperty("outliers_at_step_" + std::to_string(step), std::to_string(outliers.size()));
  }
  EXPECT_TRUE(outliers.empty()) << outliers.size() << " pairs, the first from voxel (" << pairs[outliers[0]].from.x
                                << ", " << pairs[outliers[0]].from.y << ", " << pairs[outliers[0]].from.z << ")";
}

TEST_P(Visibility, IsTheSameThereAndBack) {
  const auto pairs = draw_pairs(GetParam().pairs / 5, setup_.volume.dims);
  std::vector<PointPair> back;
  for (const PointPair& pair : pairs) back.push_back({pair.to, pair.from});
  const auto there = by_board(pairs, kStep), and_back = by_board(back, kStep);
  double sum = 0;
  std::size_t apart = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    sum += std::abs(there[i] - and_back[i]);
    apart += std::abs(there[i] - and_back[i]) > 0.01;
  }
  EXPECT_LT(sum / static_cast<double>(pairs.size()), 5e-4);
  EXPECT_LT(static_cast<double>(apart) / static_cast<double>(pairs.size()), 0.005);  // grazing rays
  RecordProperty("mean_difference", std::to_string(sum / static_cast<double>(pairs.size())));
  RecordProperty("apart", std::to_string(apart));
}

INSTANTIATE_TEST_SUITE_P(In, Visibility,
                         testing::Values(Case{"buckyball", 20'000}, Case{"engine", 100'000}, Case{"brain", 100'000}),
                         [](const auto& test) { return test.param.scene; });

}  // namespace
}  // namespace gicube::accuracy
