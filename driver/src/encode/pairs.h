// Converts pairs of elements to the board's records. Sums up pairs whose path the empty flags prove to be clear,
// without rays.
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

// A kPairs command for these pairs, with the elements that they refer to.
std::vector<std::uint8_t> pairs_command(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                        const PairRequest& request);

PairFactor from_wire(const wire::PairResult& result);

// The DSP's work done on the host: rays of type kOpacity for these pairs, and the weight of each sample (0: it has no
// ray).
struct PairRaysMade {
  std::vector<HostRay> rays;
  std::vector<double> weights;  // PairRequest::rays for each pair
};
PairRaysMade make_rays(std::span<const Element> elements, std::span<const ElementPair> pairs,
                       const PairRequest& request, Vec3 spacing, Dims dims);

// Sums up the traced rays, one for each weight that is not 0. `samples`: weights per pair.
std::vector<PairFactor> sum_up(std::span<const double> weights, std::span<const TracedRay> rays, std::uint32_t samples);

// The blocks of a volume and their empty flags.
struct BlockFlags {
  Dims blocks{};
  int block_voxels = 0;
  std::span<const std::uint8_t> empty;  // one per block, x fastest; nonzero: all samples in it are invisible
};

// Whether all samples of all rays between the two elements are in blocks with the empty flag. Conservative: tests the
// hull of the elements' axis-parallel bounds, widened by the rounding of the board's steps of `step` voxels. So it can
// be false for a clear path, but never true for another.
bool is_clear(const wire::Element& a, const wire::Element& b, const BlockFlags& flags, double step);

// The factor of a clear pair, with the bits that the DSP would get: all rays return with opacity 0.
PairFactor clear_factor(const wire::Element& a, const wire::Element& b, std::uint32_t id, const PairRequest& request,
                        Vec3 spacing);

}  // namespace gicube
