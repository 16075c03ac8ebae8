// Parts of the results of several commands: ledgers of light, rays for the host, blocks for which rays wait.
#include "card.h"
#include "gicube/wire/trap.h"

namespace gicube::emu {

namespace {

wire::LightingLedger ledger_of(std::size_t word, const RayCounters& counts, bool light_in_solid) {
  const EnergyCounters& energy = counts.energy_of(word);
  wire::LightingLedger ledger;
  ledger.rays = counts.lighting_rays;
  ledger.emitted = energy.emitted;
  ledger.deposited = energy.deposited.kept;
  ledger.escaped = energy.escaped;
  ledger.escaped_by_face = energy.escaped_by_face;
  ledger.scattered_away = energy.scattered_away;
  ledger.given_up = energy.given_up;
  ledger.clipped = energy.deposited.clipped;
  ledger.light_in_solid = light_in_solid ? 1 : 0;
  return ledger;
}

}  // namespace

// Adds one ledger for each irradiance word.
void Card::add_ledger(CommandResult& result, const RayCounters& counts, bool light_in_solid) const {
  for (std::size_t word = 0; word < config.asic().irradiance_words(); ++word) {
    const std::vector<std::uint8_t> bytes = wire::encoded(ledger_of(word, counts, light_in_solid));
    result.payload.insert(result.payload.end(), bytes.begin(),
                          bytes.begin() + static_cast<std::ptrdiff_t>(wire::lighting_ledger_bytes(minor_version)));
  }
  result.up_bytes = result.payload.size();
}

// Sends at most `max_rays` of the waiting rays to the host. If none waits, no list is appended.
void Card::add_trap_list(CommandResult& result, std::size_t max_rays) {
  host_traps.settle();
  if (host_traps.waiting() == 0) return;
  const std::vector<wire::TrappedRay> rays = host_traps.take(max_rays);
  wire::append(result.payload, wire::TrapListHeader{static_cast<std::uint32_t>(rays.size()),
                                                    static_cast<std::uint32_t>(host_traps.waiting())});
  for (const wire::TrappedRay& ray : rays) wire::append(result.payload, ray);
  result.up_bytes = result.payload.size();
  result.returns_rays = !rays.empty();
  const std::uint64_t cycles = dsp_cycles(rays.size() * kPassRay.interval());
  result.dsp_cycles += cycles;
  if (result.asic_ps != 0) result.asic_ps += cycles_to_ps(cycles, config.dsp().clock_khz());
  host_traps_total += rays.size();
}

// Appends the blocks for which rays wait and the number of host deposits to the result. Appends nothing if there are
// none.
void Card::add_waiting(CommandResult& result) {
  HostDeposits& deposits = aperture.host_deposits();
  deposits.settle();
  host_deposits_total += deposits.count();
  if (waiting_rays.count() == 0 && deposits.count() == 0) return;
  const auto blocks = waiting_rays.by_block();
  wire::append(result.payload, wire::WaitingHeader{static_cast<std::uint32_t>(blocks.size()),
                                                   static_cast<std::uint32_t>(waiting_rays.count()),
                                                   static_cast<std::uint32_t>(deposits.count())});
  for (const wire::WaitingBlock& block : blocks) wire::append(result.payload, block);
  result.up_bytes = result.payload.size();
  const std::size_t added = waiting_rays.added();
  waits_total += added;
  for (const wire::WaitingBlock& each : blocks) {
    min_block_loads += waiting_rays.note_wait(each.block, aperture.volume().block_count()) ? 1 : 0;
  }
  if (result.asic_ps == 0) result.dsp_cycles += dsp_cycles(added * kPassRay.interval());
}

}  // namespace gicube::emu
