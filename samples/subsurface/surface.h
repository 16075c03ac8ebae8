// A mesh whose light goes beneath it by a measured profile: R(r), the share of what falls on one place that comes out of a unit of area at
// the distance r (Jensen and Buhler 2002).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "meshes/corner_means.h"
#include "meshes/mesh_caster.h"
#include "meshes/scene_polygons.h"
#include "subsurface/profile.h"
#include "transport/eye.h"
#include "transport/lights.h"
#include "transport/radiance.h"

namespace gicube::samples {

// Power that falls on a unit of area, by triangle.
using Irradiance = std::vector<Rgb>;

// What leaves a unit of area of each triangle: of the light on all triangles nearer than the profile's radius; `scale`: the mesh's lengths of
// one of the profile's. Light on a triangle itself comes out within a disc of its area.
std::vector<Rgb> spread_beneath(const Mesh& mesh, const Irradiance& irradiance, const Profile& profile, double scale);

// Meshes in the light of lamps, one of them with a profile, the others diffuse.
class SubsurfacePicture {
 public:
  // `surfaces` in the medium's space, of triangles that are small beside the profile. Shadows are hard but for lamps with an area;
  // light goes from lamps to surfaces alone. All must outlive it.
  SubsurfacePicture(const Medium& medium, const Lights& lights, std::vector<PolygonSurface> surfaces,
                    const Profile& profile, std::size_t with_profile, double scale, int lamp_rays, std::uint64_t seed);

  RadiancePicture picture(const View& view, int rays) const;
  const Irradiance& irradiance(std::size_t surface) const { return irradiance_[surface]; }

 private:
  Irradiance lit(std::size_t surface, int lamp_rays) const;

  const Medium& medium_;
  const Lights& lights_;
  std::vector<PolygonSurface> surfaces_;
  MeshCaster caster_;
  std::uint64_t seed_;
  std::vector<Irradiance> irradiance_;
  std::vector<std::vector<std::array<Rgb, 3>>> radiosity_;  // at corners
};

}  // namespace gicube::samples
