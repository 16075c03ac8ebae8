// Rays that add to the volume: deposits of energy and backprojection.
#include <cmath>
#include <numeric>

#include "tools/conformance/host.h"
#include "tools/conformance/scene.h"
#include "tools/conformance/traced.h"

namespace gicube::conformance {
namespace {

using wire::RayType;

// A cube whose planes z < 3 are clear. The others have the opacity `alpha`.
Volume slab(Host& host, int edge, std::uint16_t alpha) {
  Volume volume(host, {edge, edge, edge});
  volume.fill([](int, int, int z) { return wire::Voxel{static_cast<std::uint16_t>(z < 3 ? 0 : 100)}; });
  host.write_register(reg::kPipeline, wire::kPipelineLeap);
  send_look(host, [alpha](std::uint32_t density, unsigned) {
    return Entry{{4095, 4095, 4095}, static_cast<std::uint16_t>(density >= 50 ? alpha : 0)};
  });
  return volume;
}

// A signed word of 36 bits.
std::int64_t sum_word(const Bytes& bytes, std::size_t i) {
  return static_cast<std::int64_t>(wire::load36(bytes, i) << 28) >> 28;
}

// Sum of a region's words over the voxels of the volume.
std::int64_t sum_of(Host& host, const Volume& volume, const wire::MemoryRegion& region) {
  const bool sums = region.base == wire::kSums.base;
  const auto n = static_cast<std::size_t>(volume.block());
  const std::size_t count = n * n * n * volume.blocks();
  const Bytes bytes = host.read_memory(region.base, sums ? wire::packed36_bytes(count) : 4 * count);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    sum += sums ? sum_word(bytes, i) : std::int64_t{wire::load<std::uint32_t>(bytes, 4 * i)};
  }
  return sum;
}

wire::Ray lamp_ray(std::uint32_t id, const Vector& position, const Vector& direction, double energy) {
  wire::Ray ray = host_ray(id, position, direction);
  ray.flags |= wire::kLightingRay;
  ray.lifetime = 8;
  ray.set_colour_word(static_cast<std::uint64_t>(energy * 4096));
  return ray;
}

wire::LightingLedger deposit(Host& host, const std::vector<wire::Ray>& rays) {
  const wire::TraceHeader header{.type = RayType::kDeposit, .rules = wire::EnergyRules::kConserving};
  const Bytes bytes = host.run(trace_command(header, rays));
  const std::size_t words = host.read_register(reg::kIrradianceWords);
  check_same("bytes of the ledgers", bytes.size(), words * wire::kLightingLedgerBytes);
  return wire::decode<wire::LightingLedger>(bytes);
}

wire::Ray back_ray(std::uint32_t id, const Vector& position, const Vector& direction, double length,
                   std::int32_t amount) {
  wire::Ray ray = segment(id, position, direction, length);
  ray.opacity = static_cast<std::uint32_t>(amount) & 0xFF'FFFF;
  return ray;
}

constexpr Case kCases[] = {
    {1, "sums.ray", "P1711",
     [](Host& host) {
       const Volume volume(host, {9, 9, 9});
       const wire::TraceHeader header{.type = RayType::kBackproject, .words = wire::SumWords::kWhole};
       const Bytes bytes = host.run(trace_command(
           header, {back_ray(1, {2, 3, 0.5}, {0, 0, 1}, 6, 1000), back_ray(2, {4.5, 3, 1}, {0, 1, 0}, 3, -77)}));
       check_same("bytes of the ledger", bytes.size(), wire::kDepositLedgerBytes);
       const auto ledger = wire::decode<wire::DepositLedger>(bytes);
       check_same("rays", ledger.rays, 2u);
       check_same("samples", ledger.samples, 9u);
       check_same("kept", ledger.kept, std::int64_t{6 * 1000 - 3 * 77});
       check_same("clipped", ledger.clipped, std::int64_t{0});
       check_same("the sum of all words", sum_of(host, volume, wire::kSums), ledger.kept);
       const auto n = static_cast<std::size_t>(volume.block());
       const auto word = [&](std::size_t x, std::size_t y, std::size_t z) {
         const std::size_t i = x + n * (y + n * z);
         return sum_word(host.read_memory(wire::kSums.base + i / 2 * 9, 9), i % 2);
       };
       for (std::size_t z = 1; z <= 6; ++z)
         check_same("a word on the first ray's way", word(2, 3, z), std::int64_t{1000});
       check_near("half a word on the second's", static_cast<double>(word(4, 4, 1)), -38.5, 38.5);
     }},
    {1, "sums.clear", "P1205",
     [](Host& host) {
       const wire::TraceHeader header{.type = RayType::kBackproject, .words = wire::SumWords::kWhole};
       for (const bool by_control : {true, false}) {
         const Volume volume(host, {9, 9, 9});
         host.run(trace_command(header, {back_ray(1, {2, 3, 0.5}, {0, 0, 1}, 6, 1000)}));
         check_same("the sums", sum_of(host, volume, wire::kSums), std::int64_t{6000});
         if (by_control) host.write_register(reg::kControl, wire::kControlClearSums);
         if (!by_control) host.write_register(reg::kVolumeX, 9);
         check_same("cleared sums", sum_of(host, volume, wire::kSums), std::int64_t{0});
       }
     }},
    {1, "sums.alignment", "P1205",
     [](Host& host) {
       const Volume volume(host, {9, 9, 9});
       for (const auto& [at, length] : {std::pair{0u, 8u}, std::pair{4u, 9u}}) {
         host.refused_request(FrameType::kMemoryRead, long_words({wire::kSums.base + at, length}),
                              ErrorCode::kBadAddress);
       }
     }},
    {2, "deposit.escapes", "P1801",
     [](Host& host) {
       const Volume volume = slab(host, 9, 0);
       const auto ledger =
           deposit(host, {lamp_ray(1, {4, 4, 1}, {0, 0, 1}, 200), lamp_ray(2, {4, 4, 1}, {0, -1, 0}, 55)});
       check_same("rays", ledger.rays, 2u);
       check_same("emitted", ledger.emitted, 255u);
       check_same("escaped", ledger.escaped, 255u);
       check_same("escaped at z = size - 1", ledger.escaped_by_face[5], 200u);
       check_same("escaped at y = 0", ledger.escaped_by_face[2], 55u);
       check_same("irradiance", sum_of(host, volume, wire::kIrradiance), std::int64_t{0});
     }},
    {2, "deposit.absorbs", "P1802",
     [](Host& host) {
       for (const std::uint16_t alpha : {std::uint16_t{3277}, std::uint16_t{13107}}) {
         const Volume volume = slab(host, 12, alpha);
         std::vector<wire::Ray> rays;
         for (std::uint32_t i = 0; i < 400; ++i)
           rays.push_back(lamp_ray(i, {1 + i % 20 * 0.45, 1 + i / 20 * 0.45, 0}, {0, 0, 1}, 50));
         const auto ledger = deposit(host, rays);
         check_same("emitted", ledger.emitted, 20'000u);
         check_same("sum of the ledger", ledger.deposited + ledger.escaped + ledger.scattered_away + ledger.clipped,
                    ledger.emitted);
         const double share = opacity_after(11 - 2.5, alpha);  // the medium begins between the planes 2 and 3
         check_near("deposited", static_cast<double>(ledger.deposited), 20'000 * share, 200);
         check_same("the sum of the words", sum_of(host, volume, wire::kIrradiance),
                    static_cast<std::int64_t>(ledger.deposited));
       }
     }},
    {2, "deposit.refused", "P1702",
     [](Host& host) {
       slab(host, 9, 0);
       const wire::TraceHeader header{.type = RayType::kDeposit};
       host.refused(trace_command(header, {lamp_ray(1, {4, 4, 1}, {0, 0, 1}, 0)}), "energy");
       host.refused(trace_command(header, {host_ray(1, {4, 4, 1}, {0, 0, 1})}), "flags");
     }},
    {2, "irradiance.words", "P1204",
     [](Host& host) {
       const Volume volume(host, {9, 9, 9});
       host.write_memory(wire::kIrradiance.base + 40, words({7, 2000}));
       check(host.read_memory(wire::kIrradiance.base + 36, 16) == words({0, 7, 2000, 0}),
             "expected the words that were written");
       host.write_memory(wire::kIrradiance.base + 2, Bytes(4, 1));
       check_same("STATUS", host.read_register(reg::kStatus), wire::kStatusBadAddress);
       host.write_register(reg::kControl, wire::kControlClearIrradiance);
       check(host.read_memory(wire::kIrradiance.base + 36, 16) == words({0, 0, 0, 0}),
             "expected bit 2 of CONTROL to clear");
     }},
    {2, "irradiance.saturates", "P1803",
     [](Host& host) {
       const Volume volume = slab(host, 9, wire::kClassifiedOpacityOne);
       const bool wide = host.read_register(reg::kDatapath) == static_cast<std::uint32_t>(wire::Datapath::kWide);
       const std::uint32_t most = wide ? ~0u : 2047;
       host.write_memory(wire::kIrradiance.base, words({~0u}));
       check_same("a word beyond its width", wire::load<std::uint32_t>(host.read_memory(wire::kIrradiance.base, 4), 0),
                  most);
       host.write_register(reg::kControl, wire::kControlClearIrradiance);
       std::vector<wire::Ray> rays;
       for (std::uint32_t i = 0; i < 40; ++i) rays.push_back(lamp_ray(i, {4, 4, 1}, {0, 0, 1}, 250));
       const auto ledger = deposit(host, rays);
       check_same("sum of the ledger", ledger.deposited + ledger.clipped, ledger.emitted);
       check((ledger.clipped > 0) == !wide, "expected clipped energy on the paper's datapath only, got {}",
             ledger.clipped);
       check_same("the sum of the words", sum_of(host, volume, wire::kIrradiance),
                  static_cast<std::int64_t>(ledger.deposited));
     }},
};

}  // namespace

std::span<const Case> deposit_cases() { return kCases; }

}  // namespace gicube::conformance
