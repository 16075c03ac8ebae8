#include "table.h"

#include <fmt/format.h>

#include <cmath>

namespace gicube::accuracy {

namespace {

std::string decibel(double value) { return std::isinf(value) ? "equal" : fmt::format("{:.1f}", value); }

std::string scene_table(const std::vector<Row>& rows) {
  std::string text =
      "| scene | transfer function | voxels | image | step | covered | PSNR dB | PSNR dB of covered pixels | RMSE | "
      "largest error |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Row& row : rows) {
    const Figures& f = row.figures;
    text += fmt::format("| {} | {} | {} x {} x {} | {} x {} | {} | {:.0f}% | {} | {} | {:.5f} | {:.4f} |\n", row.scene,
                        row.look, f.dims[0], f.dims[1], f.dims[2], f.width, f.height, f.step, 100 * f.board.covered,
                        decibel(f.board.psnr_db), decibel(f.board.covered_psnr_db), f.board.rmse, f.board.max_error);
  }
  return text;
}

// One line of the second table: a figure of every scene.
template <typename Figure>
std::string line(const std::string& name, const std::vector<Row>& rows, const Figure& figure) {
  std::string text = "| " + name + " |";
  for (const Row& row : rows) {
    const reference::Difference& difference = figure(row.figures);
    text += fmt::format(" {} ({:.4f}) |", decibel(difference.psnr_db), difference.max_error);
  }
  return text + "\n";
}

std::string quantiser_table(const std::vector<Row>& rows) {
  std::string text = "| quantiser |", rule = "|---|";
  for (const Row& row : rows) {
    text += " " + row.scene + " |";
    rule += "---|";
  }
  text += "\n" + rule + "\n";
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

}  // namespace

std::string markdown(const std::vector<Row>& rows) {
  return R"(# Accuracy

Made by `gicube-accuracy --output docs/studies/accuracy.md`; not edited by hand.

Asked: what does each fixed-point word cost? The board's pictures are 46 dB or more from the double-precision reference
(`tests/support/reference`), and the 11-bit code of gradients is most of the difference. Scene, step and sampling are
the same, without jitter and, in the reference, without quantisation. PSNR has peak 1 and includes red, green, blue
(premultiplied) and alpha of all pixels. Empty background counts too, so there is another column for covered pixels.

)" + scene_table(rows) +
         R"(
The effect of each quantiser by itself: the reference with only that quantiser, compared with the reference without;
PSNR in dB, and the largest error in brackets. The last line is the difference that the quantisers do not explain.

)" + quantiser_table(rows) +
         R"(
Two discontinuities make the errors of single pixels large. The last bit of its position decides whether a grazing ray
hits a surface. A ray near the opacity threshold ends one sample earlier or later, which changes up to one minus the
threshold, 0.02.
)";
}

}  // namespace gicube::accuracy
