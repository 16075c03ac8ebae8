// Pictures beyond the plain ones: filters, cut planes, anisotropic voxels, parts, jitter.
#include <cmath>

#include "tools/conformance/host.h"
#include "tools/conformance/scene.h"

namespace gicube::conformance {
namespace {

double alpha_after(double lengths, std::uint16_t alpha) { return 4095 * opacity_after(lengths, alpha); }

void set_plane(Host& host, std::uint32_t i, const Vector& normal, double offset) {
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    host.write_register(reg::kCutPlane0 + 16 * i + 4 * axis,
                        static_cast<std::uint32_t>(std::lround(normal[axis] * 16384)));
  }
  host.write_register(reg::kCutPlane0 + 16 * i + 12, static_cast<std::uint32_t>(std::lround(offset * 1024)));
}

constexpr Case kCases[] = {
    {4, "picture.samples", "P1615",
     [](Host& host) {
       const Volume volume = fog(host, {9, 9, 9}, wire::kClassifiedOpacityOne);
       for (const int samples : {1, 2, 4}) {
         // The volume's edge at x = 0 is a quarter, then two thirds into the first pixel.
         for (const double edge : {0.25, 0.66}) {
           wire::RenderCommand command = along(2, true, volume, 3, 1, 1, {-edge, 2.5, 0});
           command.samples_per_axis = static_cast<std::uint8_t>(samples);
           int inside = 0;
           for (int i = 0; i < samples; ++i) inside += (i + 0.5) / samples >= edge ? 1 : 0;
           check_near("alpha of the cut pixel", render(host, command).at(0).alpha, 4095.0 * inside / samples, 0.6);
         }
       }
     }},
    {4, "picture.tent", "P1616",
     [](Host& host) {
       const Volume volume = fog(host, {9, 9, 9}, wire::kClassifiedOpacityOne);
       wire::RenderCommand command = along(2, true, volume, 4, 3, 1, {-2, 2, 0});  // the edge between pixels 1 and 2
       command.filter = wire::Filter::kTent;
       command.samples_per_axis = 4;
       const auto picture = render(host, command);
       double all = 0, inside = 0;
       for (int i = 0; i < 12; ++i) {  // of pixel 1's neighbourhood, -1 to 2
         const double distance = (i - 5.5) / 4, weight = std::max(0.0, 1 - std::abs(distance));
         all += weight;
         inside += distance > 0.5 ? weight : 0;
       }
       check_near("alpha before the edge", picture.at(5).alpha, 4095 * inside / all, 1);
       check_near("alpha behind the edge", picture.at(6).alpha, 4095 * (1 - inside / all), 1);
     }},
    {4, "picture.cut", "P1620",
     [](Host& host) {
       constexpr std::uint16_t kAlpha = 6554;
       const Volume volume = fog(host, {17, 17, 17}, kAlpha);
       set_plane(host, 0, {0, 0, 1}, 4);
       set_plane(host, 1, {0, 0, -1}, -9);
       const auto alpha = [&](bool up) { return render(host, along(2, up, volume, 3, 3, 5)).at(4).alpha; };
       for (const bool up : {true, false}) {
         host.write_register(reg::kCutPlanes, 0);
         check_near("alpha without planes", alpha(up), alpha_after(17, kAlpha), 1.5);
         host.write_register(reg::kCutPlanes, 1);
         check_near("alpha of z >= 4", alpha(up), alpha_after(13, kAlpha), 1.5);
         host.write_register(reg::kCutPlanes, 2);
         check_near("alpha of 4 <= z <= 9", alpha(up), alpha_after(6, kAlpha), 1.5);
       }
       set_plane(host, 1, {1, 0, 0}, 20);
       check_same("alpha behind a plane that keeps nothing", alpha(true), 0);
     }},
    {4, "picture.spacing", "P1617",
     [](Host& host) {
       constexpr std::uint16_t kAlpha = 3000;
       const Volume volume = fog(host, {9, 9, 9}, kAlpha);
       const double spacing[] = {0.5, 1, 2.25};
       for (std::uint32_t axis = 0; axis < 3; ++axis) {
         host.write_register(reg::kSpacingX + 4 * axis, static_cast<std::uint32_t>(spacing[axis] * wire::kSpacingOne));
       }
       for (const int axis : {0, 1, 2}) {
         const auto alpha = render(host, along(axis, true, volume, 3, 3, 2.5)).at(4).alpha;
         check_near("alpha", alpha, alpha_after(9 * spacing[axis], kAlpha), 1.5);
       }
     }},
    {4, "picture.parts", "P1618",
     [](Host& host) {
       Volume volume(host, {16, 16, 4});
       Noise noise(8);
       volume.fill([&noise](int, int, int) { return wire::Voxel{static_cast<std::uint16_t>(noise.below(4096))}; });
       host.write_register(reg::kPipeline, wire::kPipelineLeap);
       send_look(host, telling);
       wire::RenderCommand command = along(2, true, volume, 7, 13, 1.1);
       const auto whole = render(host, command);
       command.strip_rows = 2;
       command.parts = 3;
       for (std::uint8_t part = 0; part < 3; ++part) {
         command.part = part;
         std::vector<wire::Pixel> expected;
         for (std::size_t row = 0; row < 13; ++row) {
           if (row / 2 % 3 == part)
             expected.insert(expected.end(), whole.begin() + 7 * row, whole.begin() + 7 * row + 7);
         }
         check(render(host, command) == expected, "part {}: expected its rows of the whole picture", part);
       }
       command.part = 3;
       host.refused(command, "part");
     }},
    {4, "picture.jitter", "P1619",
     [](Host& host) {
       constexpr std::uint16_t kAlpha = 700;
       const Volume volume = fog(host, {33, 33, 33}, kAlpha);
       const wire::RenderCommand command = along(2, true, volume, 16, 16, 2);
       const double plain = render(host, command).at(0).alpha;
       host.write_register(reg::kPipeline, wire::kPipelineJitter);
       const auto picture = render(host, command);
       double sum = 0;
       for (const wire::Pixel& pixel : picture) sum += pixel.alpha;
       // The last sample stands for the step after it, so a ray passes 32 voxels and half a mean step more.
       check_near("mean alpha", sum / 256, alpha_after(32 + 0.39, kAlpha), 4);
       check(std::ranges::any_of(picture, [&](const wire::Pixel& pixel) { return pixel.alpha != picture[0].alpha; }),
             "expected rays that differ");
       check(plain > sum / 256, "expected a voxel's step after the last sample without jitter, more than with it");
       check(render(host, command) == picture, "expected the same numbers for the same ray");
     }},
};

}  // namespace

std::span<const Case> picture_cases() { return kCases; }

}  // namespace gicube::conformance
