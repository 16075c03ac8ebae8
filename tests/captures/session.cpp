#include "session.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <utility>
#include <vector>

namespace gicube::captures {
namespace {

constexpr int kEdge = 20;

// Lines of a word and numbers. Many numbers are their count, their sum weighted by place, and the first of them.
class Text {
 public:
  void line(const char* name, std::span<const double> numbers) {
    double sum = 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) sum += numbers[i] * static_cast<double>(i % 97 + 1);
    text_ += name;
    add(static_cast<double>(numbers.size()));
    add(sum);
    for (const double number : numbers.first(std::min<std::size_t>(numbers.size(), 8))) add(number);
    text_ += '\n';
  }
  void line(const char* name, std::initializer_list<double> numbers) {
    line(name, std::span(numbers.begin(), numbers.size()));
  }
  void line(const char* name, std::span<const float> numbers) {
    line(name, std::vector<double>(numbers.begin(), numbers.end()));
  }
  void line(const char* name, const std::vector<double>& numbers) { line(name, std::span<const double>(numbers)); }

  std::string take() { return std::move(text_); }

 private:
  // Nine digits: a driver may work out the last bits of a double in another order.
  void add(double number) {
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), " %.9g", number);
    text_ += digits.data();
  }

  std::string text_;
};

// A soft ball about the middle, and a dense corner.
std::vector<std::byte> ball() {
  std::vector<std::byte> samples;
  for (int z = 0; z < kEdge; ++z) {
    for (int y = 0; y < kEdge; ++y) {
      for (int x = 0; x < kEdge; ++x) {
        const int dx = 2 * x - kEdge, dy = 2 * y - kEdge, dz = 2 * z - kEdge, far = dx * dx + dy * dy + dz * dz;
        const bool corner = x < 3 && y < 3 && z < 3;
        samples.push_back(static_cast<std::byte>(corner ? 255 : far < 240 ? 200 - far / 2 : 0));
      }
    }
  }
  return samples;
}

void load(Board& board) {
  const std::vector<std::byte> samples = ball();
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {kEdge, kEdge, kEdge}});
}

View view() {
  View view;
  view.eye = {60, 45, -50};
  view.look_at = {10, 10, 10};
  view.width = 32;
  view.height = 24;
  view.step = 0.5;
  return view;
}

void add(Text& text, const char* name, const Image& image) {
  std::vector<double> words;
  for (const Pixel& pixel : image.pixels) {
    words.insert(words.end(), {static_cast<double>(pixel.red), static_cast<double>(pixel.green),
                               static_cast<double>(pixel.blue), static_cast<double>(pixel.alpha)});
  }
  text.line(name, words);
}

void add(Text& text, const char* name, const RayBatch& batch) {
  std::vector<double> words;
  for (const TracedRay& ray : batch.rays) {
    words.insert(words.end(), {static_cast<double>(ray.id), ray.position.x, ray.position.y, ray.position.z,
                               ray.direction.x, ray.direction.y, ray.direction.z, ray.colour[0], ray.colour[1],
                               ray.colour[2], ray.opacity, ray.integral});
  }
  text.line(name, words);
}

void add(Text& text, const char* name, const LightingReport& report) {
  text.line(name, {static_cast<double>(report.rays), report.emitted, report.deposited, report.escaped,
                   report.scattered_away, report.given_up, report.clipped, report.unit});
}

// Side by side along z, with a length and an energy for the types that want them.
std::vector<HostRay> rays(double energy = 0) {
  std::vector<HostRay> list;
  for (std::uint32_t i = 0; i < 12; ++i) {
    list.push_back(
        {.id = 100 + i, .position = {2.0 + i, 9.5, 1}, .direction = {0, 0.1, 1}, .length = 15, .energy = energy});
  }
  return list;
}

// Version 0.2's driver, which recorded these sessions, sampled rays as the last view.
RayBatch traced(Board& board, RayRequest request, const View& view, double energy = 0) {
  request.sampling = sampling_of(view);
  return board.receive(board.submit(rays(energy), request));
}

