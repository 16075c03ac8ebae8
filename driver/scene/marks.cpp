#include "gicube/scene/marks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

// Letters of 5 x 7 pixels, rows from the top, the leftmost pixel in bit 4.
constexpr std::array<std::pair<char, std::array<std::uint8_t, 7>>, 10> kLetters{{
    {'A', {0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001}},
    {'I', {0b01110, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'L', {0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111}},
    {'P', {0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000}},
    {'R', {0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001}},
    {'S', {0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110}},
    {'x', {0b00000, 0b00000, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001}},
    {'y', {0b00000, 0b00000, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110}},
    {'z', {0b00000, 0b00000, 0b11111, 0b00010, 0b00100, 0b01000, 0b11111}},
    {'-', {0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000}},
}};
constexpr Pixel kNear{240, 228, 66, 4095}, kFar{150, 142, 40, 4095},
    kOutline{0, 0, 0, 4095};  // yellow of Okabe and Ito
constexpr int kSmallest = 64;

class Pen {
 public:
  explicit Pen(Image& image) : image_(image), zoom_(std::max(1, std::min(image.width, image.height) / 256)) {}

  // Lines have a dark edge, so that they are visible on any background.
  void line(double x0, double y0, double x1, double y1, const Pixel& colour) {
    const int steps = static_cast<int>(std::ceil(2 * std::hypot(x1 - x0, y1 - y0))) + 1;
    for (const bool edge : {true, false}) {
      for (int i = 0; i <= steps; ++i) {
        const double t = static_cast<double>(i) / steps;
        dot(x0 + t * (x1 - x0), y0 + t * (y1 - y0), edge ? zoom_ + 2 : zoom_, edge ? kOutline : colour);
      }
    }
  }
  void text(double x, double y, std::string_view letters, const Pixel& colour) {
    const double left = x - 0.5 * zoom_ * (6.0 * static_cast<double>(letters.size()) - 1), top = y - 3.5 * zoom_;
    for (const bool edge : {true, false}) {
      for (std::size_t i = 0; i < letters.size(); ++i) {
        const auto* const found = std::ranges::find(kLetters, letters[i], [](const auto& each) { return each.first; });
        if (found == kLetters.end()) continue;
        for (int row = 0; row < 7; ++row) {
          for (int column = 0; column < 5; ++column) {
            if ((found->second[static_cast<std::size_t>(row)] >> (4 - column) & 1) == 0) continue;
            dot(left + zoom_ * (6.0 * static_cast<double>(i) + column + 0.5), top + zoom_ * (row + 0.5),
                edge ? zoom_ + 2 : zoom_, edge ? kOutline : colour);
          }
        }
      }
    }
  }

 private:
  void dot(double x, double y, int size, const Pixel& colour) {
    const int left = static_cast<int>(std::floor(x - 0.5 * size + 0.5)),
              top = static_cast<int>(std::floor(y - 0.5 * size + 0.5));
    for (int row = std::max(top, 0); row < std::min(top + size, image_.height); ++row) {
      for (int column = std::max(left, 0); column < std::min(left + size, image_.width); ++column) {
        image_.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image_.width) +
                      static_cast<std::size_t>(column)] = colour;
      }
    }
  }

  Image& image_;
  int zoom_;
};

}  // namespace

std::array<std::string, 6> axis_marks(const WorldPlacement& placement) {
  if (placement.axes == WorldAxes::kPatient) return {"R", "L", "A", "P", "I", "S"};
  return {"-x", "x", "-y", "y", "-z", "z"};
}

void draw_marks(const WorldPlacement& placement, const Vec3& spacing, const View& view, Image& image) {
  if (std::min(image.width, image.height) < kSmallest) return;
  const auto physical = [&spacing](Vec3 v) { return Vec3{v.x * spacing.x, v.y * spacing.y, v.z * spacing.z}; };
  const Vec3 towards = unit_or_zero(physical(view.eye - view.look_at));
  const Vec3 right = unit_or_zero(cross(view.up, towards)), upward = cross(towards, right);
  struct End {
    double x, y, near;
    std::string text;
  };
  std::vector<End> ends;
  const auto marks = axis_marks(placement);
  const std::array<Vec3, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      if (side < 0 && placement.axes != WorldAxes::kPatient) continue;
      const Vec3 way = double(side) * axes[axis];
      ends.push_back({dot(way, right), dot(way, upward), dot(way, towards), marks[2 * axis + (side > 0 ? 1 : 0)]});
    }
  }
  std::ranges::sort(ends, {}, &End::near);
  Pen pen(image);
  const double size = std::min(image.width, image.height), arm = 0.055 * size, middle = 0.1 * size;
  for (const auto& [x, y, near, text] : ends) {
    const Pixel& colour = near < -0.3 ? kFar : kNear;
    const double left = middle, top = image.height - middle;
    pen.line(left, top, left + 0.7 * arm * x, top - 0.7 * arm * y, colour);
    pen.text(left + 1.2 * arm * x, top - 1.2 * arm * y, text, colour);
  }
}

}  // namespace gicube::scene
