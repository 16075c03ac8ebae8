#include "table.h"

#include <fmt/format.h>

#include <cmath>

namespace gicube::accuracy {

namespace {

std::string decibel(double value) { return std::isinf(value) ? "equal" : fmt::format("{:.1f}", value); }

// One line of the second table: a figure of every scene.
template <typename Figure>
std::string line(const std::string& name, const std::vector<Row>& rows, const Figure& figure) {
  std::string text = name;
  for (const Row& row : rows) {
    const reference::Difference& difference = figure(row.figures);
    text += fmt::format(",{} ({:.4f})", decibel(difference.psnr_db), difference.max_error);
  }
  return text + "\n";
}

}  // namespace

std::string scene_table(const std::vector<Row>& rows) {
  std::string text =
      "scene,transfer function,voxels,image,step,covered,PSNR dB,PSNR dB of covered pixels,RMSE,largest error\n";
  for (const Row& row : rows) {
    const Figures& f = row.figures;
    text += fmt::format("{},{},{} x {} x {},{} x {},{},{:.0f}%,{},{},{:.5f},{:.4f}\n", row.scene, row.look, f.dims[0],
                        f.dims[1], f.dims[2], f.width, f.height, f.step, 100 * f.board.covered,
                        decibel(f.board.psnr_db), decibel(f.board.covered_psnr_db), f.board.rmse, f.board.max_error);
  }
  return text;
}

std::string quantiser_table(const std::vector<Row>& rows) {
  std::string text = "quantiser";
  for (const Row& row : rows) text += "," + row.scene;
  text += "\n";
  for (std::size_t i = 0; i < kQuantisers.size(); ++i) {
    text += line(
        std::string(kQuantisers[i].name), rows, [i](const Figures& f) -> const auto& { return f.alone[i]; });
  }
  text += line(
      "all together", rows, [](const Figures& f) -> const auto& { return f.together; });
  text += line(
      "board against all together", rows, [](const Figures& f) -> const auto& { return f.unexplained; });
  return text;
}

}  // namespace gicube::accuracy
