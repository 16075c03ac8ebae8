// Flights and visibility by the board against closed forms, and the lights that paths begin at.
#include "../../../../driver/board/test_board.h"
#include "gicube/scene/scene.h"
#include "light/transport/eye.h"
#include "light/transport/flights.h"
#include "light/transport/lights.h"
#include "light/transport/paths.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr double kPi = std::numbers::pi;

struct Loaded {
  explicit Loaded(const std::string& text) : board(Board::open("emu:")), setup(set_up_of(text)), medium(board, setup) {}
  static SceneSetup set_up_of(const std::string& text) {
    Scene scene = parse_scene(text, "scene", ".");
    scene.lighting.on = true;
    return set_up(scene, 1);
  }
  Board board;
  SceneSetup setup;
  Medium medium;
};

// 16 voxels an edge, 15 edges across, of this extinction an edge.
std::string fog(double extinction) {
  return "world { low { } high { x: 15 y: 15 z: 15 } size: 16 node { material: \"fog\" box { low { x: -9 y: -9 z: -9 } "
         "high { x: 99 y: 99 z: 99 } } } }"
         "material { name: \"fog\" fog { extinction: " +
         std::to_string(extinction) + " } scattering: 0.5 bsdf: \"isotropic\" }";
}

std::string ball(const std::string& material) {
  return "world { low { x: -12 y: -12 z: -12 } high { x: 12 y: 12 z: 12 } size: 25 node { material: \"a\" sphere { "
         "radius: 6 } } }"
         "material { name: \"a\" solid { opacity: 0.6 } " +
         material + " }";
}

// A closed room in a world of 18 edges an axis, with walls between its voxels or on them, full of fog that only
// absorbs.
std::string room(Vec3 low, Vec3 high, double extinction) {
  const auto wall = [](Vec3 from, Vec3 to) {
    const auto at = [](Vec3 v) {
      return "x: " + std::to_string(v.x) + " y: " + std::to_string(v.y) + " z: " + std::to_string(v.z);
    };
    return "node { material: \"wall\" box { low { " + at(from) + " } high { " + at(to) + " } } } ";
  };
  return "world { low { } high { x: 18 y: 18 z: 18 } size: 19 " + wall({-9, -9, -9}, {low.x, 99, 99}) +
         wall({high.x, -9, -9}, {99, 99, 99}) + wall({-9, -9, -9}, {99, low.y, 99}) +
         wall({-9, high.y, -9}, {99, 99, 99}) + wall({-9, -9, -9}, {99, 99, low.z}) +
         wall({-9, -9, high.z}, {99, 99, 99}) +
         "node { material: \"fog\" box { low { x: -9 y: -9 z: -9 } high { x: 99 y: 99 z: 99 } } } }"
         "material { name: \"wall\" solid { } scattering: 1 bsdf: \"diffuse\" }"
         "material { name: \"fog\" fog { extinction: " +
         std::to_string(extinction) + " } } light { point { position { x: 10.3 y: 9.9 z: 10.7 } } power: 1 }";
}

TEST(Flights, PassAllTheFogBetweenTwoWalls) {
  for (const double shift : {0.0, 0.3, 0.45, 0.8}) {
    const Vec3 low{2 + shift, 3, 4}, high{15.6, 15, 14};
    Loaded loaded(room(low, high, 0.07));
    Flights flights(loaded.board, loaded.medium, 0.25, 1);
    constexpr double kOff = 0.05;  // the board takes samples on both ends
    const Segment segments[] = {{{low.x + kOff, 9.2, 9.1}, {high.x - kOff, 9.2, 9.1}}};
    EXPECT_NEAR(-std::log(flights.transmittances(segments)[0]) / (0.07 * (high.x - low.x)), 1, 0.015) << shift;
  }
}

// Walls send all light back, so each path ends in the fog, after a way of one over the extinction on average,
// whatever the room's shape.
TEST(Paths, InARoomOfWhiteWallsAreAsLongAsItsFogLetsThem) {
  for (const double shift : {0.0, 0.4}) {
    Loaded loaded(room({2 + shift, 3, 4}, {16, 15 - shift, 14}, 0.07));
    Flights flights(loaded.board, loaded.medium, 0.5, 1);
    const Lights lights(loaded.setup, loaded.medium);
    const Paths paths(loaded.medium, lights, flights);
    std::vector<Path> walks;
    constexpr std::size_t kPaths = 8192;
    for (std::size_t i = 0; i < kPaths; ++i) walks.push_back(paths.from_light(PathRandom(7, i)));
    double length = 0;
    paths.walk(walks, 100, [&](const Path&, double distance) { length += distance / kPaths; });
    EXPECT_NEAR(length * 0.07, 1, 0.03) << shift;
  }
}

