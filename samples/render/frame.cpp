#include "render/frame.h"

#include "render/renderer.h"

namespace gicube::samples {

void render_frames(const RenderOptions& options, ProgressLine& progress,
                   const std::function<void(const Frame&)>& done) {
  Renderer renderer(options, [&progress](const std::string& what) {
    progress.show(what);
    return progress.parts(what);
  });
  const std::vector<double> times = frame_times(options.animation);
  for (std::size_t first = 0; first < times.size();) {
    const std::size_t length = renderer.run_length(times, first);
    renderer.run(times, first, first + length, done);
    first += length;
  }
}

}  // namespace gicube::samples
