// One picture: scene to board, frame to image and statistics.
#pragma once

#include "gicube/board.h"
#include "gicube/image.h"
#include "render/options.h"
#include "render/progress.h"
#include "render/statistics.h"

namespace gicube::samples {

struct Frame {
  Image image;
  std::optional<Colour> background;  // the scene's own
  FrameStatistics statistics;
};

// Sets up the scene, loads it into the board at options.board and renders it. Throws UsageError (options, URI),
// InputError and FileError (scene, volume), and the driver's errors.
Frame render_frame(const RenderOptions& options, ProgressLine& progress);

}  // namespace gicube::samples