TEST(Flights, EndInFogAsBeerAndLambertSayWhateverTheStep) {
  Loaded loaded(fog(0.1));
  for (const double step : {0.3, 0.5, 2.0}) {
    Flights board(loaded.board, loaded.medium, step, 1);
    const std::vector<Flight> flights(20000, Flight{{-3, 4.3, 5.2}, normalise({15, 3, 2})});
    const double across = 15 / flights[0].direction.x;
    int hits = 0, early = 0;
    for (const auto& hit : board.first_hits(flights)) {
      if (!hit) continue;
      ++hits;
      EXPECT_GE(hit->place.x, 0);
      EXPECT_LE(hit->place.x, 15);
      EXPECT_EQ(hit->normal, Vec3{});
      early += hit->distance - 3 / flights[0].direction.x < 4.1 ? 1 : 0;  // from where the volume begins
    }
    const auto off = [](double p) { return 3 * std::sqrt(p * (1 - p) * 20000); };  // strata make it less
    const double all = 1 - std::exp(-0.1 * across), near = 1 - std::exp(-0.41);
    EXPECT_NEAR(hits, 20000 * all, off(all)) << step;
    EXPECT_NEAR(early, 20000 * near, off(near)) << step;
  }
}

// Flights that leave the volume within half a step have one sample, which stands for more than is left of them.
TEST(Flights, ThatLeaveTheVolumeSoonEscapeAsBeerAndLambertSay) {
  Loaded loaded(fog(0.5));
  Flights board(loaded.board, loaded.medium, 1, 1);
  constexpr int kBatches = 20, kFlights = 2048;
  for (const double left : {0.1, 0.4, 0.6, 1.2, 1.7}) {
    const std::vector<Flight> flights(kFlights, Flight{{15 - left, 4.3, 5.2}, {1, 0, 0}});
    double share = 0;
    for (int i = 0; i < kBatches; ++i) {
      for (const auto& hit : board.first_hits(flights)) share += (hit ? 1.0 : 0.0) / kBatches / kFlights;
    }
    const double truth = 1 - std::exp(-0.5 * left);
    EXPECT_NEAR(share, truth, 3 * std::sqrt(truth * (1 - truth) / kBatches / kFlights)) << left;
  }
}

// A law of large numbers for batches of any size, also of those that no division into commands fits: the mean is the
// law's, and no batch's share scatters by more than that of independent flights would.
TEST(Flights, OfBatchesOfAnySizeEndAsOftenAsBeerAndLambertSay) {
  Loaded loaded(fog(0.5));
  Flights board(loaded.board, loaded.medium, 1, 1);
  for (const auto& [batches, size] : {std::pair{500, 1}, {600, 33}, {200, 97}, {40, 1000}, {10, 5000}}) {
    for (const double left : {0.05, 1.4, 6.0}) {
      const std::vector<Flight> flights(static_cast<std::size_t>(size), Flight{{15 - left, 4.3, 5.2}, {1, 0, 0}});
      const double truth = 1 - std::exp(-0.5 * left), binomial = std::sqrt(truth * (1 - truth) / size);
      double sum = 0, squares = 0;
      for (int i = 0; i < batches; ++i) {
        double share = 0;
        for (const auto& hit : board.first_hits(flights)) share += (hit ? 1.0 : 0.0) / size;
        sum += share - truth, squares += (share - truth) * (share - truth);
      }
      EXPECT_NEAR(sum / batches, 0, 3 * binomial / std::sqrt(batches)) << size << " flights, " << left;
      EXPECT_LT(std::sqrt(squares / batches), 1.3 * binomial) << size << " flights, " << left;
    }
  }
}

