#include "render/frame.h"

#include <optional>

#include "gicube/scene/error.h"
#include "render/hosts.h"
#include "render/renderer.h"

namespace gicube::samples {

void render_frames(const RenderOptions& options, ProgressLine& progress, const std::function<void(const Frame&)>& done,
                   MpiExchange* ranks) {
  const Steps steps = [&progress](const std::string& what) {
    progress.show(what);
    return progress.parts(what);
  };
  std::optional<Renderer> opened;
  together(ranks, [&] { opened.emplace(options, steps, std::function<void()>(), ranks); });
  Renderer& renderer = *opened;
  const std::vector<double> times = frame_times(options.animation);
  for (auto first = static_cast<std::size_t>(options.checkpoint.first_frame); first < times.size();) {
    const std::size_t length = renderer.run_length(times, first);
    renderer.run(times, first, first + length, done);
    first += length;
  }
  if (!renderer.checkpoint_is_written()) {
    throw InputError("--checkpoint-at", "a time or a ray before the last picture",
                     "a later one: no checkpoint is written");
  }
}

}  // namespace gicube::samples
