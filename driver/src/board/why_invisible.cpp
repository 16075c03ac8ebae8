// Finds the likely reason why nothing is visible in a picture, from what the driver knows of the board.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "encode/camera.h"
#include "encode/vectors.h"
#include "encode/volume/block_order.h"
#include "state.h"

namespace gicube {
namespace {

constexpr std::size_t kDensities = std::size_t{wire::kDensityMax} + 1;
constexpr int kUnseenAlpha = 8;      // chosen: of 4095, less than half a step of 8 bits
constexpr double kSmallPart = 0.02;  // chosen: of the range; a mask of 0 and 1 in 0..255 takes 0.004

bool can_be_seen(const Pixel& pixel) {
  return pixel.red > 0 || pixel.green > 0 || pixel.blue > 0 || pixel.alpha > kUnseenAlpha;
}

// Densities from `least` to `most`; none if least > most.
struct Densities {
  int least = wire::kDensityMax, most = 0;

  void add(int low, int high) {
    least = std::min(least, low);
    most = std::max(most, high);
  }
  // In the volume's values, rounded to the digit that a step of density changes.
  std::string text(ValueRange range) const {
    const double step = (range.high - range.low) / wire::kDensityMax;
    const double unit = std::pow(10, std::ceil(std::log10(step)));
    const auto value = [&](int density) { return std::round((range.low + density * step) / unit) * unit + 0.0; };
    return least == most ? fmt::format("{:.6g}", value(least))
                         : fmt::format("{:.6g} to {:.6g}", value(least), value(most));
  }
};

// The reason if the tables make the whole volume invisible, from any direction; empty if they don't.
std::string hidden_by_tables(const LoadedVolume& volume, const Tables& tables) {
  unsigned tags = 0;
  Densities there, shown;
  for (const BlockStatistics& block : volume.statistics) {
    tags |= block.tags;
    there.add(block.min_density, block.max_density);
  }
  for (std::size_t i = 0; i < tables.segmentation().size(); ++i) {
    const int density = static_cast<int>(i % kDensities);
    if ((tags >> i / kDensities & 1) != 0 && is_visible(tables.segmentation()[i])) shown.add(density, density);
  }
  if (tables.functions().empty()) return "no transfer function is set";
  if (shown.least > shown.most)
    return "the transfer function of the voxels' tags has no opacity, or none is set for them";
  if (std::ranges::count(find_empty_blocks(volume.statistics, tables.segmentation()), 0) > 0) return {};
  const double part = static_cast<double>(there.most) / wire::kDensityMax;
  return fmt::format("voxels have values of {}, the transfer function has opacity at {} alone{}",
                     there.text(volume.range), shown.text(volume.range),
                     part > kSmallPart ? "" : " (a mask? load it with its own range of values)");
}

}  // namespace

std::string BoardState::why_invisible() const {
  if (!volume) return "there is no volume";
  if (std::string reason = hidden_by_tables(*volume, tables); !reason.empty()) return reason;
  const View& view = sampling;
  const bool has_view = framebuffer_size.first > 0;
  std::vector<std::uint8_t> hidden = find_empty_blocks(volume->statistics, tables.segmentation());
  for (std::size_t i = 0; i < hidden.size() && has_view && view.leap; ++i) hidden[i] |= volume->flags[i];
  if (std::ranges::count(hidden, 0) == 0) return "the empty flags that were set hide all that is visible";
  if (has_view) {
    const wire::RenderCommand camera = viewing_command(view, volume->relative_spacing);
    const Vec3 edge = volume->relative_spacing, way = view.look_at - view.eye;
    const Vec3 ahead = times(times(edge, edge), way);
    std::vector<CutPlane> planes{
        {ahead, dot(ahead, view.eye)}};  // rays of an orthographic camera miss what is behind it
    const auto sees = [&] {
      const BlockOrder order(volume->blocks, info.block_voxels, camera, planes);
      for (std::size_t i = 0; i < hidden.size(); ++i) {
        if (hidden[i] == 0 && order.sees(i)) return true;
      }
      return false;
    };
    if (!sees()) return "the camera looks past all that is visible";
    planes.insert(planes.end(), view.cut_planes.begin(), view.cut_planes.end());
    if (!sees()) return "all that is visible is cut away";
  }
  return std::string("opacities are too small, or ") + (has_view && !view.cut_planes.empty()
                                                            ? "the cut planes leave nothing that is visible"
                                                            : "what is visible is smaller than a pixel");
}

std::string Renderer::why_invisible(const Image& image) const {
  if (image.pixels.empty() || std::ranges::any_of(image.pixels, can_be_seen)) return {};
  const auto lock = state_->lock();
  return "nothing is visible in the picture: " + state_->why_invisible();
}

}  // namespace gicube
