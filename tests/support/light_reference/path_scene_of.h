// A scene as the reference's path tracer takes it.
#pragma once

#include "gicube/scene/scene.h"
#include "reference/paths/path_scene.h"

namespace gicube::samples {

// With the surfaces that the samples give to solids: where the opacity reaches half of its greatest. `setup` must
// outlive it. Throws InputError for a solid that is opaque nowhere.
reference::paths::PathScene to_paths(const scene::SceneSetup& setup);

}  // namespace gicube::samples