// Each flight of a batch has a number of its own, also of one command.
TEST(Flights, OfOneCommandEndAtPlacesOfTheirOwn) {
  Loaded loaded(fog(0.2));
  Flights board(loaded.board, loaded.medium, 0.5, 1);
  std::vector<double> places;
  for (const auto& hit : board.first_hits(std::vector<Flight>(4096, Flight{{0, 4.3, 5.2}, {1, 0, 0}}))) {
    if (hit) places.push_back(hit->distance);
  }
  std::ranges::sort(places);
  EXPECT_EQ(std::ranges::unique(places).size(), 0u);
  for (const double distance : {0.3, 1.0, 4.0, 10.0, 14.9}) {
    const auto nearer = std::ranges::upper_bound(places, distance) - places.begin();
    EXPECT_NEAR(static_cast<double>(nearer) / 4096, 1 - std::exp(-0.2 * distance), 1e-3) << distance;
  }
}

TEST(Flights, EndAtSurfacesWhereHalfOfTheOpacityIs) {
  Loaded loaded(ball("scattering: 0.5 bsdf: \"diffuse\""));
  Flights board(loaded.board, loaded.medium, 0.5, 1);
  const Vec3 middle{12, 12, 12};
  std::vector<Flight> flights;
  PathRandom random(2, 0);
  for (int i = 0; i < 500; ++i) {
    const Vec3 from = random.direction();
    flights.push_back({middle + 30 * from, -1.0 * from});
  }
  for (const auto& hit : board.first_hits(flights)) {
    ASSERT_TRUE(hit);
    EXPECT_NEAR(length(hit->place - middle), 6, 0.1);  // voxels between which a ball is not quite linear
    EXPECT_GT(dot(hit->normal, normalise(hit->place - middle)), 0.98);
  }
  const std::vector<Flight> past(10, Flight{{12, 12, -4}, normalise({0, 7, 16})});
  for (const auto& hit : board.first_hits(past)) EXPECT_FALSE(hit);
}

TEST(Flights, LeaveGlassAtItsSurface) {
  Loaded loaded(ball("scattering: 1 bsdf: \"trap\" routine: \"fresnel\" surface: true"));
  Flights board(loaded.board, loaded.medium, 0.5, 1);
  const Vec3 middle{12, 12, 12};
  std::vector<Flight> flights;
  PathRandom random(3, 0);
  for (int i = 0; i < 500; ++i) {
    const Vec3 start = random.direction(), out = random.direction();
    flights.push_back({middle + 5.9 * start, dot(start, out) < 0 ? out : -1.0 * out, true});
  }
  const auto hits = board.first_hits(flights);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    ASSERT_TRUE(hits[i]) << i;
    EXPECT_NEAR(length(hits[i]->place - middle), 6, 0.1) << i;
    EXPECT_GT(dot(hits[i]->normal, flights[i].direction), -0.2) << i;
  }
}

TEST(Flights, TellWhatPassesBetweenPointsInsideAndOutside) {
  Loaded loaded(fog(0.2));
  Flights board(loaded.board, loaded.medium, 0.5, 1);
  const std::vector<Segment> segments{
      {{2, 3, 4}, {12, 3, 4}}, {{-20, 3, 4}, {40, 3, 4}}, {{-1, -1, -1}, {-5, 20, 3}}, {{7, 7, 7}, {7, 7, 99}}};
  const std::vector<double> through = board.transmittances(segments);
  EXPECT_NEAR(through[0], std::exp(-2), 1e-4);
  EXPECT_NEAR(through[1], std::exp(-3), 1e-4);
  EXPECT_EQ(through[2], 1);
  EXPECT_NEAR(through[3], std::exp(-1.6), 1e-4);
}

TEST(Optics, DrawDirectionsOfTheirMeanCosine) {
  PathRandom random(4, 0);
  for (const double g : {-0.4, 0.0, 0.8}) {
    const Optics optics{.bsdf = Bsdf::kIsotropic, .g = g};
    double sum = 0, all = 0;
    for (int i = 0; i < 100000; ++i) {
      sum += scatter(optics, {0, 0, 1}, {}, random).z;
      all += 4 * kPi * density(optics, {0, 0, 1}, {}, random.direction());
    }
    EXPECT_NEAR(sum / 1e5, g, 3 * 0.58 / std::sqrt(1e5));
    EXPECT_NEAR(all / 1e5, 1, 0.03);
  }
}

TEST(Optics, ARoutineThatTheHostHasNotIsNamed) {
  EXPECT_THROWS(scene::InputError, "routine: expected fresnel or henyey_greenstein, got 2",
                Loaded(ball("scattering: 1 bsdf: \"trap\" routine: \"tabulated\" parameter: 1")));
}

