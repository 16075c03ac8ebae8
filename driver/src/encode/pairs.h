// Pairs of elements as the board's words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gicube/pair.h"
#include "gicube/ray.h"
#include "gicube/wire/pair.h"

namespace gicube {

// Throw BadArgument naming the field: "elements[3]: expected its corners in the volume, got (1, 2, 40)".
void check(const PairRequest& request);
void check(const Element& element, std::size_t index, Dims dims);
void check(const ElementPair& pair, std::size_t index, std::size_t elements);

wire::Element to_wire(const Element& element);

// A kPairs command for these pairs, with the elements that they name.
std::vector<std::uint8_t> pairs_command(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                        const PairRequest& request);

PairFactor from_wire(const wire::PairResult& result);

// The DSP's part, on the host: rays of type kOpacity for these pairs, weights beside them (0: there is no ray).
struct PairRaysMade {
  std::vector<HostRay> rays;
  std::vector<double> weights;  // rays of the request for each pair
};
PairRaysMade make_rays(std::span<const Element> elements, std::span<const ElementPair> pairs,
                       const PairRequest& request, Vec3 spacing);

// What became of them, summed up. `opacity`: of each ray that there is.
std::vector<PairFactor> sum_up(std::span<const double> weights, std::span<const TracedRay> rays, std::uint32_t samples);

}  // namespace gicube
