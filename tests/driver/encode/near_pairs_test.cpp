// Near pairs: what is near, how it is divided and summed up; and pairs as the board's words.
#include "encode/near_pairs.h"

#include "encode/pairs.h"
#include "refusal.h"
#include "test.h"

namespace gicube {
namespace {

Element cube(Vec3 origin, double edge = 1) {
  return {ElementKind::kBox, origin, {edge, 0, 0}, {0, edge, 0}, {0, 0, edge}};
}
Element square(Vec3 origin, double edge = 1) { return {ElementKind::kPatch, origin, {edge, 0, 0}, {0, edge, 0}, {}}; }

// By the standard error's own words (Agresti and Coull 1998): two of four further rays arrive.
double noise_of(double geometric, double share, double even) {
  const double likely = (even * share + 2) / (even + 4);
  return geometric * (std::sqrt(likely * (1 - likely) / (even + 4)) + std::abs(likely - share) / 3);
}

TEST(NearPairs, ShareTheirRaysAmongFourToSixteenEach) {
  EXPECT_EQ(NearPairs({1, 1, 1}, 3).rays_per_part(), 3u);       // one part
  EXPECT_EQ(NearPairs({1, 1, 1}, 8).rays_per_part(), 4u);       // two
  EXPECT_EQ(NearPairs({1, 1, 1}, 127).rays_per_part(), 4u);     // 31
  EXPECT_EQ(NearPairs({1, 1, 1}, 400).rays_per_part(), 12u);    // 32
  EXPECT_EQ(NearPairs({1, 1, 1}, 1000).rays_per_part(), 16u);   // 62
  EXPECT_EQ(NearPairs({1, 1, 1}, 65536).rays_per_part(), 64u);  // 1024
}

TEST(NearPairs, AreThoseWhoseGapIsLessThanHalfOfTheLongestSide) {
  NearPairs pairs({1, 1, 1}, 64);
  EXPECT_NE(pairs.division_of(cube({0, 0, 0}, 2), cube({2.99, 0, 0})), nullptr);
  EXPECT_EQ(pairs.division_of(cube({0, 0, 0}, 2), cube({3, 0, 0})), nullptr);
  EXPECT_NE(pairs.division_of(cube({5, 5, 5}), cube({3.01, 5, 5}, 1.5)), nullptr);
  EXPECT_EQ(pairs.division_of(cube({0, 0, 0}, 2), cube({2.8, 2.8, 0})), nullptr) << "1.13 across";
  EXPECT_NE(pairs.division_of(cube({0, 0, 0}, 2), cube({2.7, 2.7, 0})), nullptr) << "0.99 across";
  EXPECT_EQ(
      pairs.division_of(square({0, 0, 0}, 2), Element{ElementKind::kPatch, {0, 0, 0.1}, {1, 0, 0}, {2, 0, 0}, {}}),
      nullptr);
  // Gaps are physical.
  NearPairs tall({1, 1, 3}, 64);
  EXPECT_EQ(tall.division_of(square({0, 0, 0}, 2), square({0, 0, 0.34}, 2)), nullptr);
  EXPECT_NE(tall.division_of(square({0, 0, 0}, 2), square({0, 0, 0.33}, 2)), nullptr);
  // Sides that go backwards bound the same box.
  Element back = cube({4.9, 0, 0}, 2);
  back.u = {-2, 0, 0};
  EXPECT_NE(pairs.division_of(cube({0, 0, 0}, 2), back), nullptr);
}

TEST(NearPairs, OfDiscsAreThoseWhoseGapIsLessThanHalfOfTheDiameter) {
  NearPairs pairs({1, 1, 1}, 64);
  const auto disc = [](double z, double radius) {
    return Element{ElementKind::kDisc, {5, 5, z}, {radius, 0, 0}, {0, radius, 0}, {}};
  };
  EXPECT_NE(pairs.division_of(disc(1, 0.25), disc(1.24, 0.25)), nullptr);
  EXPECT_EQ(pairs.division_of(disc(1, 0.25), disc(1.26, 0.25)), nullptr);
}

TEST(NearPairs, OfBoxesThatAreMirroredOrTurnedToOtherAxesHaveTheSameFactor) {
  const auto factor = [](Vec3 origin, NearPairs pairs) {
    const Division& division = *pairs.division_of(cube({4, 4, 4}), cube(origin, 0.5));
    EXPECT_EQ(division.parts.size(), 1u);
    return division.parts[0].factor.mean;
  };
  const NearPairs undivided({1, 1, 1}, 3);
  const double first = factor({5, 4.5, 4}, undivided);
  EXPECT_GT(first, 0);
  EXPECT_EQ(factor({3.5, 4, 4.5}, undivided), first);
  EXPECT_EQ(factor({4.5, 4, 3.5}, undivided), first);
  EXPECT_NE(factor({5, 4.5, 4.25}, undivided), first);
}

TEST(NearPairs, PartsOfBoxesHaveTheFactorsOfTheirElements) {
  const Vec3 spacing{1, 2, 0.5};
  NearPairs pairs(spacing, 400);
  const auto physical = [&](Element box) {
    for (Vec3* each : {&box.origin, &box.u, &box.v, &box.w}) {
      *each = {each->x * spacing.x, each->y * spacing.y, each->z * spacing.z};
    }
    return box;
  };
  const Division& division = *pairs.division_of(cube({1, 2, 3}, 2), cube({3, 1, 4}));
  EXPECT_EQ(division.parts.size(), 32u);
  for (const PairPart& part : division.parts) {
    const GeometricFactor alone =
        geometric_factor(physical(division.elements[part.a]), physical(division.elements[part.b]), part.near);
    EXPECT_NEAR(part.factor.mean, alone.mean, 1e-6 * alone.mean);
    EXPECT_NEAR(part.factor.error, alone.error, 1e-6 * alone.mean);
  }
}

TEST(NearPairs, AreDividedIntoPartsThatCoverAllPairsOfPointsOnce) {
  NearPairs pairs({1, 1, 1}, 128);
  const Element a = cube({3, 4, 5}, 2), b = cube({5, 4, 5});
  const Division* division = pairs.division_of(a, b);
  ASSERT_NE(division, nullptr);
  ASSERT_EQ(division->parts.size(), 32u);
  double measures = 0, light = 0;
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  for (const PairPart& part : division->parts) {
    measures += part.measure;
    light += part.measure * part.factor.mean;
    const Element &x = division->elements[part.a], &y = division->elements[part.b];
    EXPECT_NEAR(part.measure, measure_of(x) * measure_of(y) / 8, 1e-12);
    EXPECT_TRUE(seen.emplace(part.a, part.b).second);
  }
  EXPECT_NEAR(measures, 1, 1e-12);
  const GeometricFactor whole = geometric_factor(a, b, true);
  EXPECT_NEAR(light, whole.mean, 3 * whole.error + 0.02 * whole.mean);
  EXPECT_EQ(division->elements[0].origin, (Vec3{0, 0, 0}));
  EXPECT_EQ(division->elements[1].origin, (Vec3{2, 0, 0}));
  // The same pair elsewhere is known, another one is not.
  EXPECT_EQ(pairs.division_of(cube({0, 0, 0}, 2), cube({2, 0, 0})), division);
  EXPECT_NE(pairs.division_of(cube({0, 0, 0}, 2), cube({2, 1, 0})), division);
  EXPECT_NE(pairs.division_of(square({0, 0, 0}, 2), cube({2, 0, 0})), division);
}

TEST(NearPairs, OfDiscsAndTrianglesAreDividedIntoSectorsRingsAndTriangles) {
  NearPairs pairs({1, 1, 2}, 4096);
  const Element disc{ElementKind::kDisc, {8, 8, 4}, {4, 0, 0}, {0, 3, 0.5}, {}};
  const Element triangle{ElementKind::kTriangle, {3, 6, 5}, {1, 8, 1}, {9, 2, 1}, {}};
  const Division* division = pairs.division_of(disc, triangle);
  ASSERT_NE(division, nullptr);
  ASSERT_EQ(division->parts.size(), 256u);
  const auto area = [](const Element& element) {
    Element physical = element;
    for (Vec3* side : {&physical.u, &physical.v}) side->z *= 2;
    return measure_of(physical);
  };
  const double whole = area(disc) * area(triangle);
  double measures = 0, light = 0, error = 0;
  bool ring = false, sector = false;
  for (const PairPart& part : division->parts) {
    const Element &x = division->elements[part.a], &y = division->elements[part.b];
    EXPECT_NEAR(part.measure, area(x) * area(y) / whole, 1e-9);
    measures += part.measure;
    light += part.measure * part.factor.mean, error += part.measure * part.factor.error;
    ring = ring || x.w.x > 0, sector = sector || x.w.y > 0;
  }
  EXPECT_NEAR(measures, 1, 1e-12);
  EXPECT_TRUE(ring && sector);
  // The light of the parts is that of the whole, which the first of all elements are.
  NearPairs one({1, 1, 2}, 3);
  const PairPart all = one.division_of(disc, triangle)->parts.at(0);
  EXPECT_GT(light, 0);
  EXPECT_NEAR(light, all.factor.mean, 3 * all.factor.error + 3 * error + 0.001 * light);
}

TEST(NearPairs, AreDividedMostWhereTheirLightIs) {
  NearPairs pairs({1, 1, 1}, 128);
  const Division* division = pairs.division_of(cube({0, 0, 0}), cube({1, 0, 0}));
  double largest = 0, smallest = 1;
  for (const PairPart& part : division->parts) {
    largest = std::max(largest, part.measure * part.factor.mean);
    smallest = std::min(smallest, part.measure * part.factor.mean);
  }
  EXPECT_LT(largest, 5 * smallest);
}

// Two parts with light 1 and 2; half of the first arrives, all of the second.
TEST(NearPairs, SumUpTheSharesThatArriveOfEachPartsLight) {
  const NearPairs pairs({1, 1, 1}, 16);
  const double rays = pairs.rays_per_part();
  Division division;
  division.parts = {{0, 1, 0.5, {2, 0.1}, false}, {0, 2, 0.5, {4, 0.2}, false}};
  const std::vector<PairFactor> found{{.transported = 3, .geometric = 6}, {.transported = 1.5, .geometric = 1.5}};
  const PairFactor sum = pairs.sum_up(division, found);
  EXPECT_DOUBLE_EQ(sum.geometric, 3);
  EXPECT_DOUBLE_EQ(sum.transported, 2.5);
  EXPECT_FALSE(sum.clear);
  EXPECT_NEAR(sum.standard_error, noise_of(3, 2.5 / 3, 9 / ((1 + 4) / rays)) + 0.15, 1e-12);
}

TEST(NearPairs, CountRaysOfPartsThatAreStillNearAsAnEighthAndTheirErrorAsCommon) {
  const NearPairs pairs({1, 1, 1}, 1000);
  ASSERT_EQ(pairs.rays_per_part(), 16u);
  Division division;
  division.parts = {{0, 1, 1, {2, 0}, true}};
  const std::vector<PairFactor> found{{.transported = 0.25, .geometric = 1}};
  EXPECT_NEAR(pairs.sum_up(division, found).standard_error, noise_of(2, 0.25, 2) + 2 * std::sqrt(0.25 * 0.75 / 16),
              1e-12);
}

TEST(NearPairs, WhereNothingWasFoundTheLightItselfIsTheError) {
  const NearPairs pairs({1, 1, 1}, 16);
  Division division;
  division.parts = {{0, 1, 1, {2, 0.5}, false}};
  const std::vector<PairFactor> none{{.transported = 0, .geometric = 0}}, more{{.transported = 3, .geometric = 2}};
  EXPECT_EQ(pairs.sum_up(division, none).transported, 0);
  EXPECT_NEAR(pairs.sum_up(division, none).standard_error, noise_of(2, 0, 4) + 0.5 + 2, 1e-12);
  EXPECT_EQ(pairs.sum_up(division, more).transported, 2) << "no more than all";
}

TEST(NearPairs, ClearPartsHaveOnlyTheClosedFormsError) {
  const NearPairs pairs({1, 1, 1}, 16);
  Division division;
  division.parts = {{0, 1, 0.5, {2, 0.1}, true}, {0, 2, 0.5, {4, 0.2}, false}};
  const PairFactor clear{.transported = 1, .geometric = 1, .clear = true};
  const PairFactor sum = pairs.sum_up(division, std::vector<PairFactor>{clear, clear});
  EXPECT_TRUE(sum.clear);
  EXPECT_NEAR(sum.standard_error, 0.15, 1e-12);
  EXPECT_DOUBLE_EQ(sum.transported, 3);
  EXPECT_FALSE(pairs.sum_up(division, std::vector<PairFactor>{clear, {.transported = 1, .geometric = 1}}).clear);
}

TEST(PairError, HoldsWhatNoRayHasFound) {
  const double unseen = std::sqrt(2.0) / 20;
  EXPECT_NEAR(error_with_unseen({.transported = 3, .geometric = 5, .standard_error = 0.4}, 16),
              std::hypot(0.4, 3 * unseen), 1e-12);
  // Half of the way from nothing to two of twenty rays.
  EXPECT_NEAR(error_with_unseen({.transported = 0, .geometric = 5, .standard_error = 0}, 16), 5 * (unseen + 0.05),
              1e-12);
  // A share of 0.2 that varies as that of rays that arrive or end, 1.8 times told, and one that varies half as much.
  const double yes_or_no = 1.8 * 5 * std::sqrt(0.2 * 0.8 / 16), half_way = 5 * ((16 * 0.2 + 2) / 20 - 0.2) / 2;
  EXPECT_NEAR(error_with_unseen({.transported = 1, .geometric = 5, .standard_error = yes_or_no}, 16),
              std::hypot(yes_or_no, unseen) + half_way, 1e-12);
  EXPECT_NEAR(error_with_unseen({.transported = 1, .geometric = 5, .standard_error = yes_or_no / 2}, 16),
              std::hypot(yes_or_no / 2, unseen) + half_way / 4, 1e-12);
  EXPECT_EQ(error_with_unseen({.transported = 3, .geometric = 5, .standard_error = 0.4, .clear = true}, 16), 0.4);
}

template <typename Edit>
std::string refused_pairs(Edit&& edit) {
  PairRequest request;
  edit(request);
  return refusal([&] { check(request); });
}

TEST(PairRequestCheck, AcceptsTheLimitsOfEachFieldAndNamesWhatIsBeyond) {
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.rays = 65536; }), "accepted");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.rays = 1; }), "accepted");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.rays = 0; }), "request.rays: expected 1..65536, got 0");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.rays = 65537; }), "request.rays: expected 1..65536, got 65537");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.first = 4294967295u - 16; }), "accepted");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.first = 4294967295u - 15; }).substr(0, 14), "request.first:");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.opacity = 0; }),
            "request.opacity: expected more than 0, at most 1, got 0");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.opacity = 1.1; }),
            "request.opacity: expected more than 0, at most 1, got 1.1");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.opacity = 1e-6; }), "accepted");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.step = 16; }), "accepted");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.step = 16.5; }), "request.step: expected 0.015625..16, got 16.5");
  EXPECT_EQ(refused_pairs([](PairRequest& r) { r.step = 0.0156; }), "request.step: expected 0.015625..16, got 0.0156");
}

