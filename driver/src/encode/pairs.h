// Pairs of elements as the board's words, and pairs with nothing between them: what the empty flags prove, so that no
// ray need be sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gicube/pair.h"
#include "gicube/ray.h"
#include "gicube/wire/pair.h"

namespace gicube {

// Throw BadArgument naming the field: "elements[3]: expected an element in the volume, got one from (1, 2, 30) to (1,
// 2, 40)".
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
                       const PairRequest& request, Vec3 spacing, Dims dims);

// Sums up the traced rays. `opacity`: of each ray that there is.
std::vector<PairFactor> sum_up(std::span<const double> weights, std::span<const TracedRay> rays, std::uint32_t samples);

// The blocks of a volume and which of them hold nothing visible.
struct BlockFlags {
  Dims blocks{};
  int block_voxels = 0;
  std::span<const std::uint8_t> empty;  // one a block, x fastest; nonzero = every sample in it is invisible
};

// Whether every sample of every ray between the two elements lies in blocks flagged empty. The rays' hull is taken as
// that of the elements' axis-parallel bounds, widened by what the board's fixed-point steps of `step` voxels can stray,
// so that false may come back for a clear path, and true never for another.
bool is_clear(const wire::Element& a, const wire::Element& b, const BlockFlags& flags, double step);

// The sum that the DSP would make of such a pair, to the bit: every ray comes back with opacity 0.
PairFactor clear_factor(const wire::Element& a, const wire::Element& b, std::uint32_t id, const PairRequest& request,
                        Vec3 spacing);

}  // namespace gicube
