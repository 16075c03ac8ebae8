// Whether PairFactor::standard_error is one, over many geometries: independent experiments against references that find
// the light by directions, where nothing is unbounded.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

constexpr int kSize = 40;
constexpr double kSide = 20;  // voxels

enum class Medium {
  kClear,
  kThin,    // light falls by e over a side
  kThick,   // by e^3
  kScreen,  // opaque about 10.5 < z < 13.5, x < 16.5: some 6 voxels above the floor
};

double kappa_of(Medium medium) {
  return medium == Medium::kThin ? 1 / kSide : medium == Medium::kThick ? 3 / kSide : 0;
}

bool in_screen(int x, int z) { return z >= 11 && z <= 13 && x <= 16; }

void fill(Board& board, Medium medium) {
  std::vector<std::byte> samples(std::size_t{kSize} * kSize * kSize, std::byte{0});
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto x = static_cast<int>(i % kSize), z = static_cast<int>(i / kSize / kSize);
    if (medium == Medium::kScreen && in_screen(x, z)) samples[i] = std::byte{200};
  }
  board.load_volume({.samples = samples, .dims = {kSize, kSize, kSize}});
  TransferFunction function{.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 1 - std::exp(-kappa_of(medium))}}};
  if (medium == Medium::kScreen) function.opacities = {{100, 0}, {100, 1}};
  board.set_transfer_function(function);
  board.set_empty_flags(std::vector<std::uint8_t>(board.empty_flags().size(), 0));  // nothing is proved clear
}

// Through the screen sampled as the board does it, every half voxel: interpolated values are opaque from half of the
// screen's on.
double transmittance(Medium medium, Vec3 from, Vec3 to) {
  if (medium != Medium::kScreen) return std::exp(-kappa_of(medium) * length(to - from));
  const int steps = static_cast<int>(std::ceil(length(to - from) / 0.5));
  for (int i = 0; i < steps; ++i) {
    const Vec3 at = from + ((i + 0.5) / steps) * (to - from);
    const double across = std::clamp(17 - at.x, 0.0, 1.0),
                 through = std::clamp(std::min(at.z - 10, 14 - at.z), 0.0, 1.0);
    if (across * through >= 0.5) return 0;
  }
  return 1;
}

Element patch(Vec3 origin, Vec3 u, Vec3 v) { return {ElementKind::kPatch, origin, u, v, {}}; }
Element triangle(Vec3 origin, Vec3 u, Vec3 v) { return {ElementKind::kTriangle, origin, u, v, {}}; }
// Towards u x v.
Element disc(Vec3 centre, Vec3 u, Vec3 v) { return {ElementKind::kDisc, centre, u, v, {}}; }
Element box(Vec3 origin, double edge) { return {ElementKind::kBox, origin, {edge, 0, 0}, {0, edge, 0}, {0, 0, edge}}; }

struct Geometry {
  const char* name;
  Element a, b;
  Medium medium = Medium::kClear;
};

const Element kFloor = patch({5, 5, 5}, {kSide, 0, 0}, {0, kSide, 0});  // looks up
const Element kWall = patch({5, 5, 5}, {0, kSide, 0}, {0, 0, kSide});   // looks along +x, from the floor's edge
Element above(double height) { return patch({5, 5, 5 + height}, {0, kSide, 0}, {kSide, 0, 0}); }

std::vector<Geometry> patches_and_boxes() {
  const double cosine = kSide * std::cos(std::numbers::pi / 6), sine = kSide / 2;
  return {{"perpendicular, common edge", kFloor, kWall},
          {"perpendicular, 0.2 voxels apart", kFloor, patch({5, 5, 5.2}, {0, kSide, 0}, {0, 0, kSide})},
          {"perpendicular, unequal, common edge", kFloor, patch({5, 5, 5}, {0, kSide, 0}, {0, 0, 2})},
          {"perpendicular, common corner", patch({5, 15, 5}, {10, 0, 0}, {0, 10, 0}),
           patch({5, 5, 5}, {0, 10, 0}, {0, 0, 10})},
          {"perpendicular, one on the other's middle", kFloor, patch({15, 5, 5}, {0, kSide, 0}, {0, 0, kSide})},
          {"wedge of 30 degrees", kFloor, patch({5, 5, 5}, {0, kSide, 0}, {cosine, 0, sine})},
          {"wedge of 150 degrees", patch({20, 5, 5}, {kSide - 5, 0, 0}, {0, kSide, 0}),
           patch({20, 5, 5}, {0, kSide, 0}, {-0.8 * cosine, 0, 0.8 * sine})},
          {"parallel, 0.2 voxels apart", kFloor, above(0.2)},
          {"parallel, 4 apart", kFloor, above(4)},
          {"parallel, 20 apart", kFloor, above(20)},
          {"oblique", kFloor, patch({12, 8, 8}, {-1, 14, 4}, {12, 3, 6})},
          {"small above large", kFloor, patch({14, 14, 5.5}, {0, 2, 0}, {2, 0, 0})},
          {"small and far", patch({5, 5, 5}, {2, 0, 0}, {0, 2, 0}), patch({30, 25, 30}, {0, 2, 0}, {2, 0, 0})},
          {"boxes with a common face", box({5, 5, 5}, 2), box({7, 5, 5}, 2)},
          {"box on a patch", kFloor, box({14, 14, 5}, 2)},
          {"perpendicular, common edge, thin medium", kFloor, kWall, Medium::kThin},
          {"parallel, 20 apart, thick medium", kFloor, above(20), Medium::kThick},
          {"parallel, 0.2 apart, thick medium", kFloor, above(0.2), Medium::kThick},
          {"parallel, 20 apart, screen", kFloor, above(20), Medium::kScreen},
          {"perpendicular, common edge, screen", kFloor, kWall, Medium::kScreen}};
}

