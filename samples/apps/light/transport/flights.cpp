#include "light/transport/flights.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gicube::samples {
namespace {

constexpr std::size_t kCommands = 64, kRaysOfOne = 32;  // chosen: most commands of a batch, fewest rays of a command
constexpr double kOff = 0.02;   // chosen: distance from a surface, edges; the board's positions have 1/16384 voxel
constexpr double kFine = 0.05;  // chosen: distance of the host's own samples in the skin of glass, edges

}  // namespace

Vec3 off_surface(const Hit& hit, Vec3 direction) {
  return hit.place + (dot(hit.normal, direction) < 0 ? -kOff : kOff) * hit.normal;
}

std::optional<Flights::Line> Flights::line_of(const Flight& flight, std::size_t index, double begin) const {
  const Medium::Span span = medium_.inside(flight.place, flight.direction);
  Line line{index, flight.place, flight.direction, std::max(span.begin, begin), span.end, 0, flight.in_glass};
  if (!(line.begin < line.end)) return std::nullopt;
  line.length = step_ / length(medium_.voxel_of(flight.direction));
  return line;
}

// A sample is in the middle of its step, so the first is half a step from the beginning of the line.
Ticket Flights::send(std::span<const Line> lines, double opacity) {
  std::vector<HostRay> sent;
  const Dims& dims = medium_.dims();
  for (const Line& line : lines) {
    const double first = std::min(line.begin + line.length / 2, line.end);
    const Vec3 v = medium_.voxel_of(line.at(first));
    const Vec3 held{std::clamp(v.x, 0.0, dims[0] - 1.0), std::clamp(v.y, 0.0, dims[1] - 1.0),
                    std::clamp(v.z, 0.0, dims[2] - 1.0)};
    sent.push_back({static_cast<std::uint32_t>(sent.size()), held, medium_.voxel_of(line.direction)});
  }
  rays_ += sent.size();
  return board_.submit(sent, {.type = RayType::kFirstHit, .opacity = opacity, .step = step_});
}

// The surface between a distance outside of solids and a later one, if that is in a solid.
std::optional<Hit> Flights::surface_between(const Line& line, double before, double after) const {
  constexpr int kHalvings = 20;
  const auto tag = medium_.solid(line.at(after));
  if (!tag) return std::nullopt;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (before + after) / 2;
    (medium_.solid(line.at(middle)) ? after : before) = middle;
  }
  const Vec3 place = line.at(after);
  const Vec3 normal = medium_.normal(place);
  return Hit{place, after, medium_.solid(place).value_or(*tag), normal == Vec3{} ? -1.0 * line.direction : normal};
}

// The board's ray ends at or before the line's own end, since `opacity` is at most the line's. The host marches on.
std::optional<Hit> Flights::hit_of(const Line& line, const TracedRay& ray, double opacity) const {
  const double first = line.begin + line.length / 2, steps = (line.end - line.begin) / line.length;
  double begin = line.begin + std::floor(steps + 0.5) * line.length, clear = begin;
  double before =
      begin == line.begin ? 0 : ray.opacity;  // up to `begin`, which a single sample of less than half a step is not
  if (ray.opacity >= opacity) {
    const double index = std::round(dot(medium_.place_of(ray.position) - line.at(first), line.direction) / line.length);
    clear = first + std::clamp(index, 0.0, std::floor(steps)) * line.length;
    // The board's sample is a little off the line, so the solid that it hit may begin later on the line.
    for (double after = clear; after <= clear + line.length; after += line.length / 8) {
      if (const auto hit = surface_between(line, std::max(line.begin, clear - line.length), after)) return hit;
      if (ray.opacity < 1) break;
    }
    begin = clear - line.length / 2;
    before = 1 - (1 - ray.opacity) * std::exp(medium_.extinction(line.at(clear)) * line.length);
  }
  double depth = std::log((1 - std::clamp(before, 0.0, std::min(opacity, line.opacity))) / (1 - line.opacity));
  for (; begin < line.end; begin += line.length) {
    const double length = std::min(line.length, line.end - begin), middle = begin + length / 2;
    const double kappa = medium_.extinction(line.at(middle));
    const bool ends = kappa > 0 && depth <= kappa * length;
    const double distance = ends ? begin + depth / kappa : begin + length;
    for (const double after : {std::min(middle, distance), distance}) {
      if (after <= clear) continue;
      if (const auto hit = surface_between(line, clear, after)) return hit;
      clear = after;
    }
    if (ends) {
      const Vec3 place = line.at(distance);
      const int tag = medium_.tag(place);  // beside a solid it may be the solid's, though the place is outside of it
      const bool medium = medium_.optics(tag).look == Look::kMedium;
      return Hit{place, distance, medium ? tag : medium_.tag(line.at(middle)), {}};
    }
    depth -= kappa * length;
  }
  return std::nullopt;
}