// Volume, tables, a picture, rays that gather, and all read back.
std::string picture(Board& board) {
  Text text;
  load(board);
  board.set_transfer_function(
      {.colours = {{0, {1.0, 0.6, 0.3}}, {255, {0.2, 0.5, 1}}}, .opacities = {{60, 0.0}, {180, 0.3}}});
  board.set_shading({.phong = {.ambient = 0.3, .diffuse = 0.5, .specular = 0.2}, .light = {1, 1, -1}});
  add(text, "picture", board.render(view()));
  View cut = view();
  cut.orthographic_height = 30;
  cut.samples_per_axis = 2;
  cut.cut_planes = {{.normal = {0, 0, 1}, .offset = 6}};
  add(text, "cut", board.render(cut));
  add(text, "integrate", traced(board, {.type = RayType::kIntegrate, .step = 0.5}, cut));
  add(text, "first_hit", traced(board, {.type = RayType::kFirstHit, .opacity = 0.25, .step = 0.5}, cut));
  add(text, "segment", traced(board, {.type = RayType::kSegment, .step = 0.5}, cut));
  add(text, "opacity", traced(board, {.type = RayType::kOpacity, .opacity = 0.5, .step = 0.5}, cut));
  add(text, "integral", traced(board, {.type = RayType::kIntegral, .step = 0.5}, cut));
  const std::array<Vec3, 3> points{Vec3{2, 2, 2}, Vec3{10, 12, 9}, Vec3{17, 3, 15}};
  // A polyline of version 0.2, whose legs the driver added up.
  const std::array legs{ray_between(7, points[0], points[1]), ray_between(7, points[1], points[2])};
  RayBatch line = board.receive(board.submit(legs, {.type = RayType::kSegment, .sampling = sampling_of(cut)}));
  const double seen = 1 - line.rays[0].opacity;
  for (std::size_t c = 0; c < 3; ++c) line.rays[1].colour[c] = line.rays[0].colour[c] + seen * line.rays[1].colour[c];
  line.rays[1].opacity = line.rays[0].opacity + seen * line.rays[1].opacity;
  add(text, "polyline", line);
  board.clear_sums(0.001);
  const RayBatch spread = traced(board, {.type = RayType::kBackproject, .step = 0.5}, cut, 0.25);
  text.line("backproject", {static_cast<double>(spread.deposits->rays), static_cast<double>(spread.deposits->samples),
                            spread.deposits->kept, spread.deposits->clipped});
  const VoxelBox box{.low = {1, 4, 2}, .size = {9, 8, 7}};
  text.line("sums", board.read_sums(box));
  text.line("voxels", board.read_volume(box));
  const std::vector<float> fresh(static_cast<std::size_t>(9) * 8 * 7, 99.0F);
  board.write_volume(box, fresh);
  text.line("damaged", {static_cast<double>(board.verify_volume().size())});
  const std::vector<std::uint8_t> flags = board.empty_flags();
  text.line("empty_flags", std::vector<double>(flags.begin(), flags.end()));
  add(text, "written", board.render(view()));
  text.line("polled", {static_cast<double>(board.poll().size())});
  text.line("host_rays", {static_cast<double>(board.counters().value("dsp.host_rays"))});
  return text.take();
}

// Lights, light by rays of the host, light that the application scatters, and pictures lit by it.
std::string light(Board& board) {
  Text text;
  load(board);
  board.set_transfer_function({.colours = {{0, {0.9, 0.9, 0.8}}}, .opacities = {{60, 0.0}, {180, 0.2}}});
  board.set_material({.scattering = 0.5, .bsdf = Bsdf::kIsotropic});
  const std::array<Light, 2> lights{PointLight{.position = {10, 10, -8}, .power = 1},
                                    DirectionalLight{.towards = {1, 1, 0}, .irradiance = 0.01}};
  const Illumination printed{.albedo = Albedo::kLow, .rules = EnergyRules::kAsPrinted, .step = 0.5, .seed = 3};
  add(text, "light", board.illuminate(lights, printed));
  text.line("irradiance", board.read_irradiance());
  View lit = view();
  lit.irradiance = true;
  lit.exposure = 3000;
  add(text, "lit", board.render(lit));

  board.clear_irradiance(0.0001);
  const RayBatch left =
      traced(board, {.type = RayType::kDeposit, .rules = EnergyRules::kAsPrinted, .step = 0.5}, lit, 0.01);
  add(text, "deposit", *left.lighting);
  text.line("deposited", board.read_irradiance());

  board.set_material(
      {.scattering = 0.5, .bsdf = Bsdf::kTrap, .seen_through_scattering = true, .routine = kHostRoutine});
  board.set_scattering_routine([](const ScatterEvent& event) {
    return ScatterAnswer{.direction = {event.direction.y, event.direction.z, event.random[0] - 0.5}, .passes = 0.75};
  });
  const Illumination photons{.albedo = Albedo::kHigh, .rules = EnergyRules::kAsPrinted, .step = 0.5, .seed = 5};
  add(text, "scattered_light", board.illuminate(lights, photons));
  text.line("scattered_irradiance", board.read_irradiance());
  View scattered = view();
  scattered.scatter = true;
  add(text, "scattered", board.render(scattered));
  return text.take();
}