TEST(PairCheck, NamesTheElementThatIsPartlyOutsideAndThePairWithoutElement) {
  const auto refused = [](const Element& element) { return refusal([&] { check(element, 3, {8, 9, 10}); }); };
  EXPECT_EQ(refused(Element{ElementKind::kBox, {0, 0, 0}, {7, 0, 0}, {0, 8, 0}, {0, 0, 9}}), "accepted");
  EXPECT_EQ(refused(Element{ElementKind::kBox, {0, 0, 1}, {7, 0, 0}, {0, 8, 0}, {0, 0, 9}}),
            "elements[3]: expected an element in the volume, got one from (0, 0, 1) to (7, 8, 10)");
  EXPECT_EQ(refused(Element{ElementKind::kPatch, {0, 0, 1}, {7, 0, 0}, {0, 8, 0}, {0, 0, 9}}), "accepted")
      << "a patch has no w";
  EXPECT_EQ(refused(Element{ElementKind::kPatch, {1, 0, 0}, {-2, 0, 0}, {0, 8, 0}, {}}),
            "elements[3]: expected an element in the volume, got one from (-1, 0, 0) to (1, 8, 0)");
  EXPECT_EQ(refusal([] { check(ElementPair{4, 4, 0}, 6, 5); }), "accepted");
  EXPECT_EQ(refusal([] { check(ElementPair{4, 5, 0}, 6, 5); }), "pairs[6]: expected elements below 5, got 5");
  EXPECT_EQ(refusal([] { check(ElementPair{5, 0, 0}, 6, 5); }), "pairs[6]: expected elements below 5, got 5");
}

