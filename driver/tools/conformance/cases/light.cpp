// Lights, scattering, pictures lit by irradiance, and rays that wait for the host.
#include <cmath>
#include <numbers>

#include "gicube/wire/material.h"
#include "gicube/wire/trap.h"
#include "tools/conformance/host.h"
#include "tools/conformance/scene.h"

namespace gicube::conformance {
namespace {

wire::IlluminateCommand sunlight(double energy, const Vector& towards_light) {
  wire::IlluminateCommand light;
  light.kind = wire::LightKind::kDirectional;
  light.energy = energy;
  light.u = towards_light;
  return light;
}

wire::LightingLedger ledger_of(const Bytes& bytes) {
  check(bytes.size() >= wire::kLightingLedgerBytes, "expected a ledger of 112 bytes, got {}", bytes.size());
  return wire::decode<wire::LightingLedger>(bytes);
}

void check_balance(const wire::LightingLedger& ledger) {
  check_same("deposited + escaped + scattered away + clipped",
             ledger.deposited + ledger.escaped + ledger.scattered_away + ledger.clipped, ledger.emitted);
  std::uint64_t faces = 0;
  for (const std::uint64_t face : ledger.escaped_by_face) faces += face;
  check_same("the sum of the six faces", faces, ledger.escaped);
}

void set_material(Host& host, wire::Bsdf bsdf, double scattering, std::uint8_t routine = 0) {
  wire::Material material;
  material.bsdf = bsdf;
  material.scattering = static_cast<std::uint16_t>(scattering * wire::kScatteringOne);
  material.routine = routine;
  host.write_memory(wire::kMaterials.base, wire::encoded(material));
}

constexpr Case kCases[] = {
    {2, "light.directional", "P1804",
     [](Host& host) {
       fog(host, {11, 11, 11}, 0);
       const auto straight = ledger_of(host.run(wire::encoded(sunlight(100, {0, 0, -1}))));
       check_near("emitted", static_cast<double>(straight.emitted), 100 * 100, 100);
       check_same("escaped at z = size - 1", straight.escaped_by_face[5], straight.emitted);
       check_balance(straight);
       const auto slanted = ledger_of(host.run(wire::encoded(sunlight(100, {-0.6, 0, -0.8}))));
       check_near("emitted", static_cast<double>(slanted.emitted), 100 * (80 + 60), 140);
       check_balance(slanted);
     }},
    {2, "light.point", "P1805",
     [](Host& host) {
       fog(host, {11, 11, 11}, 0);
       wire::IlluminateCommand light;
       light.energy = 30'000;
       light.position = {5, 5, 5};
       light.rays_per_voxel = 4;
       light.count = 4;
       const auto ledger = ledger_of(host.run(wire::encoded(light)));
       check_near("emitted", static_cast<double>(ledger.emitted), 30'000, 600);
       for (const std::uint64_t face : ledger.escaped_by_face)
         check_near("escaped by a face", static_cast<double>(face), 5000, 300);
       check_balance(ledger);
       light.position = {5, 5, -20};
       const auto outside = ledger_of(host.run(wire::encoded(light)));
       // The solid angle of a square of edge 10 at a distance of 20.
       const double share = 4 * std::asin(25.0 / (25 + 400)) / (4 * std::numbers::pi);
       check_near("emitted from outside", static_cast<double>(outside.emitted), 30'000 * share, 0.06 * 30'000 * share);
     }},
    {2, "light.solid", "P1801",
     [](Host& host) {
       const Volume volume = fog(host, {9, 9, 9}, wire::kClassifiedOpacityOne);
       const auto ledger = ledger_of(host.run(wire::encoded(sunlight(20, {0, 0, -1}))));
       check_same("escaped from an opaque volume", ledger.escaped, 0u);
       check_same("deposited", ledger.deposited, ledger.emitted);
       const Bytes words = host.read_memory(wire::kIrradiance.base, 4);
       check(wire::load<std::uint32_t>(words, 0) > 0, "expected light on the face that the light shines at");
       const std::size_t n = static_cast<std::size_t>(volume.block());
       const Bytes deep = host.read_memory(wire::kIrradiance.base + 4 * (4 + n * (4 + n * 4)), 4);
       check_same("light behind an opaque face", wire::load<std::uint32_t>(deep, 0), 0u);
     }},
    {2, "light.old_ledger", "P1503",
     [](Place& place) {
       wire::VersionInfo mine = host_version();
       mine.minor = 1;
       Host host(place, mine);
       fog(host, {9, 9, 9}, 0);
       const std::size_t lights = host.read_register(reg::kIrradianceWords) == 3 ? 3 : 1;
       check_same("bytes of a ledger", host.run(wire::encoded(sunlight(20, {0, 0, -1}))).size(), 64 * lights);
     }},
    {2, "light.seed", "P1806",
     [](Host& host) {
       const Volume volume = fog(host, {9, 9, 9}, 6000);
       const auto light = [&](std::uint32_t seed) {
         host.write_register(reg::kControl, wire::kControlClearIrradiance);
         host.write_register(reg::kSeed, seed);
         host.run(wire::encoded(sunlight(37.5, {0.3, 0.2, -1})));
         return host.read_memory(wire::kIrradiance.base, 4 * 512);
       };
       const Bytes first = light(1);
       check(light(1) == first, "expected the same light with the same seed");
       check(light(2) != first, "expected other light with another seed");
     }},
    {2, "light.rounds", "P1807",
     [](Host& host) {
       fog(host, {9, 9, 9}, 6000);
       wire::IlluminateCommand light = sunlight(100, {0.2, 0.1, -1});
       light.rays_per_voxel = light.count = 4;
       const auto whole = ledger_of(host.run(wire::encoded(light)));
       wire::LightingLedger sum;
       light.count = 2;
       for (const std::uint32_t first : {0u, 2u}) {
         light.first = first;
         wire::add(ledger_of(host.run(wire::encoded(light))), sum);
       }
       check_same("rays", sum.rays, whole.rays);
       check_same("emitted", sum.emitted, whole.emitted);
       check_same("deposited", sum.deposited, whole.deposited);
     }},
    {2, "light.refused", "P411",
     [](Host& host) {
       fog(host, {9, 9, 9}, 0);
       const auto refused = [&host](auto field, auto value, const char* word) {
         wire::IlluminateCommand light = sunlight(10, {0, 0, -1});
         light.*field = value;
         host.refused(light, word);
       };
       using Light = wire::IlluminateCommand;
       refused(&Light::kind, static_cast<wire::LightKind>(4), "kind");
       refused(&Light::albedo, static_cast<wire::Albedo>(2), "albedo");
       refused(&Light::rules, static_cast<wire::EnergyRules>(2), "rules");
       refused(&Light::rays_per_voxel, 0u, "rays_per_voxel");
       refused(&Light::energy, -1.0, "energy");
     }},
    {2, "light.scattering", "P1808",
     [](Host& host) {
       fog(host, {17, 17, 17}, 6554);
       const auto light = [&](double scattering) {
         set_material(host, wire::Bsdf::kIsotropic, scattering);
         wire::IlluminateCommand command = sunlight(60, {0, 0, -1});
         command.rays_per_voxel = command.count = 4;
         host.write_register(reg::kControl, wire::kControlClearIrradiance);
         const auto ledger = ledger_of(host.run(wire::encoded(command)));
         check_balance(ledger);
         return ledger;
       };
       const auto none = light(0), some = light(0.7), all = light(1);
       const auto share = [](std::uint64_t part, const wire::LightingLedger& of) {
         return static_cast<double>(part) / static_cast<double>(of.emitted);
       };
       check_near("escaped without scattering", share(none.escaped, none), 1 - opacity_after(16, 6554), 0.02);
       check(share(some.deposited, some) < share(none.deposited, none) - 0.1, "expected less absorbed with scattering");
       check_same("deposited with Ks = 1", all.deposited, 0u);
       check(some.escaped_by_face[4] > 0 && none.escaped_by_face[4] == 0,
             "expected light to come back by scattering only");
     }},
    {2, "light.picture", "P1809",
     [](Host& host) {
       const Volume volume = fog(host, {8, 8, 8}, wire::kClassifiedOpacityOne);
       const std::size_t n = static_cast<std::size_t>(volume.block());
       const bool wide = host.read_register(reg::kDatapath) == static_cast<std::uint32_t>(wire::Datapath::kWide);
       Bytes light(4 * n * n * n);
       for (std::size_t i = 0; i < n * n * n; ++i)
         wire::store(std::span(light), 4 * i, std::uint32_t{600} << (wide ? 16 : 0));
       for (std::size_t word = 0; word < host.read_register(reg::kIrradianceWords); ++word) {
         host.write_memory(wire::irradiance_region(word).base, light);
       }
       host.write_register(reg::kPipeline, wire::kPipelineIrradiance);
       for (const double brightness : {0.25, 0.5, 0.8}) {
         host.write_register(reg::kExposure, static_cast<std::uint32_t>(std::lround(brightness * 65536 / 600)));
         const wire::Pixel pixel = render(host, along(2, true, volume, 1, 1, 7)).at(0);
         check_near("red", pixel.red, 255 * brightness, 2);
         check_near("green", pixel.green, 127.5 * brightness, 2);
         check_same("blue", pixel.blue, std::uint8_t{0});
       }
     }},
    {2, "material.refused", "P1206",
     [](Host& host) {
       fog(host, {9, 9, 9}, 6000);
       set_material(host, static_cast<wire::Bsdf>(9), 0.5);
       check_same("STATUS", host.read_register(reg::kStatus), 0u);
       host.refused(sunlight(20, {0, 0, -1}), "material 0");
       host.refused(sunlight(20, {0, 0, -1}), "bsdf");
     }},
    {2, "trap.host", "P421",
     [](Host& host) {
       if (host.read_register(reg::kIrradianceWords) == 3)
         return;  // such boards refuse it (docs/reference/hardware.md)
       fog(host, {9, 9, 9}, 20'000);
       set_material(host, wire::Bsdf::kTrap, 1, wire::kHostRoutine);
       const Bytes first = host.run(wire::encoded(sunlight(100, {0, 0, -1})));
       check_same("bytes of the completion", first.size(), wire::kLightingLedgerBytes + wire::kTrapListHeaderBytes);
       const auto began = ledger_of(first);
       auto list = wire::decode<wire::TrapListHeader>(std::span(first).subspan(wire::kLightingLedgerBytes));
       check_same("rays in the first list", list.count, 0u);
       check(list.waiting > 10, "expected rays that wait, got {}", list.waiting);
       std::uint64_t accounted = began.deposited + began.escaped + began.scattered_away + began.clipped;
       std::vector<wire::Ray> answers;
       for (int round = 0; list.waiting + list.count > 0 && round < 1000; ++round) {
         wire::ResumeHeader resume;
         resume.count = static_cast<std::uint32_t>(answers.size());
         resume.max_rays = 50;
         Bytes command = wire::encoded(resume);
         for (const wire::Ray& ray : answers) wire::append(command, ray);
         answers.clear();
         const Bytes bytes = host.run(command);
         const auto ledger = ledger_of(bytes);
         accounted += ledger.deposited + ledger.escaped + ledger.scattered_away + ledger.clipped;
         if (bytes.size() == wire::kLightingLedgerBytes) {
           list = {};
           break;
         }
         const auto rest = std::span(bytes).subspan(wire::kLightingLedgerBytes);
         list = wire::decode<wire::TrapListHeader>(rest);
         check(list.count <= 50, "expected at most 50 rays, got {}", list.count);
         check_same("bytes of the list", rest.size(), wire::kTrapListHeaderBytes + list.count * wire::kTrappedRayBytes);
         for (std::uint32_t i = 0; i < list.count; ++i) {
           const auto trapped =
               wire::decode<wire::TrappedRay>(rest.subspan(wire::kTrapListHeaderBytes + i * wire::kTrappedRayBytes));
           wire::Ray answer = trapped.ray;
           answer.direction = {0, 0, static_cast<std::int16_t>(wire::kVoxel)};
           wire::set_dropped_share(answer, 0);
           answers.push_back(answer);
         }
       }
       check_same("rays that still wait", list.waiting, 0u);
       check_same("energy of all ledgers", accounted, began.emitted);
     }},
};

}  // namespace

std::span<const Case> light_cases() { return kCases; }

}  // namespace gicube::conformance