std::vector<Geometry> discs_and_triangles() {
  return {
      {"discs, 20 apart", disc({20, 20, 5}, {10, 0, 0}, {0, 10, 0}), disc({20, 20, 25}, {0, 10, 0}, {10, 0, 0})},
      {"discs, 0.5 apart", disc({20, 20, 5}, {10, 0, 0}, {0, 10, 0}), disc({22, 20, 5.5}, {0, 8, 0}, {8, 0, 0})},
      {"disc on the floor's edge", kFloor, disc({5, 15, 15}, {0, 10, 0}, {0, 0, 10})},
      {"disc that crosses the floor", kFloor, disc({15, 15, 7}, {0, 6, 0}, {0, 0, 6})},
      {"disc and triangle, thin medium", disc({15, 15, 5}, {10, 0, 0}, {0, 10, 0}),
       triangle({5, 5, 5}, {0, kSide, 0}, {0, 0, kSide}), Medium::kThin},
      {"disc and floor, screen", kFloor, disc({15, 15, 20}, {0, 10, 0}, {10, 0, 0}), Medium::kScreen},
      {"triangles with a common edge", triangle({5, 5, 5}, {kSide, 0, 0}, {0, kSide, 0}),
       triangle({5, 5, 5}, {0, kSide, 0}, {0, 0, kSide})},
      {"triangles with a common corner", triangle({5, 5, 5}, {kSide, 0, 0}, {0, kSide, 0}),
       triangle({5, 5, 5}, {-4, 8, 15}, {8, -4, 15})},
      {"triangle above the floor, screen", kFloor, triangle({5, 5, 18}, {0, kSide, 0}, {kSide, 0, 2}), Medium::kScreen},
      {"box on a disc", disc({15, 15, 5}, {10, 0, 0}, {0, 10, 0}), box({14, 14, 5}, 2)}};
}

Vec3 point_of(const Element& element, double s, double t, double r) {
  if (element.kind == ElementKind::kTriangle) {  // (s, t, 1 - s - t) evenly: Turk 1990
    const double root = std::sqrt(s);
    return element.origin + root * (1 - t) * element.u + root * t * element.v;
  }
  if (element.kind == ElementKind::kDisc) {
    const double radius = std::sqrt(s), angle = 2 * std::numbers::pi * t;
    return element.origin + radius * std::cos(angle) * element.u + radius * std::sin(angle) * element.v;
  }
  const Vec3 point = element.origin + s * element.u + t * element.v;
  return element.kind == ElementKind::kBox ? point + r * element.w : point;
}

// The part of a ray that is in the element: of a patch a point, seen from its front.
struct Part {
  double begin = 0, end = -1;
};
Part hit(const Element& element, Vec3 from, Vec3 way) {
  if (element.kind != ElementKind::kBox) {
    const Vec3 normal = cross(element.u, element.v), to = element.origin - from;
    if (dot(normal, way) >= 0) return {};
    const double t = dot(normal, to) / dot(normal, way);
    const Vec3 at = t * way - to;
    const double square = dot(normal, normal);
    const double u = dot(normal, cross(at, element.v)) / square, v = dot(normal, cross(element.u, at)) / square;
    const bool met = element.kind == ElementKind::kDisc       ? u * u + v * v <= 1
                     : element.kind == ElementKind::kTriangle ? u >= 0 && v >= 0 && u + v <= 1
                                                              : u >= 0 && u <= 1 && v >= 0 && v <= 1;
    return t > 0 && met ? Part{t, t} : Part{};
  }
  Part part{0, 1e9};
  for (const auto& [edge, axis] :
       {std::pair{element.u.x, &Vec3::x}, {element.v.y, &Vec3::y}, {element.w.z, &Vec3::z}}) {
    double near = (element.origin.*axis - from.*axis) / (way.*axis), far = near + edge / (way.*axis);
    if (near > far) std::swap(near, far);
    part.begin = std::max(part.begin, near), part.end = std::min(part.end, far);
  }
  return part.begin < part.end ? part : Part{};
}

double measure(const Element& e) {
  const double across = length(cross(e.u, e.v));
  switch (e.kind) {
    case ElementKind::kBox: return std::abs(dot(cross(e.u, e.v), e.w));
    case ElementKind::kTriangle: return across / 2;
    case ElementKind::kDisc: return std::numbers::pi * across;
    default: return across;
  }
}

