// The fields of the public records that a checkpoint keeps (gicube/archive.h).
// Written by script/records from the public headers: change those.
#pragma once

#include <cstdint>

#include "gicube/archive.h"
#include "gicube/illumination.h"
#include "gicube/material.h"
#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/view.h"
#include "gicube/volume.h"

namespace gicube {

void state_of(Archive::Record& record, Lamp& lamp);
inline void state_of(Archive::Record& record, Vec3& value) { record(value.x, value.y, value.z); }

inline void state_of(Archive::Record& record, ValueRange& value) { record(value.low, value.high); }

inline void state_of(Archive::Record& record, ColourPoint& value) { record(value.value, value.colour); }

inline void state_of(Archive::Record& record, OpacityPoint& value) { record(value.value, value.opacity); }

inline void state_of(Archive::Record& record, TransferFunction& value) {
  record.list(value.colours, std::uint64_t{1} << 32);
  record.list(value.opacities, std::uint64_t{1} << 32);
}

inline void state_of(Archive::Record& record, CutPlane& value) { record(value.normal, value.offset); }

inline void state_of(Archive::Record& record, Phong& value) {
  record(value.ambient, value.diffuse, value.specular, value.shininess);
}

inline void state_of(Archive::Record& record, Shading& value) { record(value.phong, value.light); }

inline void state_of(Archive::Record& record, RectangleLight& value) {
  record(value.corner, value.edge_u, value.edge_v, value.power);
}

inline void state_of(Archive::Record& record, SphereLight& value) { record(value.centre, value.radius, value.power); }

inline void state_of(Archive::Record& record, View& value) {
  record(value.eye, value.look_at, value.up, value.fov_degrees, value.orthographic_height, value.width, value.height,
         value.samples_per_axis);
  record.at_most(value.filter, PixelFilter::kTent);
  record(value.step, value.opacity_threshold, value.shade, value.jitter, value.leap, value.irradiance, value.incident,
         value.exposure, value.scatter, value.high_albedo, value.lifetime, value.seed);
  record.list(value.cut_planes, 6);
  record.list(value.lamps, kMaxLamps);
}

inline void state_of(Archive::Record& record, Material& value) {
  record(value.scattering);
  record.at_most(value.bsdf, Bsdf::kTrap);
  record(value.gloss, value.seen_through_scattering, value.routine, value.surface);
  record.list(value.parameters, 32);
  record(value.scattering_colour);
}

}  // namespace gicube
