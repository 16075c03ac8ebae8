// Rays that the DSP makes between pairs of elements, and the sums that it makes of them [P §5.6].
#include <algorithm>
#include <iterator>
#include <limits>

#include "approximate/approximate_level.h"
#include "command_fault.h"
#include "commands.h"
#include "cycle/cycle_level.h"
#include "cycle/machine_counters.h"
#include "functional/functional_level.h"
#include "gicube/wire/pair.h"
#include "words/parallel_for.h"

namespace gicube::emu {

namespace {

using wire::ErrorCode;

constexpr std::size_t kRaysAtOnce = 65'536;  // chosen: rays in the DSP's memory between two runs of the ASIC

std::optional<std::string> fault_of_header(const wire::PairsHeader& header, std::size_t payload_bytes) {
  const std::uint64_t bytes = wire::kPairsHeaderBytes + std::uint64_t{header.elements} * wire::kElementBytes +
                              std::uint64_t{header.pairs} * wire::kPairBytes;
  if (payload_bytes != bytes) {
    return expected("payload",
                    "32 + 56 bytes for each of its " + std::to_string(header.elements) + " elements + 12 for each of " +
                        std::to_string(header.pairs) + " pairs",
                    payload_bytes);
  }
  if (header.rays < 1 || header.rays > wire::kMaxRaysPerPair) return expected("rays", "1..65536", header.rays);
  if (std::uint64_t{header.pairs} * header.rays > wire::kMaxPairRays) {
    return expected("pairs x rays", "at most 2^22", std::uint64_t{header.pairs} * header.rays);
  }
  if (header.first > std::numeric_limits<std::uint32_t>::max() - header.rays) {
    return expected("first", "below 2^32 - rays", header.first);
  }
  if (header.opacity < 1 || header.opacity > wire::kOpacityOne) {
    return expected("opacity", "1..2^24 - 1", header.opacity);
  }
  return std::nullopt;
}

// All points of an element lie in the volume if its corners do.
std::optional<std::string> fault_of_element(const wire::Element& element, const Point& extent) {
  if (element.kind > wire::ElementKind::kBox) {
    return expected("kind", "0 or 1", static_cast<std::uint64_t>(element.kind));
  }
  for (int corner = 0; corner < 8; ++corner) {
    const wire::Vector s{corner & 1 ? 1.0 : 0.0, corner & 2 ? 1.0 : 0.0, corner & 4 ? 1.0 : 0.0};
    const wire::Vector point = wire::point_of(element, s);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double last = extent[axis] / double{wire::kVoxel};
      if (!(point[axis] >= 0 && point[axis] <= last)) return "origin, u, v, w: expected corners in the volume";
    }
  }
  return std::nullopt;
}

struct Job {
  wire::PairsHeader header;
  std::vector<wire::Element> elements;
  std::vector<wire::Vector> normals;
  std::vector<wire::Pair> pairs;
  wire::Vector spacing{};
};

// The rays of some pairs, and their weights. A sample without weight is a ray without flags, which is not sent.
struct PairRays {
  std::vector<wire::Ray> rays;
  std::vector<double> weights;
};

void make(const Job& job, std::size_t begin, std::size_t end, PairRays& made) {
  made.rays.clear();
  made.weights.clear();
  for (std::size_t p = begin; p < end; ++p) {
    const wire::Pair& pair = job.pairs[p];
    for (std::uint32_t i = 0; i < job.header.rays; ++i) {
      const wire::PairSample sample =
          wire::pair_sample(job.elements[pair.a], job.elements[pair.b], {job.normals[pair.a], job.normals[pair.b]},
                            job.spacing, pair.id, job.header.seed, job.header.first + i);
      made.weights.push_back(sample.weight);
      wire::Ray ray;
      if (sample.weight > 0) ray = wire::segment_packet(sample.from, sample.to, pair.id);
      made.rays.push_back(ray);
    }
  }
}

void take(const Job& job, std::size_t begin, std::size_t end, const PairRays& made, std::span<std::uint8_t> out) {
  std::size_t at = 0;
  for (std::size_t p = begin; p < end; ++p) {
    wire::PairSum sum(job.header.rays);
    for (std::uint32_t i = 0; i < job.header.rays; ++i, ++at) {
      sum.add(i, made.weights[at], 1 - made.rays[at].opacity / double{wire::kOpacityOne});
    }
    wire::encode(sum.result(), out.subspan(p * wire::kPairResultBytes).first<wire::kPairResultBytes>());
  }
}

bool is_sent(const wire::Ray& ray) { return ray.flags != 0; }

struct PairCounts : RayCounters {
  std::uint64_t sent = 0;  // rays: samples of weight

