// Pictures: scene to board, frames to images and statistics.
#pragma once

#include <functional>
#include <optional>

#include "gicube/board.h"
#include "gicube/image.h"
#include "gicube/mpi.h"
#include "gicube/scene/image_file.h"
#include "render/options.h"
#include "render/statistics.h"
#include "scene/program/progress.h"

namespace gicube::samples {

struct Frame {
  int number = 0;
  Image image;
  std::optional<Background> background;  // to be put behind the image
  FrameStatistics statistics;
};

// Renders the pictures that `options` ask for, in their order; what the last picture left on the board is used again:
// the volume while it stays the same, the irradiance while moreover lights and settings do. `done` is called for each.
// `ranks`: of the job, null if there is one host.
// Throws UsageError (options, URI), InputError and FileError (scene, volume), and the driver's errors.
void render_frames(const RenderOptions& options, ProgressLine& progress, const std::function<void(const Frame&)>& done,
                   MpiExchange* ranks = nullptr);

}  // namespace gicube::samples