TEST(PairsCommand, HasTheElementsThatItsPairsNameInTheOrderOfTheirNaming) {
  const std::vector<Element> elements{square({0, 0, 0}), cube({1, 1, 1}), cube({2, 2, 2})};
  const std::vector<ElementPair> pairs{{2, 0, 77}, {0, 2, 78}};
  const PairRequest request{.rays = 9, .first = 5, .seed = 6, .opacity = 0.5};
  const auto bytes = pairs_command(elements, pairs, request);
  const auto header = wire::decode<wire::PairsHeader>(std::span(bytes));
  EXPECT_EQ(header.elements, 2u);
  EXPECT_EQ(header.pairs, 2u);
  EXPECT_EQ(header.rays, 9u);
  EXPECT_EQ(header.first, 5u);
  EXPECT_EQ(header.seed, 6u);
  EXPECT_EQ(header.opacity, 8388608u);
  ASSERT_EQ(bytes.size(), 32u + 2 * 56 + 2 * 12);
  EXPECT_EQ(wire::decode<wire::Element>(std::span(bytes).subspan(32)).origin, (std::array<float, 3>{2, 2, 2}));
  EXPECT_EQ(wire::decode<wire::Element>(std::span(bytes).subspan(32 + 56)).kind, wire::ElementKind::kPatch);
  const auto second = wire::decode<wire::Pair>(std::span(bytes).subspan(32 + 2 * 56 + 12));
  EXPECT_EQ(second.a, 1u);
  EXPECT_EQ(second.b, 0u);
  EXPECT_EQ(second.id, 78u);
}

