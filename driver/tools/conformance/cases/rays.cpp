// Rays of the host: the trace command and the pairs command.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "gicube/wire/pair.h"
#include "gicube/wire/ray.h"
#include "tools/conformance/host.h"
#include "tools/conformance/scene.h"
#include "tools/conformance/traced.h"

namespace gicube::conformance {
namespace {

using wire::RayType;

constexpr std::uint16_t kAlpha = 6554;  // a tenth

Volume fog(Host& host) { return fog(host, {17, 17, 17}, kAlpha); }
double opacity_after(double lengths) { return conformance::opacity_after(lengths, kAlpha); }

void check_opacity(const wire::Ray& ray, double expected) {
  check_near("a ray's opacity", ray.opacity / double{wire::kOpacityOne}, expected, 4e-5);
}

constexpr Case kCases[] = {
    {1, "ray.integrate", "P1703",
     [](Host& host) {
       fog(host);
       const auto rays = trace(host, {.type = RayType::kIntegrate},
                               {host_ray(1, {4, 4, 0}, {0, 0, 1}), host_ray(2, {5, 16, 4}, {0, -1, 0}),
                                host_ray(3, {6.5, 4, 4}, {1, 0, 0})});
       const double samples[] = {17, 17, 10};
       for (std::size_t i = 0; i < 3; ++i) {
         check_opacity(rays[i], opacity_after(samples[i]));
         check_near("red", rays[i].colour[0], 4095 * opacity_after(samples[i]), samples[i] / 2 + 1);
         check_near("green", rays[i].colour[1], 2048 * opacity_after(samples[i]), samples[i] / 2 + 1);
         check_same("blue", rays[i].colour[2], std::uint16_t{0});
       }
     }},
    {1, "ray.goes_on", "P1704",
     [](Host& host) {
       fog(host);
       wire::Ray ray = host_ray(1, {4, 4, 0}, {0, 0, 1});
       ray.opacity = 1 << 23;
       ray.colour = {1000, 0, 500};
       const wire::Ray back = trace(host, {.type = RayType::kIntegrate}, ray);
       check_opacity(back, 0.5 + 0.5 * opacity_after(17));
       check_near("red", back.colour[0], 1000 + 2047.5 * opacity_after(17), 10);
       check_same("blue", back.colour[2], std::uint16_t{500});
     }},
    {1, "ray.order", "P1701",
     [](Host& host) {
       fog(host);
       std::vector<wire::Ray> sent;
       Noise noise(9);
       for (std::uint32_t i = 0; i < 700; ++i) {
         const auto part = [&noise] { return noise.below(2001) / 1000.0 - 1.0004; };
         sent.push_back(host_ray(0xFFFF'0000u + 77 * i, {8 + 7 * part(), 8 + 7 * part(), 8 + 7 * part()},
                                 {part(), part(), part()}));
       }
       const auto back = trace(host, {.type = RayType::kIntegrate}, sent);
       for (std::size_t i = 0; i < sent.size(); ++i) {
         check_same("a ray's id", back[i].host_id(), sent[i].host_id());
         check_same("a ray's flags", int{back[i].flags}, int{wire::kHostRay});
         check(back[i].direction == sent[i].direction, "ray {}: expected its direction unchanged", i);
         check(back[i].opacity > 0, "ray {}: expected some opacity", i);
       }
       check(trace(host, {.type = RayType::kIntegrate}, std::vector<wire::Ray>{}).empty(), "expected no rays of none");
     }},
    {1, "ray.first_hit", "P1705",
     [](Host& host) {
       fog(host);
       for (const double asked : {0.05, 0.3, 0.7}) {
         const auto opacity = static_cast<std::uint32_t>(asked * wire::kOpacityOne);
         const wire::Ray ray =
             trace(host, {.type = RayType::kFirstHit, .opacity = opacity}, host_ray(5, {4, 4, 0}, {0, 0, 1}));
         const double samples = std::ceil(std::log(1 - asked) / std::log(1 - kAlpha / 65535.0));
         check_opacity(ray, opacity_after(samples));
         check_same("z of the hit", ray.position[2], static_cast<std::uint32_t>((samples - 1) * wire::kVoxel));
         check(ray.colour == std::array<std::uint16_t, 3>{}, "expected no colour of a first hit");
       }
       const wire::Ray miss =
           trace(host, {.type = RayType::kFirstHit, .opacity = wire::kOpacityOne}, host_ray(5, {4, 4, 0}, {0, 0, 1}));
       check_opacity(miss, opacity_after(17));
       check_same("z of a ray that hit nothing", miss.position[2], 16u * wire::kVoxel);
     }},
    {1, "ray.segment", "P1706",
     [](Host& host) {
       fog(host);
       for (const double length : {0.25, 3.0, 7.3, 12.0}) {
         for (const RayType type : {RayType::kSegment, RayType::kOpacity}) {
           const auto rays =
               trace(host, {.type = type, .opacity = wire::kOpacityOne},
                     {segment(1, {4, 4, 2}, {0, 0, 1}, length), segment(2, {4, 4, 2 + length}, {0, 0, -1}, length)});
           check_opacity(rays[0], opacity_after(length));
           check_same("a segment's opacity from its other end", rays[1].opacity, rays[0].opacity);
           const double red = type == RayType::kSegment ? 4095 * opacity_after(length) : 0;
           check_near("red", rays[0].colour[0], red, 8);
         }
       }
       const wire::TraceHeader opacity{.type = RayType::kOpacity, .opacity = wire::kOpacityOne};
       check_opacity(trace(host, opacity, segment(1, {4, 4, 2}, {1, 0, 0}, 0)), 0);
     }},
    {1, "ray.segment_stops", "P1707",
     [](Host& host) {
       fog(host);
       const auto opacity = static_cast<std::uint32_t>(0.25 * wire::kOpacityOne);
       const auto ray =
           trace(host, {.type = RayType::kOpacity, .opacity = opacity}, segment(1, {4, 4, 2}, {0, 0, 1}, 12));
       check_opacity(ray, opacity_after(3));
     }},
    {1, "ray.integral", "P1708",
     [](Host& host) {
       Volume volume(host, {17, 17, 17});
       volume.fill(
           [](int x, int y, int z) { return wire::Voxel{static_cast<std::uint16_t>(3 * x + 50 * y + 100 * z)}; });
       send_look(host, [](std::uint32_t, unsigned) { return Entry{}; });
       host.write_memory(wire::kEmptyFlags.base, {0xFF});
       const auto rays = trace(host, {.type = RayType::kIntegral},
                               {segment(1, {4, 2, 1}, {0, 0, 1}, 10), segment(2, {1.5, 3, 16}, {1, 0, 0}, 8)});
       double along_z = 0, along_x = 0;
       for (int i = 0; i < 10; ++i) along_z += 12 + 100 + 100 * (1.5 + i);
       for (int i = 0; i < 8; ++i) along_x += 150 + 1600 + 3 * (2 + i);
       check_near("the sum along z", static_cast<double>(rays[0].colour_word()), 8 * along_z, 5);
       check_near("the sum along x", static_cast<double>(rays[1].colour_word()), 8 * along_x, 4);
       check_same("its opacity", rays[0].opacity, 0u);
     }},
    {1, "ray.step", "P1706",
     [](Host& host) {
       fog(host);
       for (const std::uint32_t divisor : {1u, 2u, 8u}) {
         host.write_register(reg::kStep, wire::kStepOne / divisor);
         const auto ray = trace(host, {.type = RayType::kIntegral}, segment(1, {2, 2, 2}, {0, 1, 0}, 10.5));
         const double steps = std::ceil(10.5 * divisor);
         check_same("the sum of densities", ray.colour_word(), static_cast<std::uint64_t>(steps) * kFog * 8);
       }
     }},
    {1, "ray.refused", "P1702",
     [](Host& host) {
       const Volume volume = fog(host, {9, 9, 9}, kAlpha);
       const wire::Ray good = host_ray(1, {4, 4, 4}, {0, 0, 1});
       const auto refused = [&](const wire::TraceHeader& header, wire::Ray ray, const char* word) {
         host.refused(trace_command(header, {good, ray}), word);
       };
       const wire::TraceHeader integrate{.type = RayType::kIntegrate};
       wire::Ray ray = good;
       ray.position[1] = 9 * wire::kVoxel;
       refused(integrate, ray, "ray 1");
       refused(integrate, ray, "position");
       ray = good;
       ray.direction = {};
       refused(integrate, ray, "direction");
       ray.direction = {8000, 0, 0};
       refused(integrate, ray, "direction");
       ray = good;
       ray.flags = 0;
       refused(integrate, ray, "flags");
       ray = good;
       ray.opacity = 5;
       host.refused(trace_command({.type = RayType::kOpacity, .opacity = wire::kOpacityOne}, {ray}), "opacity");
       ray = good;
       ray.set_colour_word(wire::kMaxLength + 1);
       host.refused(trace_command({.type = RayType::kIntegral}, {ray}), "length");
     }},
    {1, "ray.header", "P1702",
     [](Host& host) {
       const Volume volume = fog(host, {9, 9, 9}, kAlpha);
       const wire::Ray good = host_ray(1, {4, 4, 4}, {0, 0, 1});
       const std::pair<wire::TraceHeader, const char*> wrong[] = {
           {{.type = static_cast<RayType>(7)}, "type"},
           {{.type = RayType::kIntegrate, .opacity = 1}, "opacity"},
           {{.type = RayType::kOpacity, .opacity = 0}, "opacity"},
           {{.type = RayType::kOpacity, .opacity = 1 << 24}, "opacity"},
           {{.type = RayType::kIntegrate, .albedo = wire::Albedo::kHigh}, "albedo"},
           {{.type = RayType::kIntegrate, .rules = wire::EnergyRules::kConserving}, "rules"},
           {{.type = RayType::kIntegrate, .words = wire::SumWords::kWhole}, "words"}};
       for (const auto& [header, word] : wrong) host.refused(trace_command(header, {good}), word);
       Bytes cut = trace_command({.type = RayType::kIntegrate}, {good});
       cut.pop_back();
       host.refused(cut, "payload");
     }},
    {1, "ray.threshold", "P1709",
     [](Host& host) {
       fog(host);
       host.write_register(reg::kOpacityThreshold, static_cast<std::uint32_t>(0.25 * wire::kOpacityOne));
       check_opacity(trace(host, {.type = RayType::kIntegrate}, host_ray(1, {4, 4, 0}, {0, 0, 1})), opacity_after(3));
       const wire::TraceHeader opacity{.type = RayType::kOpacity, .opacity = wire::kOpacityOne};
       check_opacity(trace(host, opacity, segment(1, {4, 4, 0}, {0, 0, 1}, 8)), opacity_after(8));
     }},
    {1, "ray.as_pixels", "P1710",
     [](Host& host) {
       Volume volume(host, {12, 13, 14});
       Noise noise(10);
       volume.fill([&noise](int, int, int) { return wire::Voxel{static_cast<std::uint16_t>(noise.below(4096))}; });
       host.write_register(reg::kPipeline, 0);
       send_look(host, [](std::uint32_t density, unsigned) {
         const auto c = static_cast<std::uint16_t>(density);
         return Entry{{c, static_cast<std::uint16_t>(4095 - c), 2000}, static_cast<std::uint16_t>(4 * c)};
       });
       wire::RenderCommand command = along(2, true, volume, 6, 6, 2.1);
       command.projection = wire::Projection::kPerspective;
       command.origin = {5, 6, -10};
       command.forward = {-0.4, -0.4, 1};
       command.du = {0.13, 0, 0};
       command.dv = {0, 0.13, 0};
       const auto picture = render(host, command);
       for (int i = 0; i < 36; ++i) {
         const Start start = start_of(command, i % 6 + 0.5, i / 6 + 0.5, volume.size());
         wire::Ray ray = host_ray(1, {0, 0, 0}, {0, 0, 1});
         for (std::size_t a = 0; a < 3; ++a) {
           ray.position[a] = static_cast<std::uint32_t>(start.position[a]);
           ray.direction[a] = static_cast<std::int16_t>(start.direction[a]);
         }
         if (!start.hits) continue;
         const wire::Ray back = trace(host, {.type = RayType::kIntegrate}, ray);
         const wire::Pixel& pixel = picture[static_cast<std::size_t>(i)];
         const auto eight = [&back](std::size_t c) { return (back.colour[c] * 510 + 4095) / 8190; };
         const std::uint64_t alpha = (std::uint64_t{back.opacity} * 8190 + wire::kOpacityOne) / (2 * wire::kOpacityOne);
         check(pixel.alpha == alpha && pixel.red == eight(0) && pixel.green == eight(1) && pixel.blue == eight(2),
               "pixel {}: expected {} {} {} alpha {}, got {} {} {} alpha {}", i, eight(0), eight(1), eight(2), alpha,
               pixel.red, pixel.green, pixel.blue, pixel.alpha);
       }
     }},
    {1, "pair.clear", "P1720",
     [](Host& host) {
       fog(host);
       constexpr double kDistance = 2;
       wire::Element a, b;
       a.origin = {4, 4, 4};
       a.u = b.v = {1, 0, 0};
       a.v = b.u = {0, 1, 0};
       b.origin = {4, 4, 4 + kDistance};
       Bytes command = wire::encoded(wire::PairsHeader{.elements = 2, .pairs = 1, .rays = 4096});
       wire::append(command, a);
       wire::append(command, b);
       wire::append(command, wire::Pair{0, 1, 5});
       const Bytes bytes = host.run(command);
       check_same("bytes of a result", bytes.size(), wire::kPairResultBytes);
       const auto result = wire::decode<wire::PairResult>(bytes);
       // Form factor of equal parallel squares (Howell's C-11), whose area is 1.
       const double x = 1 / kDistance, root = std::sqrt(1 + x * x);
       const double factor = 2 / (std::numbers::pi * x * x) *
                             (std::log((1 + x * x) / std::sqrt(1 + 2 * x * x)) + 2 * x * root * std::atan(x / root) -
                              2 * x * std::atan(x));
       check_near("mean of G", result.geometric, factor, 0.01 * factor);
       // Between the middles the way is 2 voxels, between opposite corners 2.45.
       const double share = result.transported / result.geometric;
       check(share < 1 - opacity_after(2) && share > 1 - opacity_after(2.45),
             "mean of G T: expected {} to {} of G, got {}", 1 - opacity_after(2.45), 1 - opacity_after(2), share);
       command[12] = command[13] = 0;
       host.refused(command, "rays");
     }},
};

}  // namespace

std::span<const Case> ray_cases() { return kCases; }

}  // namespace gicube::conformance
