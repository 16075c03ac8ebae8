// Converts a view to the DSP's render command and the cut-plane registers.
#pragma once

#include <array>
#include <cstdint>

#include "gicube/ray.h"
#include "gicube/vector.h"
#include "gicube/view.h"
#include "gicube/wire/command.h"

namespace gicube {

// Throws BadArgument naming a field of the view with which no picture can be made.
void check(const View& view);
// Throws BadArgument naming a field of a request's sampling.
void check(const Sampling& sampling);

// A view from the origin whose rays are sampled like those of the request.
View view_of(const RayRequest& request);

// The camera in voxel coordinates. Its geometry (square pixels, angle of view, right angles) holds in physical space,
// where voxel position p is relative_spacing * p by components. Image x grows along forward x up, y downwards. For a
// view that passed check().
wire::RenderCommand viewing_command(const View& view, Vec3 relative_spacing);

// Physical unit vector from look_at to the eye: the reflectance map's view direction for the whole image.
Vec3 towards_eye(const View& view, Vec3 relative_spacing);

// A plane's four registers: its unit normal x y z as signed 1.14, its offset with 10 fraction bits. Voxel space.
std::array<std::uint32_t, 4> cut_plane_words(const CutPlane& plane);

}  // namespace gicube