// PairFactor::transported by points of `a` and directions from a patch by Lambert's law, or from a box all alike: the
// points lie in five dimensions as the powers of the golden ratio's generalisation (phi^6 = phi + 1).
double reference_of(const Geometry& geometry) {
  constexpr int kPoints = 1 << 22;
  // The smaller one looks: more of its directions meet the other.
  const bool first = measure(geometry.a) <= measure(geometry.b);
  const Element &a = first ? geometry.a : geometry.b, &b = first ? geometry.b : geometry.a;
  const bool from_patch = a.kind != ElementKind::kBox;
  const Vec3 z = normalise(cross(a.u, a.v)), x = normalise(a.u), y = cross(z, x);
  std::array<double, 6> at{}, step{};
  for (std::size_t d = 0; d < step.size(); ++d) step[d] = std::pow(1.1347241384015194, -(static_cast<double>(d) + 1));
  step[5] = std::numbers::sqrt2 - 1;
  double sum = 0;
  for (int i = 0; i < kPoints; ++i) {
    for (std::size_t d = 0; d < at.size(); ++d) at[d] += step[d], at[d] -= at[d] >= 1 ? 1 : 0;
    const Vec3 from = point_of(a, at[0], at[1], at[4]);
    const double height = from_patch ? std::sqrt(1 - at[2]) : 1 - 2 * at[2], around = 2 * std::numbers::pi * at[3];
    const double flat = std::sqrt(1 - height * height);
    const Vec3 way = (flat * std::cos(around)) * x + (flat * std::sin(around)) * y + height * z;
    const Part part = hit(b, from, way);
    if (part.end < part.begin) continue;
    // Of directions there are pi by Lambert's law, else 4 pi; and of a box all the way through it counts.
    const double through = b.kind == ElementKind::kBox ? part.end - part.begin : 1;
    const Vec3 to = from + std::lerp(part.begin, part.end, at[5]) * way;
    sum += (from_patch ? 1 : 4) * through * transmittance(geometry.medium, from, to);
  }
  return sum / kPoints / measure(b);
}

// Beyond three standard errors, of so many pairs; the board's rounding aside.
int beyond_three(Board& board, const Geometry& geometry, double truth, std::uint32_t rays, std::uint32_t runs) {
  std::vector<ElementPair> pairs;
  for (std::uint32_t run = 0; run < runs; ++run) pairs.push_back({0, 1, run});
  const auto factors = board.pair_factors(std::array{geometry.a, geometry.b}, pairs, {.rays = rays, .seed = 3});
  double squares = 0, said = 0;
  const auto count = std::count_if(factors.begin(), factors.end(), [&](const PairFactor& factor) {
    const double off = std::abs(factor.transported - truth);
    squares += off * off, said += factor.standard_error;
    return off > 3 * factor.standard_error + 0.005 * truth;
  });
  testing::Test::RecordProperty(std::string(geometry.name) + " " + std::to_string(rays),
                                std::to_string(truth) + " off " + std::to_string(std::sqrt(squares / runs) / truth) +
                                    " said " + std::to_string(said / runs / truth) + " beyond " +
                                    std::to_string(count));
  return static_cast<int>(count);
}

void expect_at_most_one_of_a_hundred_beyond_three(const std::vector<Geometry>& geometries) {
  Board board = Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64");
  for (const Geometry& geometry : geometries) {
    fill(board, geometry.medium);
    const double truth = reference_of(geometry);
    EXPECT_LE(beyond_three(board, geometry, truth, 8, 1000), 10) << geometry.name;
    EXPECT_LE(beyond_three(board, geometry, truth, 16, 1000), 10) << geometry.name;
    EXPECT_LE(beyond_three(board, geometry, truth, 64, 1000), 10) << geometry.name;
    EXPECT_LE(beyond_three(board, geometry, truth, 1024, 200), 2) << geometry.name;
  }
}

TEST(PairErrors, OfPatchesAndBoxesAtMostOneOfAHundredIsBeyondThree) {
  expect_at_most_one_of_a_hundred_beyond_three(patches_and_boxes());
}
TEST(PairErrors, OfDiscsAndTrianglesAtMostOneOfAHundredIsBeyondThree) {
  expect_at_most_one_of_a_hundred_beyond_three(discs_and_triangles());
}

TEST(PairErrors, FallWithMoreRays) {
  Board board = Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64");
  fill(board, Medium::kThin);
  for (const Element& other : {kWall, above(20)}) {
    double before = 1e9;
    for (const std::uint32_t rays : {8u, 128u, 2048u, 32'768u}) {
      const auto factor =
          board.pair_factors(std::array{kFloor, other}, std::array{ElementPair{0, 1, 0}}, {.rays = rays})[0];
      EXPECT_LT(factor.standard_error, 0.6 * before) << rays;
      before = factor.standard_error;
    }
    EXPECT_LT(before, 2e-5);
  }
}

}  // namespace
}  // namespace gicube
