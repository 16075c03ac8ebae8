#include "subsurface/profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gicube::samples {
namespace {

constexpr std::size_t kAtOnce = 1 << 16;  // chosen: photons of a batch
constexpr double kRouletteBelow = 0.1;    // chosen: of a photon's weight

struct Photon {
  Flight flight;
  Vec3 entry;
  Rgb weight{1, 1, 1};
  PathRandom random{0, 0};
};

class Measurement {
 public:
  Measurement(Board& board, const Medium& medium, const ProfileSettings& settings)
      : medium_(medium), settings_(settings), flights_(board, medium, settings.step, settings.seed) {
    const Dims& dims = medium.dims();
    top_ = medium.place_of({dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0});
    const double radius = settings.radius > 0 ? settings.radius : std::min(top_.x, top_.y) / 4;
    for (int k = 0; k < settings.rings; ++k) {
      const auto edge = [&](int i) { return radius * std::pow(static_cast<double>(i) / settings.rings, 2); };
      profile_.rings.push_back({edge(k), edge(k + 1), {}, {}});
    }
  }

  Profile run() {
    for (std::uint64_t first = 0; first < settings_.photons; first += kAtOnce) {
      std::vector<Photon> photons;
      for (std::uint64_t i = first; i < std::min<std::uint64_t>(settings_.photons, first + kAtOnce); ++i)
        photons.push_back(sent(i));
      fly(std::move(photons));
    }
    const auto n = static_cast<double>(settings_.photons);
    const auto mean = [&](Rgb& sum, Rgb& squares) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum[c] /= n;
        squares[c] = std::sqrt(std::max(0.0, squares[c] / n - sum[c] * sum[c]) / n);
      }
    };
    for (Profile::Ring& ring : profile_.rings) mean(ring.share, ring.error);
    mean(profile_.reflected, profile_.reflected_error);
    mean(profile_.transmitted, profile_.transmitted_error);
    mean(profile_.sideways, profile_.sideways_error);
    profile_.photons = settings_.photons;
    profile_.rays = flights_.rays();
    return std::move(profile_);
  }

 private:
  Photon sent(std::uint64_t i) const {
    Photon out;
    out.random = {settings_.seed, i};
    const double x = out.random.uniform(), y = out.random.uniform();
    out.entry = {top_.x * (0.25 + 0.5 * x), top_.y * (0.25 + 0.5 * y), top_.z};
    const double squared = settings_.straight ? 0 : out.random.uniform(), ring = std::sqrt(squared);
    const double turn = 2 * std::numbers::pi * out.random.uniform();
    out.flight = {out.entry, {ring * std::cos(turn), ring * std::sin(turn), -std::sqrt(1 - squared)}};
    return out;
  }

  void fly(std::vector<Photon> photons) {
    for (int i = 0; i < settings_.max_scatterings && !photons.empty(); ++i) {
      std::vector<Flight> flights;
      for (const Photon& photon : photons) flights.push_back(photon.flight);
      const auto hits = flights_.first_hits(flights);
      std::size_t kept = 0;
      for (std::size_t k = 0; k < photons.size(); ++k) {
        if (hits[k] ? scattered(photons[k], *hits[k]) : left(photons[k])) photons[kept++] = photons[k];
      }
      photons.resize(kept);
    }
  }

  bool scattered(Photon& photon, const Hit& hit) const {
    const Optics& optics = medium_.optics(hit.tag);
    for (std::size_t c = 0; c < 3; ++c) photon.weight[c] *= optics.albedo[c];
    const double survives = std::min(1.0, std::ranges::max(photon.weight) / kRouletteBelow);
    if (photon.random.uniform() >= survives) return false;
    for (double& part : photon.weight) part /= survives;
    photon.flight = {hit.place, scatter(optics, photon.flight.direction, hit.normal, photon.random)};
    return true;
  }

  bool left(const Photon& photon) {
    const Medium::Span span = medium_.inside(photon.flight.place, photon.flight.direction);
    const Vec3 place = photon.flight.place + std::max(0.0, span.end) * photon.flight.direction;
    constexpr double kOnFace = 1e-6;
    const auto add = [&](Rgb& sum, Rgb& squares) {
      for (std::size_t c = 0; c < 3; ++c) {
        sum[c] += photon.weight[c];
        squares[c] += photon.weight[c] * photon.weight[c];
      }
    };
    if (place.z > top_.z - kOnFace) {
      add(profile_.reflected, profile_.reflected_error);
      const double radius = length(place - photon.entry);
      const auto ring = std::ranges::upper_bound(profile_.rings, radius, {}, &Profile::Ring::outer);
      if (ring != profile_.rings.end()) add(ring->share, ring->error);
    } else if (place.z < kOnFace) {
      add(profile_.transmitted, profile_.transmitted_error);
    } else {
      add(profile_.sideways, profile_.sideways_error);
    }
    return false;
  }

  const Medium& medium_;
  const ProfileSettings& settings_;
  Flights flights_;
  Vec3 top_;
  Profile profile_;
};

double area(const Profile::Ring& ring) {
  return std::numbers::pi * (ring.outer * ring.outer - ring.inner * ring.inner);
}

}  // namespace

Profile measure_profile(Board& board, const Medium& medium, const ProfileSettings& settings) {
  return Measurement(board, medium, settings).run();
}

Rgb Profile::at(double radius) const {
  if (rings.empty() || radius >= rings.back().outer) return {};
  const auto middle = [](const Ring& ring) { return (ring.inner + ring.outer) / 2; };
  const auto next = std::ranges::upper_bound(rings, radius, {}, middle);
  const Ring& after = next == rings.end() ? rings.back() : *next;
  const Ring& before = next == rings.begin() ? after : *(next - 1);
  const double apart = middle(after) - middle(before);
  const double way = apart > 0 ? std::clamp((radius - middle(before)) / apart, 0.0, 1.0) : 0;
  Rgb out{};
  for (std::size_t c = 0; c < 3; ++c)
    out[c] = (1 - way) * before.share[c] / area(before) + way * after.share[c] / area(after);
  return out;
}

Rgb Profile::within(double radius) const {
  Rgb out{};
  for (const Ring& ring : rings) {
    const double reach = std::clamp(radius, ring.inner, ring.outer);
    const double part = (reach * reach - ring.inner * ring.inner) / (ring.outer * ring.outer - ring.inner * ring.inner);
    for (std::size_t c = 0; c < 3; ++c) out[c] += part * ring.share[c];
  }
  return out;
}

// With s the reduced scattering, t the reduced extinction and D = 1 / 3t: a source at the depth 1/t, its image at -(1/t + 4D), A = 1.
double dipole(double extinction, double albedo, double g, double radius) {
  const double scattering = (1 - g) * albedo * extinction, absorption = (1 - albedo) * extinction;
  const double reduced = scattering + absorption, fall = std::sqrt(3 * absorption * reduced);
  const double depth = 1 / reduced, image = depth + 4 / (3 * reduced);
  const auto source = [&](double z) {
    const double d = std::sqrt(radius * radius + z * z);
    return z * (fall * d + 1) * std::exp(-fall * d) / (d * d * d);
  };
  return scattering / reduced / (4 * std::numbers::pi) * (source(depth) + source(image));
}

double dipole_reflected(double albedo, double g) {
  const double reduced = (1 - g) * albedo / ((1 - g) * albedo + 1 - albedo), fall = std::sqrt(3 * (1 - reduced));
  return reduced / 2 * (1 + std::exp(-4.0 / 3 * fall)) * std::exp(-fall);
}

}  // namespace gicube::samples
