// Compiled once for each instruction set of Highway (foreach_target); the host's best is chosen at run time.
#include "words/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "functional/simd/flights.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include "datapath/ray_part.h"
#include "flight_scheduler-inl.h"
#include "functional/flight.h"
#include "simd_tracer.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

void fly_all(std::span<Flight> flights, const Frame& frame, const PacketField&, RayCounters& counters) {
  for (Flight& flight : flights) fly(flight, frame, counters);
}

#else

template <FlightKind kKind, bool kWide>
void fly_with(FlightScheduler& scheduler, const PacketField& field, RayCounters& counters) {
  const std::size_t count = hn::Lanes(D32());
  FlightLanes lanes{};
  while (true) {
    scheduler.serve(lanes, count);
    if (scheduler.busy() == 0) break;
    const std::size_t enough =
        scheduler.has_more() ? std::max<std::size_t>(count / 4, 1) : count - scheduler.busy() + 1;
    march<kKind, kWide>(lanes, scheduler.seen(), field, enough, counters);
  }
  scheduler.finish_colours(field);
}

template <FlightKind kKind>
void fly_kind(FlightScheduler& scheduler, const PacketField& field, RayCounters& counters) {
  return field.wide ? fly_with<kKind, true>(scheduler, field, counters)
                    : fly_with<kKind, false>(scheduler, field, counters);
}

void fly_all(std::span<Flight> flights, const Frame& frame, const PacketField& field, RayCounters& counters) {
  if (flights.empty()) return;
  const FlightKind kind = kind_of(flights.front().ray_state, frame);
  FlightScheduler scheduler(flights, kind, frame, counters);
  switch (kind) {
    case FlightKind::kBundle: return fly_kind<FlightKind::kBundle>(scheduler, field, counters);
    case FlightKind::kColouredBundle: return fly_kind<FlightKind::kColouredBundle>(scheduler, field, counters);
    case FlightKind::kPhoton: return fly_kind<FlightKind::kPhoton>(scheduler, field, counters);
    case FlightKind::kRendering: return fly_kind<FlightKind::kRendering>(scheduler, field, counters);
  }
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

HWY_EXPORT(fly_all);

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

void SimdTracer::fly(std::span<Flight> flights, const Frame& frame, RayCounters& counters) const {
  PacketField field = field_of(frame);
  const LightField light = light_field(frame);
  field.light = &light;
  HWY_DYNAMIC_DISPATCH(fly_all)(flights, frame, field, counters);
}

}  // namespace gicube::emu
#endif
