// Materials, lights and the irradiance that they leave.
#include <algorithm>
#include <cmath>

#include "encode/lights.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/registers.h"
#include "lighting_ledger.h"
#include "state.h"

namespace gicube {
namespace {

namespace reg = wire::reg;

LitBox lit_box(const LoadedVolume& volume) {
  const Vec3 edge = volume.relative_spacing;
  return {{(volume.dims[0] - 1) * edge.x, (volume.dims[1] - 1) * edge.y, (volume.dims[2] - 1) * edge.z}, edge};
}

}  // namespace

void Board::set_material(const Material& material, int tag) {
  const auto lock = state_->begin();
  check(material);
  if (tag < 0 || tag >= wire::kTags) throw BadArgument("tag", "0..3", std::to_string(tag));
  state_->tables.set_material(material, tag);
  if (state_->volume) state_->tables.send_segmentation(state_->volume->range);  // gains depend on the scattering
}

void Board::State::set_lighting(const Illumination& settings) {
  device.set_register(reg::kStep, static_cast<std::uint32_t>(std::lround(settings.step * wire::kStepOne)));
  device.set_register(reg::kPipeline,
                      (settings.jitter ? wire::kPipelineJitter : 0u) | (settings.leap ? wire::kPipelineLeap : 0u));
  device.set_register(reg::kLifetime, static_cast<std::uint32_t>(settings.lifetime));
  device.set_register(reg::kSeed, settings.seed);
  device.set_register(reg::kCutPlanes, 0);  // they cut what the eye sees
}

LightingReport Board::illuminate(std::span<const Light> lights, const Illumination& settings,
                                 const Progress& progress) {
  const auto lock = state_->begin();
  for (std::size_t i = 0; i < lights.size(); ++i) check(lights[i], i);
  check(settings);
  const LoadedVolume& volume = state_->loaded("illuminate()");
  state_->need_routine(true);
  const LitBox box = lit_box(volume);
  LightingReport report;
  report.unit = lights.empty() ? 1 : energy_unit(lights, settings, box, state_->info.wide);

  state_->set_lighting(settings);
  const Picoseconds deadline = state_->deadline();
  state_->device.write_register(reg::kControl, wire::kControlClearIrradiance);
  state_->irradiance_unit = report.unit;
  double flux = 0;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const auto all = static_cast<std::uint32_t>(lights.size()), before = static_cast<std::uint32_t>(i);
    Progress part;
    if (progress) {  // each light an equal part of the whole
      part = [&progress, all, before](std::uint32_t done, std::uint32_t of) {
        constexpr std::uint32_t kParts = 1000;
        const std::uint32_t here = of > 0 ? static_cast<std::uint32_t>(std::uint64_t{kParts} * done / of) : 0;
        progress(before * kParts + here, all * kParts);
      };
    }
    const CommandResult result = state_->device.run(wire::encoded(light_command(lights[i], settings, report.unit)),
                                                    state_->watched(part), deadline);
    const std::span<const std::uint8_t> payload = result.payload;
    if (payload.size() < wire::kLightingLedgerBytes) state_->device.give_up("a lighting result of wrong size");
    const auto ledger = wire::decode<wire::LightingLedger>(payload);
    add(ledger, report);
    state_->scatter_waiting(payload.subspan(wire::kLightingLedgerBytes), [&report](wire::LightingLedger resumed) {
      resumed.emitted = 0;  // it was counted when its rays were made
      add(resumed, report);
    });
    flux += flux_in_the_middle(lights[i], settings, box);
    if (ledger.light_in_solid != 0) {
      report.warnings.push_back("lights[" + std::to_string(i) + "] stands in a solid: its light stays there");
    }
  }
  state_->bright_flux = flux;
  if (report.clipped > 0.01 * report.emitted) {
    report.warnings.push_back("more than 1% of the energy was clipped by saturated irradiance words");
  }
  if (settings.albedo == Albedo::kLow && settings.rules == EnergyRules::kAsPrinted &&
      report.scattered_away > 0.01 * report.emitted) {
    report.warnings.push_back("the printed rules of low albedo lost the energy that was scattered");
  }
  return report;
}

}  // namespace gicube