  PairCounts& operator+=(const PairCounts& other) {
    RayCounters::operator+=(other);
    sent += other.sent;
    return *this;
  }
};

// All of it on the host's threads, each with pairs of its own.
PairCounts measure(const Job& job, const Frame& frame, const SimdTracer* packets, unsigned threads, Progress& work,
                   std::span<std::uint8_t> out) {
  constexpr std::size_t kRays = 2048;  // chosen: in a thread's cache
  const std::size_t run_pairs = std::max<std::size_t>(1, kRays / job.header.rays);
  const std::size_t runs = (job.pairs.size() + run_pairs - 1) / run_pairs;
  return parallel_for<PairCounts>(runs, threads, [&](std::size_t run, PairCounts& counts) {
    if (work.cancel) return;
    const std::size_t begin = run * run_pairs, end = std::min(begin + run_pairs, job.pairs.size());
    PairRays made;
    make(job, begin, end, made);
    std::vector<wire::Ray> rays;
    std::copy_if(made.rays.begin(), made.rays.end(), std::back_inserter(rays), is_sent);
    counts += PairCounts{trace(rays, frame, packets, 1)};
    counts.sent += rays.size();
    auto back = rays.begin();
    for (wire::Ray& ray : made.rays) {
      if (is_sent(ray)) ray = *back++;
    }
    take(job, begin, end, made, out);
    work.done += static_cast<std::uint32_t>(end - begin);
  });
}

}  // namespace

CommandResult DspCommands::pairs(std::span<const std::uint8_t> payload, Progress& work) {
  if (payload.size() < wire::kPairsHeaderBytes) return refuse(expected("payload", "at least 32 bytes", payload.size()));
  Job job;
  job.header = wire::decode_pairs(payload.first<wire::kPairsHeaderBytes>());
  if (const auto what = fault_of_header(job.header, payload.size())) return refuse(*what);
  if (!has_volume()) return refuse(kNoVolume);
  Frame frame = this->frame();
  set_opacity_rays(frame, job.header.opacity);
  for (std::size_t axis = 0; axis < 3; ++axis) job.spacing[axis] = frame.spacing[axis] / double{wire::kSpacingOne};
  std::size_t at = wire::kPairsHeaderBytes;
  for (std::uint32_t e = 0; e < job.header.elements; ++e, at += wire::kElementBytes) {
    job.elements.push_back(wire::decode_element(payload.subspan(at).first<wire::kElementBytes>()));
    if (const auto what = fault_of_element(job.elements[e], frame.extent)) {
      return refuse("element " + std::to_string(e) + ": " + *what);
    }
    job.normals.push_back(wire::normal_of(job.elements[e], job.spacing));
  }
  for (std::uint32_t p = 0; p < job.header.pairs; ++p, at += wire::kPairBytes) {
    job.pairs.push_back(wire::decode_pair(payload.subspan(at).first<wire::kPairBytes>()));
    if (job.pairs[p].a < job.header.elements && job.pairs[p].b < job.header.elements) continue;
    return refuse("pair " + std::to_string(p) + ": " +
                  expected("a, b", "elements below " + std::to_string(job.header.elements),
                           std::max(job.pairs[p].a, job.pairs[p].b)));
  }

  aperture_.decode(threads_, reads(frame));
  const v1::DspConfig& dsp = config_.dsp();
  // Made like lighting rays, from two points of a sequence; taken back like viewing rays, into a sum.
  const std::uint32_t make_cycles = dsp.lighting_ray_cycles(), take_cycles = dsp.returned_ray_cycles();
  CommandResult result;
  result.payload.resize(job.pairs.size() * wire::kPairResultBytes);
  result.up_bytes = std::max<std::uint64_t>(result.payload.size(), 4);
  work.all = job.header.pairs;
  pair_rays_ += std::uint64_t{job.header.pairs} * job.header.rays;
  if (config_.fidelity() == v1::functional) {
    const std::uint64_t rays = std::uint64_t{job.header.pairs} * job.header.rays;
    const PairCounts counts = measure(job, frame, packets(rays, frame), threads_, work, std::span(result.payload));
    if (work.cancel) return {.error = ErrorCode::kCancelled};
    rays_ += counts;
    result.dsp_cycles = rays * make_cycles + counts.sent * take_cycles;
    return result;
  }
  const std::size_t at_once = std::max<std::size_t>(1, kRaysAtOnce / job.header.rays);
  PairRays made;
  for (std::size_t begin = 0; begin < job.pairs.size(); begin += at_once) {
    const std::size_t end = std::min(begin + at_once, job.pairs.size());
    make(job, begin, end, made);
    const GivenRayBatch given{made.rays, true, make_cycles, take_cycles};
    const RunResult ran = in_turns(frame) ? emu::trace(given, frame, packets(made.rays.size(), frame), threads_,
                                                       pass_machine(), rays_, work)
                                          : emu::trace(given, frame, machine(), work);
    if (ran.cancelled) return cancelled();
    const CommandResult part = timed(ran);
    result.dsp_cycles += part.dsp_cycles;
    result.asic_ps += part.asic_ps;
    take(job, begin, end, made, result.payload);
    work.done = static_cast<std::uint32_t>(end);
  }
  return result;
}

}  // namespace gicube::emu
