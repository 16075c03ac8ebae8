#include "encode/reflectance_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "encode/argument.h"
#include "gicube/wire/lut.h"

namespace gicube {
namespace {

constexpr double kShadeMax = 1.99;        // 255/128, the largest shade on the board
constexpr double kSumTolerance = 1e-9;    // 0.99 + 1.0 in doubles
constexpr double kTerminatorWidth = 0.1;  // chosen: a hard edge at N.L = 0 errs by up to 0.49 there

void check_sum(const char* field, double sum) {
  if (sum > kShadeMax + kSumTolerance) throw BadArgument(field, fmt::format("at most {}", kShadeMax), number_text(sum));
}

// The normal that texel (row, column) of a face stands for.
Vec3 texel_normal(int face, int row, int column) {
  const auto coordinate = [](int texel) { return 2.0 * texel / (wire::kReflectanceSize - 1) - 1; };
  const double major = face % 2 == 0 ? 1 : -1, b = coordinate(column), c = coordinate(row);
  switch (face / 2) {
    case 0: return normalise({major, b, c});
    case 1: return normalise({b, major, c});
    default: return normalise({b, c, major});
  }
}

double reflected_unit(const Phong& phong, Vec3 normal, Vec3 light, Vec3 towards_eye) {
  const double facing = dot(normal, light);
  if (facing <= 0) return 0;
  const double mirrored = dot(2 * facing * normal - light, towards_eye);
  const double fade = std::min(facing / kTerminatorWidth, 1.0);
  const double highlight = mirrored > 0 ? std::pow(mirrored, phong.shininess) : 0;
  return phong.diffuse * facing + phong.specular * fade * highlight;
}

Vec3 unit_light(Vec3 light, Vec3 towards_eye) { return light == Vec3{} ? towards_eye : unit(light); }

}  // namespace

void check(const Phong& phong) {
  expect_within("phong.ambient", phong.ambient, 0, kShadeMax);
  expect_within("phong.diffuse", phong.diffuse, 0, kShadeMax);
  expect_within("phong.specular", phong.specular, 0, kShadeMax);
  expect_within("phong.shininess", phong.shininess, 1, 1000);
  check_sum("phong.ambient + phong.diffuse", phong.ambient + phong.diffuse);
  check_sum("phong.diffuse + phong.specular", phong.diffuse + phong.specular);
}

void check(const Shading& shading) {
  check(shading.phong);
  expect_finite("light", shading.light);
}

double reflected(const Phong& phong, Vec3 normal, Vec3 light, Vec3 towards_eye) {
  return reflected_unit(phong, normal, unit_light(light, towards_eye), towards_eye);
}

std::vector<std::uint8_t> reflectance_map(const Phong& phong, Vec3 light, Vec3 towards_eye) {
  const Vec3 unit_l = unit_light(light, towards_eye);
  std::vector<std::uint8_t> map;
  map.reserve(wire::kReflectanceBytes);
  for (int face = 0; face < wire::kReflectanceFaces; ++face) {
    for (int row = 0; row < wire::kReflectanceSize; ++row) {
      for (int column = 0; column < wire::kReflectanceSize; ++column) {
        const double shade = reflected_unit(phong, texel_normal(face, row, column), unit_l, towards_eye);
        map.push_back(static_cast<std::uint8_t>(std::clamp<long>(std::lround(wire::kShadeOne * shade), 0, 255)));
      }
    }
  }
  return map;
}

}  // namespace gicube
