#include "observe/life.h"

#include <fmt/format.h>

#include <iterator>

namespace gicube::emu {

namespace {

template <typename Words>
std::string list(const Words& words) {
  return fmt::format("[{},{},{}]", words[0], words[1], words[2]);
}

std::string block_text(std::size_t block, const std::array<std::uint32_t, 3>& blocks) {
  return fmt::format("[{},{},{}]", block % blocks[0], block / blocks[0] % blocks[1], block / blocks[0] / blocks[1]);
}

std::string pixel_text(const wire::Pixel& pixel) {
  return fmt::format("[{},{},{},{}]", pixel.red, pixel.green, pixel.blue, pixel.alpha);
}

std::string iteration_text(const RayIteration& iteration, const std::array<std::uint32_t, 3>& blocks) {
  const std::array<double, 3> position{iteration.position[0] / double{wire::kVoxel},
                                       iteration.position[1] / double{wire::kVoxel},
                                       iteration.position[2] / double{wire::kVoxel}};
  std::string out = fmt::format(R"({{"position":{},"block":{},)", list(position), block_text(iteration.block, blocks));
  if (iteration.skipped > 0) {
    out += fmt::format(R"("leap":{},)", iteration.skipped);
  } else {
    constexpr double kDensity = 1 << kDensityFractionBits;
    out += fmt::format(R"("density":{},"gradient":[{},{},{}],"tag":{},"entry":{},"colour":{},"opacity":{},)",
                       iteration.channels[0] / kDensity, iteration.channels[1], iteration.channels[2],
                       iteration.channels[3], iteration.tag, iteration.entry, list(iteration.colour), iteration.alpha);
    if (iteration.scattered) out += R"("scattered":true,)";
  }
  return out + fmt::format(R"("gathered":{{"colour":{},"opacity":{}}}}})", list(iteration.gathered), iteration.opacity);
}

}  // namespace

std::string to_json(const PixelLife& life) {
  std::string out = fmt::format(R"({{"event":"life","pixel":[{},{}],)", life.x, life.y);
  if (!life.refused.empty()) return out + fmt::format(R"("refused":"{}"}})", life.refused);
  out += fmt::format(R"("framebuffer":{},"explained":{},"rays":[)", pixel_text(life.pixel), pixel_text(life.explained));
  for (const RayLife& ray : life.rays) {
    out += fmt::format(R"({}{{"ray":{},"at":[{},{}],"end":"{}","passes":[)", &ray == life.rays.data() ? "" : ",",
                       ray.number, ray.ray.u / 16.0, ray.ray.v / 16.0, ray.end);
    for (const RayIteration& iteration : ray.iterations) {
      out += (&iteration == ray.iterations.data() ? "" : ",") + iteration_text(iteration, life.blocks);
    }
    out += "]}";
  }
  return out + "]}";
}

}  // namespace gicube::emu
