#include "meshes/mesh_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "gicube/error.h"

namespace gicube::samples {
namespace {

// A fixed instruction set, so that all machines find the same triangles.
constexpr const char* kDevice = "threads=1,isa=sse2";
// chosen: the relative distance of crossings at one edge; Embree's single precision is 6e-8.
constexpr double kSamePlace = 1e-6;
constexpr double kTouching = 1e-6;  // chosen

struct Collector : RTCIntersectContext {
  std::vector<std::pair<std::uint32_t, std::uint32_t>>* found = nullptr;  // mesh, triangle
};

// Records every triangle, and rejects it so that the ray continues.
void collect(const RTCFilterFunctionNArguments* at) {
  auto* collector = static_cast<Collector*>(at->context);
  for (unsigned i = 0; i < at->N; ++i) {
    if (at->valid[i] == 0) continue;
    collector->found->emplace_back(RTCHitN_geomID(at->hit, at->N, i), RTCHitN_primID(at->hit, at->N, i));
    at->valid[i] = 0;
  }
}

}  // namespace

struct MeshCaster::Scene {
  std::vector<Mesh> meshes;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Scene() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }

  Vec3 corner(const Crossing& of, std::size_t which) const {
    const Mesh& mesh = meshes[of.mesh];
    return mesh.points[mesh.triangles[of.triangle][which]];
  }
  // Twice the area long.
  Vec3 area(const Crossing& of) const {
    return gicube::cross(corner(of, 1) - corner(of, 0), corner(of, 2) - corner(of, 0));
  }

  void add(const Mesh& mesh) {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), mesh.points.size()));
    auto* corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
    if (points != nullptr && corners != nullptr) {
      for (const Vec3& p : mesh.points) {
        for (const double part : {p.x, p.y, p.z}) *points++ = static_cast<float>(part);
      }
      for (const auto& triangle : mesh.triangles) corners = std::ranges::copy(triangle, corners).out;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }

  bool neighbours(const Crossing& a, const Crossing& b) const {
    if (a.mesh != b.mesh || a.from_outside != b.from_outside) return false;
    const auto& points = meshes[a.mesh].points;
    const auto& one = meshes[a.mesh].triangles[a.triangle];
    const auto& other = meshes[b.mesh].triangles[b.triangle];
    return std::ranges::any_of(one, [&](auto i) {
      return std::ranges::any_of(other, [&](auto k) { return i == k || points[i] == points[k]; });
    });
  }
};

MeshCaster::MeshCaster(std::vector<Mesh> meshes) : scene_(std::make_unique<Scene>()) {
  scene_->meshes = std::move(meshes);
  scene_->device = rtcNewDevice(kDevice);
  if (scene_->device == nullptr) throw Error("Embree: no device, error " + std::to_string(rtcGetDeviceError(nullptr)));
  scene_->scene = rtcNewScene(scene_->device);
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  for (const Mesh& mesh : scene_->meshes) scene_->add(mesh);
  rtcCommitScene(scene_->scene);
  const RTCError error = rtcGetDeviceError(scene_->device);
  if (error != RTC_ERROR_NONE) throw Error("Embree: error " + std::to_string(error));
}

MeshCaster::~MeshCaster() = default;

const std::vector<Mesh>& MeshCaster::meshes() const { return scene_->meshes; }

Vec3 MeshCaster::normal(const Crossing& crossing) const {
  const Vec3 area = scene_->area(crossing);
  return length(area) > 0 ? normalise(area) : Vec3{};
}

void MeshCaster::meet(Vec3 from, Vec3 direction,
                      std::vector<std::pair<std::uint32_t, std::uint32_t>>& triangles) const {
  triangles.clear();
  Collector collector;
  rtcInitIntersectContext(&collector);
  collector.filter = collect;
  collector.found = &triangles;
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(from.x), ray.ray.org_y = static_cast<float>(from.y);
  ray.ray.org_z = static_cast<float>(from.z);
  ray.ray.dir_x = static_cast<float>(direction.x), ray.ray.dir_y = static_cast<float>(direction.y);
  ray.ray.dir_z = static_cast<float>(direction.z);
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_->scene, &collector, &ray);
}

void MeshCaster::find(Vec3 from, Vec3 direction, std::vector<Crossing>& found) const {
  found.clear();
  thread_local std::vector<std::pair<std::uint32_t, std::uint32_t>> triangles;
  meet(from, direction, triangles);

  for (const auto& [mesh, triangle] : triangles) {
    Crossing crossing{0, mesh, triangle, false};
    const Vec3 area = scene_->area(crossing);
    const double slope = dot(area, direction);
    if (slope == 0) continue;  // seen edge-on
    crossing.distance = dot(area, scene_->corner(crossing, 0) - from) / slope;
    crossing.from_outside = slope < 0;
    if (crossing.distance > 0) found.push_back(crossing);
  }
  std::ranges::sort(found, [](const Crossing& a, const Crossing& b) {
    return std::tie(a.distance, a.mesh, a.triangle) < std::tie(b.distance, b.mesh, b.triangle);
  });
  // Keeps only the first crossing of each surface among those at one position.
  std::size_t kept = 0;
  for (const Crossing& each : found) {
    bool again = false;
    for (std::size_t i = kept; i > 0 && each.distance - found[i - 1].distance <= kSamePlace * each.distance; --i) {
      again = again || scene_->neighbours(found[i - 1], each);
    }
    if (!again) found[kept++] = each;
  }
  found.resize(kept);
}

void MeshCaster::ahead(Vec3 from, Vec3 direction, std::vector<Crossing>& found) const {
  find(from, direction, found);
  std::erase_if(found, [](const Crossing& c) { return c.distance <= kTouching; });
}

std::optional<Crossing> MeshCaster::first(Vec3 from, Vec3 direction) const {
  thread_local std::vector<Crossing> crossings;
  ahead(from, direction, crossings);
  return crossings.empty() ? std::nullopt : std::optional(crossings.front());
}

bool MeshCaster::blocked(Vec3 from, Vec3 direction, double distance) const {
  const auto met = first(from, direction);
  return met && met->distance < distance - kTouching;
}

}  // namespace gicube::samples
