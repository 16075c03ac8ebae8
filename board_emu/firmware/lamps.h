// Light sources that scattered rays can hit after they leave the volume [P §3.4]: rectangles and spheres in the DSP's
// memory [H940-H944].
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gicube/archive.h"
#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "levels/dsp_task.h"
#include "words/vectors.h"

namespace gicube::emu {

// A ray, and its work before the first lamp. Position and direction in physical lengths (3 products of 16 by 16 bits, 3
// shifts, 3 sums); its transmittance times a colour (3 products of 32 by 16 bits, each 2 multiplications and 2
// operations), 3 sums and 3 bounds. 2 operations test whether it was scattered and has left. 4 words of the ray and 3
// of the colour are read.
inline constexpr DspLoop kLookForLamps{"ray that looks for lamps", 3 + 6, 3 + 3 + 6 + 3 + 3 + 2, 4 + 3};
// One lamp, at the cost of the more expensive kind. Rectangle: from its corner to the ray's position (3 sums); that and
// the direction along its normal (6 products, 4 sums); a reciprocal by table and one Newton step (normalisation 4, 1
// access, 2 products); the distance (1 product); the intersection with the plane (3 products, 3 sums); its coordinates
// along the two edges (6 products, 4 sums); 7 comparisons: side, distance, nearest, two per coordinate. 18 products of
// 32 by 16 bits, each 2 multiplications and 2 operations; a record of 16 words. A sphere takes 13 products, and a root
// instead of the reciprocal.
inline constexpr DspLoop kTestLamp{"lamp", 18 * 2, 18 * 2 + 3 + 4 + 4 + 3 + 4 + 7, 16 + 1};

class Lamps {
 public:
  Lamps() = default;
  // `spacing` as in Frame::spacing. The records must be valid.
  Lamps(std::span<const wire::Lamp> lamps, const std::array<std::uint32_t, 3>& spacing);

  // Returns the error of a record, or nothing if it is valid.
  static std::optional<std::string> fault(const wire::Lamp& lamp);

  bool empty() const { return lamps_.empty(); }
  // Cost of finding the lamp that a returned ray hits. It is zero if the ray was not scattered or has not left the
  // volume.
  DspTask task(const wire::Ray& ray) const;
  // Returns the ray with the light of the lamp that it hits.
  wire::Ray seen_by(wire::Ray ray) const;
  void state(Archive& archive) {
    archive.list("shapes", lamps_, wire::kMaxLamps);
    archive("spacing", spacing_);
  }

 private:
  struct Shape {
    bool sphere = false;
    Vector colour{};  // 4095 = full
    Vector place{};   // physical: a corner or the centre
    Vector normal{}, along_u{}, along_v{};
    double radius = 0;

    void state(Archive::Record& record) { record(sphere, colour, place, normal, along_u, along_v, radius); }
  };

  static bool looks(const wire::Ray& ray) { return ray.generation != 0 && ray.contribution != 0; }
  // Distance from `start` along `direction` to the shape; negative: no hit.
  static double distance(const Shape& shape, const Vector& start, const Vector& direction);

  std::vector<Shape> lamps_;
  Vector spacing_{};
};

}  // namespace gicube::emu
