// Rays that the DSP generates between pairs of elements, and the sums of their results [P §5.6].
#include <algorithm>
#include <limits>
#include <utility>

#include "command_fault.h"
#include "each_command.h"
#include "firmware/ray_sources/pair_rays.h"

namespace gicube::emu {

namespace {

void check_header(const wire::PairsHeader& header, std::size_t payload_bytes) {
  const std::uint64_t bytes = wire::kPairsHeaderBytes + std::uint64_t{header.elements} * wire::kElementBytes +
                              std::uint64_t{header.pairs} * wire::kPairBytes;
  if (payload_bytes != bytes) {
    refuse("payload",
           "32 + 56 bytes for each of its " + std::to_string(header.elements) + " elements + 12 for each of " +
               std::to_string(header.pairs) + " pairs",
           payload_bytes);
  }
  const std::uint64_t rays = std::uint64_t{header.pairs} * header.rays;
  expect(header.rays >= 1 && header.rays <= wire::kMaxRaysPerPair, "rays", "1..65536", header.rays);
  expect(rays <= wire::kMaxPairRays, "pairs x rays", "at most 2^22", rays);
  expect(header.first <= std::numeric_limits<std::uint32_t>::max() - header.rays, "first", "below 2^32 - rays",
         header.first);
  expect(header.opacity >= 1 && header.opacity <= wire::kOpacityOne, "opacity", "1..2^24 - 1", header.opacity);
}

void check_element(const wire::Element& element, const Point& extent) {
  expect(element.kind <= wire::ElementKind::kDisc, "kind", "0..3", static_cast<std::uint64_t>(element.kind));
  if (element.kind == wire::ElementKind::kDisc) {
    for (const float share : {element.w[0], element.w[1]}) {
      if (!(share >= 0 && share < 1)) refuse("w: expected shares of a disc, 0 or more and below 1");
    }
  }
  wire::Vector last{};
  for (std::size_t axis = 0; axis < 3; ++axis) last[axis] = extent[axis] / double{wire::kVoxel};
  if (!wire::lies_within(element, last)) refuse("origin, u, v, w: expected an element in the volume");
}

}  // namespace

CommandResult trace_pairs(Card& card, Payload payload, Progress& work) {
  PairJob job;
  job.header = header_of<wire::PairsHeader>(payload);
  check_header(job.header, payload.size());
  card.check_volume();
  card.check_all_there();
  Frame frame = card.frame();
  set_type(frame, {.type = wire::RayType::kOpacity, .opacity = job.header.opacity});
  for (std::size_t axis = 0; axis < 3; ++axis) job.spacing[axis] = frame.spacing[axis] / double{wire::kSpacingOne};
  std::size_t at = wire::kPairsHeaderBytes;
  for (std::uint32_t e = 0; e < job.header.elements; ++e, at += wire::kElementBytes) {
    job.elements.push_back(wire::decode<wire::Element>(payload.subspan(at)));
    check_part("element", e, [&] { check_element(job.elements[e], frame.extent); });
    job.normals.push_back(wire::normal_of(job.elements[e], job.spacing));
  }
  for (std::uint32_t p = 0; p < job.header.pairs; ++p, at += wire::kPairBytes) {
    job.pairs.push_back(wire::decode<wire::Pair>(payload.subspan(at)));
    if (job.pairs[p].a < job.header.elements && job.pairs[p].b < job.header.elements) continue;
    refuse("pair " + std::to_string(p) + ": a, b", "elements below " + std::to_string(job.header.elements),
           std::max(job.pairs[p].a, job.pairs[p].b));
  }

  card.expect_memory(frame);
  card.aperture.decode(card.threads, reads(frame));
  std::vector<std::uint8_t> results(job.pairs.size() * wire::kPairResultBytes);
  PairRays rays(job, results);
  if (!card.goes_on) card.pair_rays += rays.count();
  const RunResult ran = card.run_level(rays, frame, work);
  const std::uint64_t up_bytes = std::max<std::uint64_t>(results.size(), 4);
  return {.payload = std::move(results), .dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps, .up_bytes = up_bytes};
}

}  // namespace gicube::emu
