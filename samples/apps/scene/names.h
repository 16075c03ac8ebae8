// The samples' namespace sees the names of gicube-scene.
#pragma once

namespace gicube::scene {}

namespace gicube::samples {

using namespace scene;

}  // namespace gicube::samples