TEST(HostsPairRays, AreSummedUpWithTheirWeightsAndThoseWithoutWeightAsClear) {
  const std::vector<double> weights{1, 0, 2, 4, 4, 4};
  std::vector<TracedRay> rays(5);
  rays[0].opacity = 0.25;
  rays[1].opacity = 1;
  const auto sums = sum_up(weights, rays, 3);
  ASSERT_EQ(sums.size(), 2u);
  EXPECT_DOUBLE_EQ(sums[0].geometric, 1);
  EXPECT_DOUBLE_EQ(sums[0].transported, 0.25);
  EXPECT_DOUBLE_EQ(sums[1].geometric, 4);
  EXPECT_DOUBLE_EQ(sums[1].transported, 4);
}

// A cube in front of a square, and one behind it: what is sent is what weighs something.
TEST(HostsPairRays, RunFromPointsOfOneElementToPointsOfTheOther) {
  const std::vector<Element> elements{square({4, 4, 4}, 2), cube({4, 4, 7}, 2), cube({4, 4, 1}, 2)};
  const PairRequest request{.rays = 40, .seed = 3};
  const PairRaysMade front = make_rays(elements, std::vector<ElementPair>{{0, 1, 5}}, request, {1, 1, 1}, {40, 40, 40});
  EXPECT_EQ(front.weights.size(), 40u);
  ASSERT_EQ(front.rays.size(), 40u);
  for (const HostRay& ray : front.rays) {
    EXPECT_EQ(ray.id, 5u);
    EXPECT_NEAR(ray.position.z, 4, 1e-6);
    const double end = ray.position.z + ray.direction.z / length(ray.direction) * ray.length;
    EXPECT_GE(end, 7 - 1e-6);
    EXPECT_LE(end, 9 + 1e-6);
  }
  double mean = 0;
  for (const double weight : front.weights) mean += weight / 40;
  EXPECT_NEAR(mean, geometric_factor(elements[0], elements[1], false).mean, 0.1 * mean);
  EXPECT_TRUE(make_rays(elements, std::vector<ElementPair>{{0, 2, 5}}, request, {1, 1, 1}, {40, 40, 40}).rays.empty());
  // Later samples are others.
  PairRequest later = request;
  later.first = 40;
  EXPECT_FALSE(
      make_rays(elements, std::vector<ElementPair>{{0, 1, 5}}, later, {1, 1, 1}, {40, 40, 40}).rays[0].position ==
      front.rays[0].position);
}

