// The records of the public headers, with their fields: the classes of gicube.records.
// Written by script/records from the public headers: change those.
#pragma once

#include "convert.h"
#include "gicube/board.h"
#include "gicube/board_group.h"
#include "gicube/enumerate.h"
#include "gicube/fidelity.h"
#include "gicube/illumination.h"
#include "gicube/level_of_detail.h"
#include "gicube/light_plan.h"
#include "gicube/material.h"
#include "gicube/pair.h"
#include "gicube/plan.h"
#include "gicube/ray.h"
#include "gicube/scattering.h"
#include "gicube/scene/volume_file.h"
#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/view.h"
#include "gicube/volume.h"

namespace gicube::python {

using scene::RawLayout;
using scene::WorldAxes;
using scene::WorldPlacement;

#define F(NAME) \
  std::pair { #NAME, &T::NAME }
#define GICUBE_RECORD(TYPE, ...)                                       \
  template <>                                                          \
  struct Record<TYPE> {                                                \
    using T = TYPE;                                                    \
    static constexpr auto fields() { return std::tuple{__VA_ARGS__}; } \
  }
GICUBE_RECORD(ValueRange, F(low), F(high));
GICUBE_RECORD(VoxelBox, F(low), F(size));
GICUBE_RECORD(Placement, F(low), F(edge));
GICUBE_RECORD(WorldPlacement, F(axes), F(directions), F(origin), F(stored));
GICUBE_RECORD(RawLayout, F(dims), F(type), F(spacing), F(big_endian), F(skip_bytes));
GICUBE_RECORD(ColourPoint, F(value), F(colour));
GICUBE_RECORD(OpacityPoint, F(value), F(opacity));
GICUBE_RECORD(TransferFunction, F(colours), F(opacities));
GICUBE_RECORD(Phong, F(ambient), F(diffuse), F(specular), F(shininess));
GICUBE_RECORD(Shading, F(phong), F(light));
GICUBE_RECORD(Material, F(scattering), F(bsdf), F(gloss), F(seen_through_scattering), F(routine), F(surface),
              F(parameters), F(scattering_colour));
GICUBE_RECORD(CutPlane, F(normal), F(offset));
GICUBE_RECORD(PointLight, F(position), F(power));
GICUBE_RECORD(DirectionalLight, F(towards), F(irradiance));
GICUBE_RECORD(RectangleLight, F(corner), F(edge_u), F(edge_v), F(power));
GICUBE_RECORD(SphereLight, F(centre), F(radius), F(power));
GICUBE_RECORD(Lamp, F(light), F(colour));
GICUBE_RECORD(View, F(eye), F(look_at), F(up), F(fov_degrees), F(orthographic_height), F(width), F(height),
              F(samples_per_axis), F(filter), F(step), F(opacity_threshold), F(shade), F(jitter), F(leap),
              F(irradiance), F(incident), F(exposure), F(scatter), F(high_albedo), F(lifetime), F(seed), F(cut_planes),
              F(lamps));
GICUBE_RECORD(Illumination, F(albedo), F(rules), F(rays_per_face_voxel), F(step), F(jitter), F(leap), F(lifetime),
              F(seed), F(light_colours));
GICUBE_RECORD(LightEnergy, F(emitted), F(deposited), F(escaped), F(scattered_away), F(given_up), F(clipped));
GICUBE_RECORD(LightingReport, F(rays), F(emitted), F(deposited), F(escaped), F(escaped_by_face), F(scattered_away),
              F(given_up), F(clipped), F(unit), F(warnings), F(colours));
GICUBE_RECORD(BoardTime, F(bus), F(work), F(bus_wait), F(skew));
GICUBE_RECORD(DepositReport, F(rays), F(samples), F(kept), F(clipped), F(overflowed), F(unit));
GICUBE_RECORD(FoundBoard, F(uri), F(process), F(product), F(version), F(in_use), F(owner));
GICUBE_RECORD(Sampling, F(jitter), F(cut_planes), F(seed), F(opacity_threshold), F(shade), F(irradiance), F(incident),
              F(exposure), F(scatter), F(high_albedo), F(lifetime), F(looking));
GICUBE_RECORD(RayRequest, F(type), F(opacity), F(albedo), F(rules), F(lifetime), F(words), F(step), F(leap),
              F(sampling));
GICUBE_RECORD(PairRequest, F(rays), F(first), F(seed), F(opacity), F(step), F(leap), F(made));
GICUBE_RECORD(BoardInfo, F(protocol_major), F(protocol_minor), F(fidelity), F(processors), F(block_voxels),
              F(max_volume_voxels), F(queue_rays), F(core_khz), F(config_hash), F(vendor_id), F(device_id), F(wide),
              F(agp), F(host_rays), F(voxel_format), F(irradiance_words));
GICUBE_RECORD(Reopened, F(resumed), F(volume));
GICUBE_RECORD(BrickDetail, F(blocks), F(largest_density), F(largest_opacity));
GICUBE_RECORD(LevelError, F(largest_density), F(rms_density), F(largest_opacity));
GICUBE_RECORD(PlanPoint, F(level), F(step), F(opacity_threshold), F(error), F(error_bound), F(samples), F(time),
              F(pilot_width), F(pilot_height));
GICUBE_RECORD(LightPoint, F(albedo), F(step), F(rays_per_face_voxel), F(error), F(error_bound), F(noise), F(bias),
              F(rays), F(samples), F(time));
GICUBE_RECORD(ScatterEvent, F(position), F(direction), F(normal), F(opacity), F(density), F(tag), F(lighting),
              F(generation), F(random));
GICUBE_RECORD(ScatterAnswer, F(direction), F(passes));
GICUBE_RECORD(AnsweredCommand, F(command), F(count));
GICUBE_RECORD(LevelReport, F(level), F(answered), F(not_modelled));
GICUBE_RECORD(OpenOptions, F(watchdog), F(max_rays), F(max_waiting_rays), F(back_pressure), F(keep_volume),
              F(reopen_attempts), F(force), F(wait_for_board), F(capture), F(token_file), F(ca_file), F(go_on));
GICUBE_RECORD(GroupOptions, F(buses), F(board));
GICUBE_RECORD(PlanRequest, F(view), F(max_error), F(time_budget), F(pilot_pixels));
GICUBE_RECORD(LightPlanRequest, F(settings), F(view), F(channel), F(max_error), F(time_budget), F(max_rays),
              F(pilot_pixels));
GICUBE_RECORD(Plan, F(chosen), F(best), F(finest), F(kept), F(points), F(placement), F(dims), F(original_dims), F(box),
              F(gradients), F(voxels_a_pixel), F(level_for_pixels), F(level_errors), F(fidelity), F(pilots),
              F(pilot_samples), F(pilot_host_seconds));
GICUBE_RECORD(LightPlan, F(chosen), F(asked), F(kept), F(at_limit), F(points), F(passes), F(pass_samples),
              F(host_seconds), F(channel));
#undef F
#undef GICUBE_RECORD

// Those that have a class of their own in Python.
template <template <typename...> typename To>
using EveryRecord = To<ValueRange, VoxelBox, Placement, WorldPlacement, RawLayout, ColourPoint, OpacityPoint,
                       TransferFunction, Phong, Shading, Material, CutPlane, PointLight, DirectionalLight,
                       RectangleLight, SphereLight, Lamp, View, Illumination, LightEnergy, LightingReport, BoardTime,
                       DepositReport, FoundBoard, Sampling, RayRequest, PairRequest, BoardInfo, Reopened, BrickDetail,
                       LevelError, PlanPoint, LightPoint, ScatterEvent, ScatterAnswer, AnsweredCommand, LevelReport>;

}  // namespace gicube::python
