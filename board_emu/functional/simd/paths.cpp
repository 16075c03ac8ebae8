// Compiled once for each instruction set of Highway (foreach_target); the host's best is chosen at run time.
#include "words/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "functional/simd/paths.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <new>
#include <vector>

#include "datapath/illuminate.h"
#include "datapath/interaction.h"
#include "datapath/one_lane.h"
#include "datapath/random_stream.h"
#include "datapath/ray_interval.h"
#include "functional/functional.h"
#include "simd_tracer.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

void trace_all_paths(std::span<TracedPath> paths, const Frame& frame, const PacketField&, RayCounters& counters) {
  for (TracedPath& path : paths) trace_path(path, frame, counters);
}

#else

#include "functional/simd/path_scheduler-inl.h"

template <PathKind kKind, bool kWide>
void trace_paths_with(PathScheduler& scheduler, const PacketField& field, RayCounters& counters) {
  scheduler.run<PathLanes>([&](PathLanes& lanes, std::size_t enough) {
    march<kKind, kWide>(lanes, scheduler.seen(), field, enough, counters);
  });
  scheduler.finish_colours(field);
}

template <PathKind kKind>
void trace_paths_of(PathScheduler& scheduler, const PacketField& field, RayCounters& counters) {
  return field.frame->wide ? trace_paths_with<kKind, true>(scheduler, field, counters)
                           : trace_paths_with<kKind, false>(scheduler, field, counters);
}

void trace_all_paths(std::span<TracedPath> paths, const Frame& frame, const PacketField& field, RayCounters& counters) {
  if (paths.empty()) return;
  const PathKind kind = kind_of(paths.front().ray_state, frame);
  PathScheduler scheduler(paths, kind, frame, counters);
  switch (kind) {
    case PathKind::kWeighted: return trace_paths_of<PathKind::kWeighted>(scheduler, field, counters);
    case PathKind::kColouredWeighted: return trace_paths_of<PathKind::kColouredWeighted>(scheduler, field, counters);
    case PathKind::kPhoton: return trace_paths_of<PathKind::kPhoton>(scheduler, field, counters);
    case PathKind::kRendering: return trace_paths_of<PathKind::kRendering>(scheduler, field, counters);
  }
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

HWY_EXPORT(trace_all_paths);

namespace {

LightField light_field(const Frame& frame) {
  LightField out{};
  if (frame.lights() && frame.rules == wire::EnergyRules::kConserving) {
    out.runs = frame.depths->runs().data();
    out.opaque_up = frame.depths->opaque_up().data();
    out.sums = frame.depths->sums().data();
  }
  out.high_albedo = frame.high_albedo;
  out.cubes = frame.spacing[0] == frame.spacing[1] && frame.spacing[1] == frame.spacing[2];
  for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
    const wire::Material& material = frame.materials[tag];
    out.kind[tag] = reflects(material.bsdf)              ? LightField::kSurface
                    : material.bsdf == wire::Bsdf::kTrap ? LightField::kTrap
                    : material.bsdf == wire::Bsdf::kNone ? LightField::kStraight
                                                         : LightField::kMedium;
    const bool may_scatter = frame.lights() || (frame.scatter && (material.flags & wire::kScattersRenderingRays) != 0 &&
                                                material.bsdf != wire::Bsdf::kNone);
    const std::uint32_t scattering = may_scatter ? material.scattering : 0;
    out.scattering[tag] = scattering / double{wire::kScatteringOne};
    out.kept[tag] = static_cast<std::int32_t>(wire::kScatteringOne - scattering);
    out.scatters = out.scatters || scattering != 0;
  }
  return out;
}

}  // namespace

void SimdTracer::trace_paths(std::span<TracedPath> paths, const Frame& frame, RayCounters& counters) const {
  PacketField field = field_of(frame);
  const LightField light = light_field(frame);
  field.light = &light;
  HWY_DYNAMIC_DISPATCH(trace_all_paths)(paths, frame, field, counters);
}

}  // namespace gicube::emu
#endif