TEST(ClearPair, HasTheSumOfRaysThatAllArrive) {
  const Element a = square({4, 4, 4}, 2), b = cube({4, 4, 7}, 2);
  const PairRequest request{.rays = 40, .first = 7, .seed = 3};
  const PairFactor clear = clear_factor(to_wire(a), to_wire(b), 5, request, {1, 1, 1});
  const PairRaysMade made =
      make_rays(std::vector<Element>{a, b}, std::vector<ElementPair>{{0, 1, 5}}, request, {1, 1, 1}, {40, 40, 40});
  const std::vector<TracedRay> arrived(made.rays.size());
  const PairFactor sum = sum_up(made.weights, arrived, 40)[0];
  EXPECT_TRUE(clear.clear);
  EXPECT_EQ(clear.transported, sum.transported);
  EXPECT_EQ(clear.geometric, sum.geometric);
  EXPECT_EQ(clear.standard_error, sum.standard_error);
}

TEST(ElementCheck, ADiscsSharesBeginAtNothing) {
  const auto refused = [](Vec3 shares) {
    const Element disc{ElementKind::kDisc, {8, 8, 8}, {2, 0, 0}, {0, 2, 0}, shares};
    return refusal([&] { check(disc, 3, {32, 32, 32}); });
  };
  EXPECT_EQ(refused({0, 0, 0}), "accepted");
  EXPECT_EQ(refused({-0.001, 0, 0}), "elements[3].w: expected a disc's shares of 0 or more and below 1, got -0.001");
  EXPECT_EQ(refused({0, 1, 0}), "elements[3].w: expected a disc's shares of 0 or more and below 1, got 1");
}

}  // namespace
}  // namespace gicube