// What 2.2 has beyond 2.0: where light escapes, and pairs whose rays the board makes.
std::string faces_and_pairs(Board& board) {
  Text text;
  load(board);
  board.set_transfer_function({.colours = {{0, {0.9, 0.9, 0.8}}}, .opacities = {{60, 0.0}, {180, 0.2}}});
  const std::array<Light, 1> lights{PointLight{.position = {10, 10, -8}, .power = 1}};
  const LightingReport report = board.illuminate(lights, {.albedo = Albedo::kLow, .seed = 3});
  add(text, "light", report);
  text.line("escaped_by_face", std::vector<double>(report.escaped_by_face.begin(), report.escaped_by_face.end()));
  const RayBatch left = traced(board, {.type = RayType::kDeposit}, View{}, 0.001);
  text.line("deposit_by_face",
            std::vector<double>(left.lighting->escaped_by_face.begin(), left.lighting->escaped_by_face.end()));
  const std::array<Element, 4> elements{
      Element{.kind = ElementKind::kPatch, .origin = {4, 4, 1}, .u = {3, 0, 0}, .v = {0, 3, 0}},
      Element{.kind = ElementKind::kTriangle, .origin = {12, 4, 18}, .u = {0, 4, 0}, .v = {4, 0, 0}},
      Element{.kind = ElementKind::kDisc, .origin = {5, 14, 1}, .u = {2, 0, 0}, .v = {0, 2, 0}, .w = {0.25, 0.5, 0}},
      Element{.kind = ElementKind::kBox, .origin = {8, 8, 16}, .u = {2, 0, 0}, .v = {0, 2, 0}, .w = {0, 0, 2}}};
  const std::array<ElementPair, 4> pairs{ElementPair{0, 1, 1}, ElementPair{0, 3, 2}, ElementPair{2, 1, 3},
                                         ElementPair{2, 3, 4}};
  std::vector<double> factors;
  for (const PairFactor& factor : board.pair_factors(elements, pairs, {.rays = 64, .seed = 5})) {
    factors.insert(factors.end(), {factor.transported, factor.geometric, factor.standard_error});
  }
  text.line("pairs", factors);
  return text.take();
}

// What 2.3 has beyond 2.2 on this board: lamps that scattered rays see, and a volume with more blocks than it stores.
std::string lamps_and_bricks(Board& board) {
  Text text;
  load(board);
  board.set_transfer_function({.colours = {{0, {0.9, 0.9, 0.8}}}, .opacities = {{60, 0.0}, {80, 1.0}}});
  board.set_material({.scattering = 1, .bsdf = Bsdf::kSpecular, .seen_through_scattering = true});
  View mirror = view();
  mirror.scatter = true;
  mirror.lamps = {{SphereLight{{85, 62, -80}, 60, 4 * 3.14159 * 60 * 60}, {0.25, 0.5, 1}}};
  add(text, "mirror", board.render(mirror));

  board.set_material({});
  board.set_transfer_function({.colours = {{0, {0.9, 0.9, 0.8}}}, .opacities = {{60, 0.0}, {180, 0.5}}});
  constexpr Dims kDims{96, 72, 80};  // 1080 blocks, of which the card stores 512; every second one is empty
  std::vector<std::byte> samples;
  for (int z = 0; z < kDims[2]; ++z) {
    for (int y = 0; y < kDims[1]; ++y) {
      for (int x = 0; x < kDims[0]; ++x) {
        const int i = x / 8, j = y / 8, k = z / 8;
        samples.push_back(static_cast<std::byte>((i + j + k) % 2 == 0 ? 60 + (7 * i + 13 * j + 29 * k) % 180 : 0));
      }
    }
  }
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = kDims});
  View whole = view();
  whole.eye = {200, 120, -160};
  whole.look_at = {48, 36, 40};
  add(text, "bricks", board.render(whole));
  add(text, "first_hit", traced(board, {.type = RayType::kFirstHit, .opacity = 0.9, .step = 0.5}, whole));
  const VoxelBox box{.low = {70, 50, 60}, .size = {9, 8, 7}};
  text.line("voxels", board.read_volume(box));
  return text.take();
}

constexpr std::array kSessions{Session{"picture", picture}, Session{"light", light},
                               Session{"faces_and_pairs", faces_and_pairs},
                               Session{"lamps_and_bricks", lamps_and_bricks}};

}  // namespace

std::span<const Session> sessions() { return kSessions; }

}  // namespace gicube::captures
