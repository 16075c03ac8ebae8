// Small volumes made from formulas, for the tests that hold the reference against closed forms.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "march.h"

namespace gicube::reference {

// A float volume and a scene around it: opacities and colours to be set. Opacity threshold 1 (never stops early), no
// shading, values 0..1 unless set otherwise.
class TestScene {
 public:
  TestScene(Dims dims, const std::function<double(Vec3)>& value) {
    for (int z = 0; z < dims[2]; ++z) {
      for (int y = 0; y < dims[1]; ++y) {
        for (int x = 0; x < dims[0]; ++x) {
          values_.push_back(
              static_cast<float>(value({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)})));
        }
      }
    }
    scene.volume.samples = std::as_bytes(std::span(values_));
    scene.volume.type = SampleType::kFloat32;
    scene.volume.dims = dims;
    scene.volume.range = ValueRange{0, 1};
    scene.view.opacity_threshold = 1;
    scene.view.shade = false;
    scene.view.eye = {(dims[0] - 1) / 2.0, (dims[1] - 1) / 2.0, -50};
    scene.view.look_at = {(dims[0] - 1) / 2.0, (dims[1] - 1) / 2.0, 0};
  }
  TestScene(const TestScene&) = delete;
  TestScene& operator=(const TestScene&) = delete;

  // Every value has this opacity and colour.
  void look(double opacity, Colour colour = {1, 1, 1}) { scene.functions[0] = {{{0, colour}}, {{0, opacity}}}; }
  // Nothing below `value`, full opacity from there on.
  void surface(double value, Colour colour = {1, 1, 1}) {
    scene.functions[0] = {{{0, colour}}, {{value, 0}, {value, 1}}};
  }

  Scene scene;

 private:
  std::vector<float> values_;
};

// Every voxel has the value 1/2.
class UniformScene : public TestScene {
 public:
  explicit UniformScene(Dims dims) : TestScene(dims, [](Vec3) { return 0.5; }) {}
};

}  // namespace gicube::reference
