#include "light/path/bidirectional.h"

#include <algorithm>
#include <cmath>

namespace gicube::samples {
namespace {

constexpr std::size_t kPathsAtOnce = 32768;  // chosen: vertices and connections take about 100 MB

bool is_dark(const Rgb& colour) { return !(std::ranges::max(colour) > 0); }

}  // namespace

Bidirectional::Bidirectional(Board& board, const Medium& medium, const Lights& lights, const View& view,
                             const BidirectionalSettings& settings)
    : medium_(medium),
      lights_(lights),
      eye_(view, medium),
      settings_(settings),
      flights_(board, medium, settings.step, settings.seed),
      paths_(medium, lights, flights_),
      sum_(view.width, view.height) {}

double Bidirectional::density_of(const Vertex& at, Vec3 came, Vec3 goes) const {
  return density(medium_.optics(at.tag), came, at.normal, goes);
}

Rgb Bidirectional::scattered(const Vertex& vertex, Vec3 out) const {
  return product(vertex.weight, medium_.optics(vertex.tag).albedo, density_of(vertex, vertex.direction, out));
}

// Weight of the balance heuristic: the density of the strategy that takes the first `s` vertices from the light, over
// the sum of the densities of all strategies for the path.
double Bidirectional::balance(const std::vector<Node>& nodes, std::size_t s, bool area_light) const {
  const auto allowed = [&](std::size_t from_light) {
    const std::size_t from_eye = nodes.size() - from_light;
    if (from_light > static_cast<std::size_t>(settings_.light_scatterings) + 1) return false;
    if (from_eye > static_cast<std::size_t>(settings_.max_scatterings) + 1) return false;
    if (from_light == 0)
      return area_light && from_eye > 2;  // the eye's path hits the light by chance, and not with its first segment
    return !nodes[from_light - 1].sharp && !nodes[from_light].sharp;
  };
  const auto or_one = [](double density) { return density > 0 ? density : 1; };
  double sum = 1, ratio = 1;
  for (std::size_t i = s; i + 1 < nodes.size(); ++i) {
    ratio *= or_one(nodes[i].from_light) / or_one(nodes[i].from_eye);
    if (allowed(i + 1)) sum += ratio;
  }
  ratio = 1;
  for (std::size_t i = s; i-- > 0;) {
    ratio *= or_one(nodes[i].from_eye) / or_one(nodes[i].from_light);
    if (allowed(i)) sum += ratio;
  }
  return 1 / sum;
}

// Adds the radiance of area lights that the next segment of an eye's path hits.
void Bidirectional::see(const Path& eye, std::size_t pixel, double reach, std::vector<Rgb>& pixels) const {
  const std::size_t t = eye.vertices.size();
  if (t < 2) return;  // lights are not visible to the eye directly
  const Vec3 direction = eye.flight.direction, back = -1.0 * direction;
  lights_.meet(eye.flight.place, direction, [&](const LightPoint& point, double distance, const Rgb& radiance) {
    if (!(distance < reach)) return;
    const Vertex lamp{.place = point.place, .normal = point.normal};
    std::vector<Node> nodes{{point.density, density_at(eye.density, eye.vertices.back(), lamp), false}};
    for (std::size_t j = t; j-- > 0;)
      nodes.push_back({eye.vertices[j].backward, eye.vertices[j].forward, eye.vertices[j].sharp});
    const Vertex& last = eye.vertices[t - 1];
    nodes[1].from_light = density_at(lights_.emission_density(point, back), lamp, last);
    nodes[2].from_light = density_at(density_of(last, back, -1.0 * last.direction), last, eye.vertices[t - 2]);
    add(pixels[pixel], product(eye.weight, radiance, balance(nodes, 0, true)));
  });
}

void Bidirectional::connect_with_light(const Path& eye, std::size_t t, std::size_t pixel, PathRandom& random,
                                       std::vector<Connection>& out) const {
  const Vertex& last = eye.vertices[t - 1];
  if (last.sharp) return;
  const LightPoint point = lights_.point(random);
  Vertex lamp{.place = point.place, .normal = point.normal, .distant = lights_.is_distant(point.light)};
  if (lamp.distant) lamp.place = last.place + 4 * medium_.radius() * point.place;
  const Vec3 way = lamp.place - last.place, direction = normalise(way), back = -1.0 * direction;
  const double squared = lamp.distant ? 1 : dot(way, way);
  Rgb value = product(scattered(last, direction), lights_.emitted(point, back), 1 / squared);
  if (is_dark(value)) return;
  std::vector<Node> nodes{{point.density, density_at(density_of(last, last.direction, direction), last, lamp), false}};
  for (std::size_t j = t; j-- > 0;)
    nodes.push_back({eye.vertices[j].backward, eye.vertices[j].forward, eye.vertices[j].sharp});
  nodes[1].from_light = density_at(lights_.emission_density(point, back), lamp, last);
  nodes[2].from_light = density_at(density_of(last, back, -1.0 * last.direction), last, eye.vertices[t - 2]);
  const double share = balance(nodes, 1, lights_.has_area(point.light));
  for (double& part : value) part *= share;
  out.push_back({{beside(last, direction), lamp.place}, pixel, value});
}

// Connects the first t vertices of the eye's path with the first s of the light's path, s at least 2.
void Bidirectional::connect(const Path& eye, std::size_t t, const Path& light, std::size_t s, std::size_t pixel,
                            std::vector<Connection>& out) const {
  const Vertex &a = eye.vertices[t - 1], &b = light.vertices[s - 1];
  if (a.sharp || b.sharp) return;
  const Vec3 way = b.place - a.place, direction = normalise(way), back = -1.0 * direction;
  const double squared = dot(way, way);
  if (!(squared > 0)) return;
  Rgb from_eye{};
  double seen = 0;  // density of the direction to b
  if (t == 1) {
    const auto target = eye_.pixel_of(direction);
    if (!target) return;
    pixel = *target;
    seen = eye_.density(direction) / static_cast<double>(sum_.pixels());
    from_eye = {seen, seen, seen};  // over all light paths of the pass
  } else {
    seen = density_of(a, a.direction, direction);
    from_eye = scattered(a, direction);
  }
  Rgb value = product(from_eye, scattered(b, back), 1 / squared);
  if (is_dark(value)) return;
  std::vector<Node> nodes;
  for (std::size_t i = 0; i < s; ++i)
    nodes.push_back({light.vertices[i].forward, light.vertices[i].backward, light.vertices[i].sharp});
  for (std::size_t j = t; j-- > 0;)
    nodes.push_back({eye.vertices[j].backward, eye.vertices[j].forward, eye.vertices[j].sharp});
  nodes[s - 1].from_eye = density_at(seen, a, b);
  nodes[s - 2].from_eye = density_at(density_of(b, direction, -1.0 * b.direction), b, light.vertices[s - 2]);
  nodes[s].from_light = density_at(density_of(b, b.direction, back), b, a);
  if (t > 1) {
    nodes[s + 1].from_light = density_at(density_of(a, back, -1.0 * a.direction), a, eye.vertices[t - 2]);
  }
  const double share = balance(nodes, s, light.vertices[0].normal != Vec3{});
  for (double& part : value) part *= share;
  out.push_back({{beside(a, direction), beside(b, back)}, pixel, value});
}

void Bidirectional::trace(std::size_t first, std::size_t count, std::vector<Rgb>& pixels) {
  std::vector<Path> eyes, lights;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t number = 2 * (sum_.passes() * sum_.pixels() + first + i);
    eyes.push_back(from_eye(eye_, first + i, {settings_.seed, number}));
    if (settings_.light_scatterings > 0) lights.push_back(paths_.from_light({settings_.seed, number + 1}));
  }
  paths_.walk(eyes, settings_.max_scatterings, [&](const Path& path, double reach) {
    see(path, first + static_cast<std::size_t>(&path - eyes.data()), reach, pixels);
  });
  paths_.walk(lights, settings_.light_scatterings);
  std::vector<Connection> connections;
  for (std::size_t i = 0; i < count; ++i) {
    Path& eye = eyes[i];
    for (std::size_t t = 1; t <= eye.vertices.size(); ++t) {
      if (t > 1) connect_with_light(eye, t, first + i, eye.random, connections);
      if (lights.empty()) continue;
      const std::size_t most = static_cast<std::size_t>(settings_.max_scatterings) + 2 - t;
      for (std::size_t s = 2; s <= std::min(lights[i].vertices.size(), most); ++s) {
        connect(eye, t, lights[i], s, first + i, connections);
      }
    }
  }
  std::vector<Segment> segments;
  for (const Connection& connection : connections) segments.push_back(connection.segment);
  const std::vector<double> through = flights_.transmittances(segments);
  for (std::size_t i = 0; i < connections.size(); ++i)
    add(pixels[connections[i].pixel], connections[i].value, through[i]);
  statistics_.paths += count;
  statistics_.connections += connections.size();
}

void Bidirectional::pass() {
  std::vector<Rgb> pixels(sum_.pixels());
  for (std::size_t first = 0; first < pixels.size(); first += kPathsAtOnce) {
    trace(first, std::min(kPathsAtOnce, pixels.size() - first), pixels);
  }
  sum_.add(pixels);
  statistics_.rays = flights_.rays();
}

}  // namespace gicube::samples
