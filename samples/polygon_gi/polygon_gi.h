// Radiosity between polygons with a participating medium between them: the zonal method (Hottel and Sarofim 1967; Rushmeier and Torrance
// 1987). Elements are the two sides of each triangle and cubes of the medium, its zones.
//
// An element's row says where light goes that it sends out: rays that leave its side by Lambert's law, or a zone evenly, end at the
// nearest triangle (Embree), or before it in the medium, where the opacity that the board has gathered reaches an even random number
// (transport/flights.h). The shares of rays are the form factors, attenuated by the medium, and the exchange with its zones; with what
// escapes they add up to one. By reciprocity they are the shares of what an element gathers, too:
//
//   B = E + albedo H,   H_i = direct_i + sum over j of row_i[j] (B_j - E_j)
//
// B is radiosity, pi times the radiance of an even element. Light straight from emitters, which may be small, is that of rays which meet
// one and of visibility rays to points on them, by the balance heuristic (Veach and Guibas 1995).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "meshes/mesh_caster.h"
#include "meshes/scene_polygons.h"
#include "transport/eye.h"
#include "transport/flights.h"
#include "transport/radiance.h"
#include "transport/zones.h"

namespace gicube::samples {

struct PolygonGiSettings {
  int rays = 400;             // of a row
  int lamp_rays = 32;         // of a row, to emitters
  int zone = 4;               // voxels an edge
  double convergence = 1e-4;  // of a solution: the greatest change of a radiosity over the greatest radiosity
  double step = 0.5;          // voxels between the board's samples
  std::uint64_t seed = 0;
};

// One side of a triangle, or a zone.
struct GiElement {
  std::uint32_t surface = 0, triangle = 0;  // of a side; of a zone `triangle` is its index
  bool back = false, zone = false;
  bool dark = false;  // the back of a closed surface: within a solid
  double weight = 0;  // area, or 4 times the extinction's integral over the zone; solve() leaves out what is in solids
  Rgb albedo{}, emission{};
};

struct PolygonGiStatistics {
  std::uint64_t sides = 0, zones = 0, rays = 0;
  int iterations = 0;
  Rgb emitted{}, absorbed_by_surfaces{}, absorbed_by_medium{},
      escaped{};  // power; they add up but for the noise of rows
};

class PolygonGi {
 public:
  struct Row {
    std::vector<std::pair<std::uint32_t, float>> shares;  // of elements
    Rgb direct{};                                         // straight from emitters
    double outside = 1;                                   // the share of the element that is in no solid
  };

  // Surfaces in the medium's space (transport/medium.h), as fine as light is to be. All must outlive it. Throws InputError: a medium
  // with solids, or that does not scatter evenly.
  PolygonGi(Board& board, const Medium& medium, std::vector<PolygonSurface> surfaces,
            const PolygonGiSettings& settings);

  // All rows, and the solution.
  void solve(const Progress& told = {});
  // What is seen: this many rays for each pixel, ended as those of rows; radiosities are interpolated between triangles, and zones.
  RadiancePicture picture(const View& view, int rays);

  const std::vector<GiElement>& elements() const { return elements_; }
  const std::vector<Rgb>& radiosity() const { return radiosity_; }  // by element, after solve()
  const std::vector<Rgb>& incident() const { return incident_; }
  // By rays; the medium's chances depend on which rows are made together, and after which.
  std::vector<Row> rows(std::span<const std::uint32_t> of);
  PolygonGiStatistics statistics() const { return statistics_; }

 private:
  static constexpr std::uint32_t kNoElement = 0xFFFF'FFFF;
  static constexpr std::size_t kFlightsAtOnce = 1 << 17;  // chosen: some 30 MB
  struct End {
    std::optional<std::uint32_t> element;  // none: it has escaped
    Vec3 place{};
    bool in_solid = false;  // the ray began in one
  };
  void check(Vec3 place) const;
  void add_zones();
  std::vector<End> ends(std::span<const Flight> flights);
  Flight start(const GiElement& element, int ray, const std::array<double, 2>& shift, PathRandom& random) const;
  Vec3 normal(const GiElement& element) const;  // out of the side
  // Of a ray's direction from an element, per solid angle: what it gathers by, too.
  double density(const GiElement& element, Vec3 direction) const;
  void add_direct(std::span<const std::uint32_t> of, std::span<const Flight> flights, std::span<const End> ends,
                  std::span<const double> weights, std::span<Row> rows);
  void iterate();
  void account();
  void spread();
  Rgb seen(const End& end) const;

  const Medium& medium_;
  std::vector<PolygonSurface> surfaces_;
  PolygonGiSettings settings_;
  Flights flights_;
  MeshCaster caster_;
  std::vector<std::uint32_t> lamps_;  // elements
  std::vector<double> chances_;       // running sums of their powers
  std::vector<std::uint32_t> first_;  // of each surface's elements
  std::vector<GiElement> elements_;
  Zones zones_;
  std::vector<std::uint32_t> zone_of_;  // element by zone
  std::vector<Row> rows_;
  std::vector<Rgb> radiosity_, incident_;
  std::vector<std::array<Rgb, 3>> at_corners_;  // of sides: what they reflect, between them and their neighbours
  PolygonGiStatistics statistics_;
};

}  // namespace gicube::samples