TEST(Eye, DrawsEvenPlacesInPixelsForAnyNumberOfRays) {
  Loaded loaded(fog(0.1));
  View view;
  view.eye = {7, 7, -40}, view.look_at = {7, 7, 7}, view.width = 13, view.height = 7;
  const Eye eye(view, loaded.medium);
  constexpr std::size_t kPixel = 3 * 13 + 5;
  constexpr int kSeeds = 3000, kRays = 3;
  int left = 0, upper = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    for (std::uint64_t ray = 0; ray < kRays; ++ray) {
      const Vec3 direction = from_eye(eye, kPixel, {seed, ray}).flight.direction;
      EXPECT_EQ(eye.pixel_of(direction), kPixel);
      // Before the planes through the eye and the pixel's middle.
      const auto beside = [&](double x, double y) { return eye.direction(5.5 + x, 3.5 + y); };
      left += dot(direction, cross(beside(0, -1), beside(0, 1))) > 0 ? 1 : 0;
      upper += dot(direction, cross(beside(1, 0), beside(-1, 0))) > 0 ? 1 : 0;
    }
  }
  for (const int half : {left, upper}) EXPECT_NEAR(half, kSeeds * kRays / 2.0, 3 * std::sqrt(kSeeds * kRays / 4.0));
}

// A light is chosen by its power, and a point on it evenly.
TEST(Lights, AreChosenByTheirPowers) {
  Loaded loaded(fog(0.1) +
                "light { rectangle { corner { x: 2 y: 2 z: 12 } edge_u { y: 4 } edge_v { x: 4 } } power: 3 }"
                "light { sphere { centre { x: 7 y: 7 z: 7 } radius: 2 } power: 1 }");
  const Lights lights(loaded.setup, loaded.medium);
  constexpr int kPoints = 30001;
  int first = 0, near = 0;
  for (int i = 0; i < kPoints; ++i) {
    PathRandom random(8, static_cast<std::uint64_t>(i));
    const LightPoint point = lights.point(random);
    first += point.light == 0 ? 1 : 0;
    near += point.light == 0 && point.place.x < 3 ? 1 : 0;
  }
  EXPECT_NEAR(first, 0.75 * kPoints, 3 * std::sqrt(0.75 * 0.25 * kPoints));
  EXPECT_NEAR(near, first / 4.0, 3 * std::sqrt(first * 3 / 16.0));
}

// The light that lamps send out is their power; the light that they send to a point is its irradiance.
TEST(Lights, SendTheirPower) {
  const auto light = [](const std::string& text) { return fog(0.1) + "light { " + text + " power: 12 }"; };
  const double r2 = 10 * 10;
  for (const auto& [text, power, irradiance] :
       {std::tuple{"point { position { x: 7 y: 7 z: 12 } }", 12.0, 12 / (4 * kPi * r2)},
        std::tuple{"sphere { centre { x: 7 y: 7 z: 12 } radius: 2 }", 12.0, 12 / (4 * kPi * r2)},
        // Small beside its distance: 12 / pi times the cosines over the squared distance.
        std::tuple{"rectangle { corner { x: 6.9 y: 6.9 z: 12 } edge_u { y: 0.2 } edge_v { x: 0.2 } }", 12.0,
                   12 / (kPi * r2)}}) {
    Loaded loaded(light(text));
    const Lights lights(loaded.setup, loaded.medium);
    PathRandom random(5, 0);
    double sent = 0, fallen = 0, squares = 0;
    constexpr int kSamples = 40000;
    const Vec3 place{7, 7, 2};
    for (int i = 0; i < kSamples; ++i) {
      sent += lights.emit(random).power[0] / kSamples;
      const LightPoint point = lights.point(random);
      const Vec3 way = point.place - place, direction = normalise(way);
      const double one = lights.emitted(point, -1.0 * direction)[0] * direction.z / dot(way, way);
      fallen += one / kSamples, squares += one * one / kSamples;
    }
    const double error = std::sqrt(std::max(0.0, squares - fallen * fallen) / kSamples);
    EXPECT_NEAR(sent, power, 1e-6 * power) << text;
    EXPECT_NEAR(fallen, irradiance, 3 * error + 1e-3 * irradiance) << text;
  }
}

}  // namespace
}  // namespace gicube::samples
