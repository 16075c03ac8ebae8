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

std::string pass_text(const RayPass& pass, const std::array<std::uint32_t, 3>& blocks) {
  const std::array<double, 3> position{pass.position[0] / double{wire::kVoxel}, pass.position[1] / double{wire::kVoxel},
                                       pass.position[2] / double{wire::kVoxel}};
  std::string out = fmt::format(R"({{"position":{},"block":{},)", list(position), block_text(pass.block, blocks));
  if (pass.skipped > 0) {
    out += fmt::format(R"("leap":{},)", pass.skipped);
  } else {
    constexpr double kDensity = 1 << kDensityFractionBits;
    out += fmt::format(R"("density":{},"gradient":[{},{},{}],"tag":{},"entry":{},"colour":{},"opacity":{},)",
                       pass.channels[0] / kDensity, pass.channels[1], pass.channels[2], pass.channels[3], pass.tag,
                       pass.entry, list(pass.colour), pass.alpha);
    if (pass.scattered) out += R"("scattered":true,)";
  }
  return out + fmt::format(R"("gathered":{{"colour":{},"opacity":{}}}}})", list(pass.gathered), pass.opacity);
}

}  // namespace

std::string to_json(const PixelLife& life) {
  std::string out = fmt::format(R"({{"event":"life","pixel":[{},{}],)", life.x, life.y);
  if (!life.refused.empty()) return out + fmt::format(R"("refused":"{}"}})", life.refused);
  out += fmt::format(R"("framebuffer":{},"explained":{},"rays":[)", pixel_text(life.pixel), pixel_text(life.explained));
  for (const RayLife& ray : life.rays) {
    out += fmt::format(R"({}{{"ray":{},"at":[{},{}],"end":"{}","passes":[)", &ray == life.rays.data() ? "" : ",",
                       ray.number, ray.ray.u / 16.0, ray.ray.v / 16.0, ray.end);
    for (const RayPass& pass : ray.passes) {
      out += (&pass == ray.passes.data() ? "" : ",") + pass_text(pass, life.blocks);
    }
    out += "]}";
  }
  return out + "]}";
}

}  // namespace gicube::emu
