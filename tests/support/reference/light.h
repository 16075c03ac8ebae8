// Local illumination: Phong's model as shading.h states it, exactly or by the board's reflectance map.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gicube/shading.h"
#include "scene.h"

namespace gicube::reference {

class Light {
 public:
  // `towards_eye`: physical unit vector, one for the whole image.
  Light(const Shading& shading, Vec3 towards_eye, const Quantisers& quantisers);

  // A colour under the light, of a sample whose interpolated gradient is `gradient`; unchanged if that is shorter than
  // 1/16. What the shade has above ambient + diffuse is a highlight and goes to white.
  std::array<double, 3> shade(const std::array<double, 3>& colour, Vec3 gradient) const;

  // The light that a surface with this unit normal reflects, without the ambient part.
  double reflected(Vec3 normal) const;

 private:
  double looked_up(Vec3 normal) const;

  Phong phong_;
  Vec3 light_;        // unit
  Vec3 towards_eye_;  // unit
  double ambient_;
  double knee_;
  std::vector<std::uint8_t> map_;  // empty: exact
};

}  // namespace gicube::reference