// The host marches through the skin of glass, the board traces the body beneath.
void Flights::leave_glass(std::vector<Line> lines, std::vector<std::optional<Hit>>& hits) {
  constexpr int kMaxRounds = 64;  // a ray that grazes the skin comes back to it
  constexpr double kHalf = 0.5;
  for (int round = 0; round < kMaxRounds && !lines.empty(); ++round) {
    std::vector<Line> through;
    for (Line& line : lines) {
      for (bool walks = true; walks;) {
        const double next = std::min(line.begin + kFine, line.end);
        if (!medium_.solid(line.at(next))) {  // bisection for the surface, from the inside
          double within = line.begin, outside = next;
          for (int i = 0; i < 20; ++i) {
            const double middle = (within + outside) / 2;
            (medium_.solid(line.at(middle)) ? within : outside) = middle;
          }
          const Vec3 place = line.at(within), normal = medium_.normal(place);
          hits[line.index] = Hit{place, within, medium_.tag(place), normal == Vec3{} ? line.direction : normal};
          walks = false;
        } else if (medium_.in_body(line.at(next))) {
          line.begin = next;
          through.push_back(line);
          walks = false;
        } else {
          line.begin = next;
          walks = next < line.end;
        }
      }
    }
    std::vector<TracedRay> rays(through.size());
    if (!through.empty()) board_.receive(send(through, kHalf), rays);
    lines.clear();
    for (std::size_t i = 0; i < through.size(); ++i) {
      if (rays[i].opacity < kHalf) continue;  // through the volume's face
      Line line = through[i];
      const double met = dot(medium_.place_of(rays[i].position) - line.place, line.direction);
      line.begin = std::max(line.begin, met - kFine);
      if (line.begin < line.end) lines.push_back(line);
    }
  }
}

std::vector<std::optional<Hit>> Flights::first_hits(std::span<const Flight> flights) {
  std::vector<std::optional<Hit>> hits(flights.size());
  std::vector<Line> free, in_glass;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const auto line = line_of(flights[i], i, 0);
    if (line) (line->in_glass ? in_glass : free).push_back(*line);
  }
  PathRandom random(seed_ ^ 0xF11687, batches_++);
  for (std::size_t i = free.size(); i > 1; --i) {  // Fisher and Yates
    std::swap(free[i - 1], free[static_cast<std::size_t>(random.uniform() * static_cast<double>(i))]);
  }
  for (std::size_t i = 0; i < free.size(); ++i) {  // one number in each of as many equal strata
    free[i].opacity = (static_cast<double>(i) + random.uniform()) / static_cast<double>(free.size());
  }
  struct Command {
    std::span<const Line> lines;
    double opacity = 0;  // at most that of each of its lines
    Ticket ticket;
  };
  std::vector<Command> commands;
  const std::size_t count = std::min(kCommands, (free.size() + kRaysOfOne - 1) / kRaysOfOne);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t from = free.size() * k / count, to = free.size() * (k + 1) / count;
    constexpr double kOne = (1 << 24) - 1;  // the board's opacities
    const double least = static_cast<double>(from) / static_cast<double>(free.size());
    Command& made = commands.emplace_back(
        Command{std::span<const Line>(free).subspan(from, to - from), (std::floor(least * kOne) + 0.5) / kOne, {}});
    made.ticket = send(made.lines, made.opacity);
  }
  for (const Command& command : commands) {
    const RayBatch batch = board_.receive(command.ticket);
    for (std::size_t i = 0; i < command.lines.size(); ++i) {
      hits[command.lines[i].index] = hit_of(command.lines[i], batch.rays[i], command.opacity);
    }
  }
  leave_glass(std::move(in_glass), hits);
  return hits;
}

std::vector<double> Flights::transmittances(std::span<const Segment> segments) {
  std::vector<double> out(segments.size(), 1);
  std::vector<HostRay> rays;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const HostRay whole = ray_between(static_cast<std::uint32_t>(i), medium_.voxel_of(segments[i].from),
                                      medium_.voxel_of(segments[i].to));
    if (const auto part = clip_to_volume(whole, medium_.dims())) rays.push_back(*part);
  }
  rays_ += rays.size();
  if (rays.empty()) return out;
  std::vector<TracedRay> traced(rays.size());
  board_.receive(board_.submit(rays, {.type = RayType::kOpacity, .step = step_}), traced);
  for (const TracedRay& ray : traced) out[ray.id] = 1 - ray.opacity;
  return out;
}

}  // namespace gicube::samples
