// The fields that cross between the records of C and those of C++.
// Written by script/records from the public headers: change those.
#pragma once

#include <cstddef>
#include <type_traits>

#include "c_api/copy.h"
#include "gicube/board.h"
#include "gicube/c_types.h"
#include "gicube/enumerate.h"
#include "gicube/image.h"
#include "gicube/pair.h"
#include "gicube/ray.h"
#include "gicube/scattering.h"

namespace gicube::c_api {

// The size of a record's first version: fields from there on came later, and older callers do not have them.
template <typename Record>
inline constexpr std::size_t kFirstSize = sizeof(Record);
template <>
inline constexpr std::size_t kFirstSize<gicube_open_options> = offsetof(gicube_open_options, go_on);
template <>
inline constexpr std::size_t kFirstSize<gicube_board_info> = offsetof(gicube_board_info, irradiance_words);
template <>
inline constexpr std::size_t kFirstSize<gicube_volume> = offsetof(gicube_volume, find_gradients);
template <>
inline constexpr std::size_t kFirstSize<gicube_material> = offsetof(gicube_material, scattering_colour);
template <>
inline constexpr std::size_t kFirstSize<gicube_illumination> = offsetof(gicube_illumination, light_colours);
template <>
inline constexpr std::size_t kFirstSize<gicube_lighting_report> = offsetof(gicube_lighting_report, escaped_by_face);
template <>
inline constexpr std::size_t kFirstSize<gicube_view> = offsetof(gicube_view, lamps);
template <>
inline constexpr std::size_t kFirstSize<gicube_ray_request> = offsetof(gicube_ray_request, sampled_as);
template <>
inline constexpr std::size_t kFirstSize<gicube_batch_report> = offsetof(gicube_batch_report, escaped_by_face);

static_assert(std::is_standard_layout_v<HostRay> && sizeof(gicube_host_ray) == sizeof(HostRay));
static_assert(offsetof(gicube_host_ray, id) == offsetof(HostRay, id));
static_assert(offsetof(gicube_host_ray, position) == offsetof(HostRay, position));
static_assert(offsetof(gicube_host_ray, direction) == offsetof(HostRay, direction));
static_assert(offsetof(gicube_host_ray, length) == offsetof(HostRay, length));
static_assert(offsetof(gicube_host_ray, energy) == offsetof(HostRay, energy));
static_assert(std::is_standard_layout_v<TracedRay> && sizeof(gicube_traced_ray) == sizeof(TracedRay));
static_assert(offsetof(gicube_traced_ray, id) == offsetof(TracedRay, id));
static_assert(offsetof(gicube_traced_ray, position) == offsetof(TracedRay, position));
static_assert(offsetof(gicube_traced_ray, direction) == offsetof(TracedRay, direction));
static_assert(offsetof(gicube_traced_ray, colour) == offsetof(TracedRay, colour));
static_assert(offsetof(gicube_traced_ray, opacity) == offsetof(TracedRay, opacity));
static_assert(offsetof(gicube_traced_ray, integral) == offsetof(TracedRay, integral));

void copy_fields(const auto& copy, gicube_open_options& c, OpenOptions& value) {
  copy.milliseconds(c.watchdog_ms, value.watchdog);
  copy.number(c.max_rays, value.max_rays);
  copy.number(c.max_waiting_rays, value.max_waiting_rays);
  copy.choice("back_pressure", c.back_pressure, value.back_pressure, BackPressure::kThrow);
  copy.truth("keep_volume", c.keep_volume, value.keep_volume);
  copy.number(c.reopen_attempts, value.reopen_attempts);
  copy.truth("force", c.force, value.force);
  copy.milliseconds(c.wait_for_board_ms, value.wait_for_board);
  copy.truth("go_on", c.go_on, value.go_on);
  copy.reserved("reserved", c.reserved);
  copy.reserved("reserved_too", c.reserved_too);
}

void copy_fields(const auto& copy, gicube_found_board& c, FoundBoard& value) {
  copy.number(c.process, value.process);
  copy.truth("in_use", c.in_use, value.in_use);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_reopened& c, Reopened& value) {
  copy.truth("resumed", c.resumed, value.resumed);
  copy.truth("volume", c.volume, value.volume);
}

void copy_fields(const auto& copy, gicube_board_info& c, BoardInfo& value) {
  copy.number(c.protocol_major, value.protocol_major);
  copy.number(c.protocol_minor, value.protocol_minor);
  copy.choice("fidelity", c.fidelity, value.fidelity, Fidelity::kCycle);
  copy.number(c.processors, value.processors);
  copy.number(c.block_voxels, value.block_voxels);
  copy.number(c.max_volume_voxels, value.max_volume_voxels);
  copy.number(c.queue_rays, value.queue_rays);
  copy.number(c.core_khz, value.core_khz);
  copy.number(c.config_hash, value.config_hash);
  copy.number(c.vendor_id, value.vendor_id);
  copy.number(c.device_id, value.device_id);
  copy.truth("wide", c.wide, value.wide);
  copy.truth("agp", c.agp, value.agp);
  copy.truth("host_rays", c.host_rays, value.host_rays);
  copy.choice("voxel_format", c.voxel_format, value.voxel_format, VoxelFormat::kRgba);
  copy.number(c.irradiance_words, value.irradiance_words);
}

void copy_fields(const auto& copy, gicube_volume& c, VolumeView& value) {
  copy.choice("type", c.type, value.type, SampleType::kFloat32);
  copy.numbers(c.dims, value.dims);
  copy.vector(c.spacing, value.spacing);
  copy.truth("find_gradients", c.find_gradients, value.find_gradients);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_box& c, VoxelBox& value) {
  copy.numbers(c.low, value.low);
  copy.numbers(c.size, value.size);
}

void copy_fields(const auto& copy, gicube_colour_point& c, ColourPoint& value) {
  copy.number(c.value, value.value);
  copy.numbers(c.colour, value.colour);
}

void copy_fields(const auto& copy, gicube_opacity_point& c, OpacityPoint& value) {
  copy.number(c.value, value.value);
  copy.number(c.opacity, value.opacity);
}

void copy_fields(const auto& copy, gicube_shading& c, Shading& value) {
  copy.number(c.ambient, value.phong.ambient);
  copy.number(c.diffuse, value.phong.diffuse);
  copy.number(c.specular, value.phong.specular);
  copy.number(c.shininess, value.phong.shininess);
  copy.vector(c.light, value.light);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_material& c, Material& value) {
  copy.number(c.scattering, value.scattering);
  copy.choice("bsdf", c.bsdf, value.bsdf, Bsdf::kTrap);
  copy.number(c.gloss, value.gloss);
  copy.truth("seen_through_scattering", c.seen_through_scattering, value.seen_through_scattering);
  copy.number(c.routine, value.routine);
  copy.truth("surface", c.surface, value.surface);
  copy.numbers(c.scattering_colour, value.scattering_colour);
}

void copy_fields(const auto& copy, gicube_scatter_event& c, ScatterEvent& value) {
  copy.vector(c.position, value.position);
  copy.vector(c.direction, value.direction);
  copy.vector(c.normal, value.normal);
  copy.number(c.opacity, value.opacity);
  copy.number(c.density, value.density);
  copy.number(c.tag, value.tag);
  copy.truth("lighting", c.lighting, value.lighting);
  copy.number(c.generation, value.generation);
  copy.numbers(c.random, value.random);
}

void copy_fields(const auto& copy, gicube_scatter_answer& c, ScatterAnswer& value) {
  copy.vector(c.direction, value.direction);
  copy.number(c.passes, value.passes);
}

void copy_fields(const auto& copy, gicube_illumination& c, Illumination& value) {
  copy.choice("albedo", c.albedo, value.albedo, Albedo::kHigh);
  copy.choice("rules", c.rules, value.rules, EnergyRules::kConserving);
  copy.number(c.rays_per_face_voxel, value.rays_per_face_voxel);
  copy.number(c.step, value.step);
  copy.truth("jitter", c.jitter, value.jitter);
  copy.truth("leap", c.leap, value.leap);
  copy.number(c.lifetime, value.lifetime);
  copy.number(c.seed, value.seed);
}

void copy_fields(const auto& copy, gicube_light_energy& c, LightEnergy& value) {
  copy.number(c.emitted, value.emitted);
  copy.number(c.deposited, value.deposited);
  copy.number(c.escaped, value.escaped);
  copy.number(c.scattered_away, value.scattered_away);
  copy.number(c.given_up, value.given_up);
  copy.number(c.clipped, value.clipped);
}

void copy_fields(const auto& copy, gicube_lighting_report& c, LightingReport& value) {
  copy.number(c.rays, value.rays);
  copy.number(c.emitted, value.emitted);
  copy.number(c.deposited, value.deposited);
  copy.number(c.escaped, value.escaped);
  copy.numbers(c.escaped_by_face, value.escaped_by_face);
  copy.number(c.scattered_away, value.scattered_away);
  copy.number(c.given_up, value.given_up);
  copy.number(c.clipped, value.clipped);
  copy.number(c.unit, value.unit);
}

void copy_fields(const auto& copy, gicube_batch_lighting& c, LightingReport& value) {
  copy.number(c.rays, value.rays);
  copy.number(c.emitted, value.emitted);
  copy.number(c.deposited, value.deposited);
  copy.number(c.escaped, value.escaped);
  copy.number(c.scattered_away, value.scattered_away);
  copy.number(c.given_up, value.given_up);
  copy.number(c.clipped, value.clipped);
  copy.number(c.unit, value.unit);
}

void copy_fields(const auto& copy, gicube_cut_plane& c, CutPlane& value) {
  copy.vector(c.normal, value.normal);
  copy.number(c.offset, value.offset);
}

void copy_fields(const auto& copy, gicube_lamp& c, Lamp& value) { copy.numbers(c.colour, value.colour); }

void copy_fields(const auto& copy, gicube_view& c, View& value) {
  copy.vector(c.eye, value.eye);
  copy.vector(c.look_at, value.look_at);
  copy.vector(c.up, value.up);
  copy.number(c.fov_degrees, value.fov_degrees);
  copy.number(c.orthographic_height, value.orthographic_height);
  copy.number(c.width, value.width);
  copy.number(c.height, value.height);
  copy.number(c.samples_per_axis, value.samples_per_axis);
  copy.choice("filter", c.filter, value.filter, PixelFilter::kTent);
  copy.number(c.step, value.step);
  copy.number(c.opacity_threshold, value.opacity_threshold);
  copy.truth("shade", c.shade, value.shade);
  copy.truth("jitter", c.jitter, value.jitter);
  copy.truth("leap", c.leap, value.leap);
  copy.truth("irradiance", c.irradiance, value.irradiance);
  copy.truth("incident", c.incident, value.incident);
  copy.number(c.exposure, value.exposure);
  copy.truth("scatter", c.scatter, value.scatter);
  copy.truth("high_albedo", c.high_albedo, value.high_albedo);
  copy.number(c.lifetime, value.lifetime);
  copy.number(c.seed, value.seed);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_pixel& c, Pixel& value) {
  copy.number(c.red, value.red);
  copy.number(c.green, value.green);
  copy.number(c.blue, value.blue);
  copy.number(c.alpha, value.alpha);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_host_ray& c, HostRay& value) {
  copy.number(c.id, value.id);
  copy.vector(c.position, value.position);
  copy.vector(c.direction, value.direction);
  copy.number(c.length, value.length);
  copy.number(c.energy, value.energy);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_traced_ray& c, TracedRay& value) {
  copy.number(c.id, value.id);
  copy.vector(c.position, value.position);
  copy.vector(c.direction, value.direction);
  copy.numbers(c.colour, value.colour);
  copy.number(c.opacity, value.opacity);
  copy.number(c.integral, value.integral);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_ray_request& c, RayRequest& value) {
  copy.choice("type", c.type, value.type, RayType::kBackproject);
  copy.number(c.opacity, value.opacity);
  copy.choice("albedo", c.albedo, value.albedo, Albedo::kHigh);
  copy.choice("rules", c.rules, value.rules, EnergyRules::kConserving);
  copy.number(c.lifetime, value.lifetime);
  copy.choice("words", c.words, value.words, SumWords::kSums);
  copy.number(c.step, value.step);
  copy.truth("leap", c.leap, value.leap);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_deposit_report& c, DepositReport& value) {
  copy.number(c.rays, value.rays);
  copy.number(c.samples, value.samples);
  copy.number(c.kept, value.kept);
  copy.number(c.clipped, value.clipped);
  copy.number(c.overflowed, value.overflowed);
  copy.number(c.unit, value.unit);
}

void copy_fields(const auto& copy, gicube_batch_report& c, BatchReport& value) {
  copy.number(c.completed_ps, value.completed);
  copy.truth("cancelled", c.cancelled, value.cancelled);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_element& c, Element& value) {
  copy.choice("kind", c.kind, value.kind, ElementKind::kDisc);
  copy.vector(c.origin, value.origin);
  copy.vector(c.u, value.u);
  copy.vector(c.v, value.v);
  copy.vector(c.w, value.w);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_element_pair& c, ElementPair& value) {
  copy.number(c.a, value.a);
  copy.number(c.b, value.b);
  copy.number(c.id, value.id);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_pair_request& c, PairRequest& value) {
  copy.number(c.rays, value.rays);
  copy.number(c.first, value.first);
  copy.number(c.seed, value.seed);
  copy.number(c.opacity, value.opacity);
  copy.number(c.step, value.step);
  copy.truth("leap", c.leap, value.leap);
  copy.choice("made", c.made, value.made, PairRays::kByHost);
}

void copy_fields(const auto& copy, gicube_pair_factor& c, PairFactor& value) {
  copy.number(c.transported, value.transported);
  copy.number(c.geometric, value.geometric);
  copy.number(c.standard_error, value.standard_error);
  copy.truth("clear", c.clear, value.clear);
  copy.reserved("reserved", c.reserved);
}

}  // namespace gicube::c_api
