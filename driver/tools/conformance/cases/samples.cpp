// Samples of viewing rays: their positions, their values and their compositing. With opaque entries a pixel shows the
// words of a sample.
#include <cmath>

#include "tools/conformance/host.h"
#include "tools/conformance/scene.h"

namespace gicube::conformance {
namespace {

constexpr std::uint32_t kNoShade = wire::kPipelineLeap;  // PIPELINE

Volume noisy(Host& host, int more = 3) {
  const int n = static_cast<int>(host.read_register(reg::kBlockVoxels));
  Volume volume(host, {n + more, n + more - 1, n + more + 2});
  Noise noise(4);
  volume.fill([&noise](int, int, int) {
    return wire::Voxel{static_cast<std::uint16_t>(noise.below(4096)), 0, static_cast<std::uint8_t>(noise.below(4)), 0};
  });
  host.write_register(reg::kPipeline, kNoShade);
  send_look(host, telling);
  return volume;
}

// Each pixel must show the density and tag of its first sample, or nothing where the ray misses.
void check_first_samples(Host& host, const Volume& volume, const wire::RenderCommand& command) {
  const auto picture = render(host, command);
  std::size_t hits = 0;
  for (int i = 0; i < command.width * command.height; ++i) {
    const int x = i % command.width, y = i / command.width;
    const Start start = start_of(command, x + 0.5, y + 0.5, volume.size());
    const wire::Pixel& pixel = picture[static_cast<std::size_t>(i)];
    if (!start.hits) {
      check(pixel == wire::Pixel{}, "pixel {}, {}: expected nothing where the ray misses", x, y);
      continue;
    }
    ++hits;
    check(pixel.alpha == 4095, "pixel {}, {}: expected alpha 4095, got {}", x, y, pixel.alpha);
    check(told_density(pixel) == volume.density(start.position), "pixel {}, {}: expected density {}, got {}", x, y,
          volume.density(start.position), told_density(pixel));
    check(pixel.blue == volume.tag(start.position), "pixel {}, {}: expected tag {}, got {}", x, y,
          volume.tag(start.position), pixel.blue);
  }
  check(hits > 0, "expected rays that hit the volume");
}

wire::Pixel middle(Host& host, const Volume& volume, int axis = 2, bool up = true) {
  return render(host, along(axis, up, volume, 3, 3, volume.size()[0] / 3.5)).at(4);
}

constexpr Case kCases[] = {
    {0, "sample.density", "P1606",
     [](Host& host) {
       const Volume volume = noisy(host);
       for (const int axis : {0, 1, 2}) {
         for (const bool up : {true, false}) {
           check_first_samples(host, volume, along(axis, up, volume, 40, 40, volume.size()[0] / 37.3));
         }
       }
     }},
    {0, "sample.perspective", "P1602",
     [](Host& host) {
       const Volume volume = noisy(host);
       wire::RenderCommand command;
       command.width = 33;
       command.height = 29;
       command.origin = {-9.3, 31.7, -20.1};
       command.forward = {-0.9, -0.9, 1};
       command.du = {0.09, 0, 0.011};
       command.dv = {0, 0.045, -0.003};
       check_first_samples(host, volume, command);
       command.origin = {3.25, 4.5, 5.125};
       check_first_samples(host, volume, command);
     }},
    {0, "sample.direction", "P1602",
     [](Host& host) {
       const Volume volume = fog(host, {17, 17, 17}, 3000);
       wire::RenderCommand command = along(2, true, volume, 5, 5, 3);
       const auto picture = render(host, command);
       for (const double length : {0.2, 7.0}) {
         command.forward[2] = length;
         check(render(host, command) == picture, "expected the same picture with a direction of length {}", length);
       }
     }},
    {0, "sample.misses", "P1612",
     [](Host& host) {
       const Volume volume = noisy(host);
       check_first_samples(host, volume, along(1, true, volume, 21, 17, volume.size()[0] / 9.1, {-8, 0, -9}));
       wire::RenderCommand none = along(1, true, volume, 2, 1, 1);
       none.forward = {0, 0, 0};
       for (const wire::Pixel& pixel : render(host, none))
         check(pixel == wire::Pixel{}, "expected nothing, without a direction");
     }},
    {0, "sample.steps", "P1603",
     [](Host& host) {
       Volume volume(host, {9, 10, 40});
       Noise noise(5);
       volume.fill([&noise](int, int, int z) {
         return wire::Voxel{static_cast<std::uint16_t>(noise.below(4096)), 0, static_cast<std::uint8_t>(z < 20 ? 0 : 1),
                            0};
       });
       host.write_register(reg::kPipeline, kNoShade);
       send_look(host, [](std::uint32_t density, unsigned tag) { return tag == 0 ? Entry{} : telling(density, tag); });
       for (const std::uint32_t step :
            {wire::kStepOne, wire::kStepOne / 2, wire::kStepOne * 3 / 8, wire::kStepOne * 5 / 2}) {
         host.write_register(reg::kStep, step);
         const wire::RenderCommand command = along(2, true, volume, 8, 8, 0.97);
         const auto picture = render(host, command);
         for (int i = 0; i < 64; ++i) {
           Words at = start_of(command, i % 8 + 0.5, i / 8 + 0.5, volume.size()).position;
           while (volume.tag(at) == 0) at[2] += static_cast<std::int32_t>(step / 4);
           check(told_density(picture[static_cast<std::size_t>(i)]) == volume.density(at),
                 "STEP {}: expected density {} at z = {} / 16384, got {}", step, volume.density(at), at[2],
                 told_density(picture[static_cast<std::size_t>(i)]));
         }
       }
     }},
    {0, "sample.classified", "P1607",
     [](Host& host) {
       const Volume volume = noisy(host);
       Noise noise(6);
       std::vector<Entry> table;
       for (std::size_t i = 0; i < wire::kSegmentationEntries; ++i) {
         const auto any = [&noise] { return static_cast<std::uint16_t>(noise.below(4096)); };
         table.push_back({{any(), any(), any()}, wire::kClassifiedOpacityOne});
       }
       send_look(host, [&table](std::uint32_t density, unsigned tag) { return table[tag << 12 | density]; });
       const wire::RenderCommand command = along(2, true, volume, 16, 16, 0.53);
       const auto picture = render(host, command);
       for (int i = 0; i < 256; ++i) {
         const Words at = start_of(command, i % 16 + 0.5, i / 16 + 0.5, volume.size()).position;
         const Entry& entry = table[volume.tag(at) << 12 | volume.density(at)];
         const auto eight = [&entry](std::size_t c) { return (entry.colour[c] * 255 + 2047) / 4095; };
         const wire::Pixel& pixel = picture[static_cast<std::size_t>(i)];
         check(pixel.red == eight(0) && pixel.green == eight(1) && pixel.blue == eight(2),
               "expected colour {} {} {}, got {} {} {}", eight(0), eight(1), eight(2), pixel.red, pixel.green,
               pixel.blue);
       }
     }},
    {0, "sample.transparent", "P1605",
     [](Host& host) {
       const Volume volume = fog(host, {9, 9, 9}, 0);
       check(middle(host, volume) == wire::Pixel{}, "expected nothing to be seen");
     }},
    {0, "sample.fog", "P1611",
     [](Host& host) {
       for (const std::uint16_t alpha : {std::uint16_t{655}, std::uint16_t{6554}, std::uint16_t{32768}}) {
         const Volume volume = fog(host, {17, 17, 17}, alpha);
         for (const int axis : {0, 1, 2}) {
           const wire::Pixel pixel = middle(host, volume, axis, axis != 1);
           const double expected = opacity_after(17, alpha);  // samples at 0 to 16
           check_near("alpha", pixel.alpha, 4095 * expected, 1.5);
           check_near("red", pixel.red, 255 * expected, 1.7);
           check_near("green", pixel.green, 127.5 * expected, 1.7);
           check_same("blue", pixel.blue, 0);
         }
       }
     }},
    {0, "sample.correction", "P1610",
     [](Host& host) {
       constexpr std::uint16_t kAlpha = 9000;
       for (const double step : {0.25, 0.5, 1.0, 2.0, 16.0}) {
         const Volume volume = fog(host, {17, 17, 17}, kAlpha);
         host.write_register(reg::kStep, static_cast<std::uint32_t>(step * wire::kStepOne));
         const double lengths = step * (std::floor(16 / step) + 1);
         check_near("alpha", middle(host, volume).alpha, 4095 * opacity_after(lengths, kAlpha), 1.5);
       }
     }},
    {0, "sample.order", "P1611",
     [](Host& host) {
       Volume volume(host, {5, 5, 2});
       volume.fill([](int, int, int z) { return wire::Voxel{static_cast<std::uint16_t>(100 + 100 * z)}; });
       host.write_register(reg::kPipeline, kNoShade);
       send_look(host, [](std::uint32_t density, unsigned) {
         return density == 100 ? Entry{{4095, 0, 0}, 32768} : density == 200 ? Entry{{0, 4095, 0}, 16384} : Entry{};
       });
       const wire::Pixel front = middle(host, volume), back = middle(host, volume, 2, false);
       check_near("red in front", front.red, 127.5, 1);
       check_near("green behind", front.green, 255 * 0.5 * 0.25, 1);
       check_near("alpha", front.alpha, 4095 * 0.625, 1);
       check_near("green in front", back.green, 63.75, 1);
       check_near("red behind", back.red, 255 * 0.75 * 0.5, 1);
       check_same("alpha from behind", back.alpha, front.alpha);
     }},
    {0, "sample.threshold", "P1604",
     [](Host& host) {
       const Volume volume = fog(host, {17, 17, 17}, 16384);  // a quarter
       for (const double threshold : {0.2, 0.3, 0.6}) {
         host.write_register(reg::kOpacityThreshold, static_cast<std::uint32_t>(threshold * wire::kOpacityOne));
         const double samples = std::ceil(std::log(1 - threshold) / std::log(0.75));
         check_near("alpha", middle(host, volume).alpha, 4095 * (1 - std::pow(0.75, samples)), 1.5);
       }
     }},
    {0, "sample.flags", "P1605",
     [](Host& host) {
       const int n = static_cast<int>(host.read_register(reg::kBlockVoxels));
       Volume volume(host, {n + 3, 4, 4});
       volume.fill([](int, int, int) { return wire::Voxel{100}; });
       send_look(host, [](std::uint32_t, unsigned) { return Entry{{4095, 4095, 4095}, 6554}; });
       const auto alpha_of = [&](double samples) { return 4095 * (1 - std::pow(0.9, samples)); };
       const auto alpha = [&] { return render(host, along(0, true, volume, 1, 1, 1)).at(0).alpha; };
       host.write_register(reg::kPipeline, kNoShade);
       check_near("alpha without flags", alpha(), alpha_of(n + 3), 1.5);
       host.write_memory(wire::kEmptyFlags.base, {1});
       check_near("alpha without block 0", alpha(), alpha_of(3), 1.5);
       host.write_memory(wire::kEmptyFlags.base, {2});
       check_near("alpha without block 1", alpha(), alpha_of(n), 1.5);
       host.write_register(reg::kPipeline, 0);
       check_near("alpha if flags do not count", alpha(), alpha_of(n + 3), 1.5);
     }},
    {0, "sample.shade", "P1609",
     [](Host& host) {
       Volume volume(host, {6, 6, 6});
       host.write_register(reg::kPipeline, kNoShade | wire::kPipelineShade);
       Bytes gradients(wire::kGradientCodes * wire::kGradientEntryBytes), map;
       for (std::uint16_t code = 1; code <= 6; ++code) {  // code 2 a + 1: towards -a, so the normal is +a
         wire::GradientEntry entry{};
         entry[(code - 1u) / 2] = static_cast<std::int16_t>(code % 2 == 1 ? -wire::kGradientOne : wire::kGradientOne);
         wire::store(std::span(gradients), code * 4u, wire::to_word(entry));
       }
       host.write_memory(wire::kGradientLut.base, gradients);
       for (std::uint8_t face = 0; face < 6; ++face)
         map.insert(map.end(), 128 * 128, static_cast<std::uint8_t>(20 + 20 * face));
       host.write_memory(wire::kReflectanceMap.base, map);
       send_look(host, [](std::uint32_t, unsigned) {
         return Entry{{4095, 2048, 0}, wire::kClassifiedOpacityOne, 16, 128, 80};
       });
       for (std::uint16_t code = 0; code <= 6; ++code) {
         volume.fill([code](int, int, int) { return wire::Voxel{100, code}; });
         const double shade = code == 0 ? 1 : (16 + 20.0 * code) / 128,
                      base = std::min(shade, code == 0 ? 1 : 80 / 128.0);
         const wire::Pixel pixel = middle(host, volume);
         check_near("red", pixel.red, 255 * std::min(1.0, shade), 1);
         check_near("green", pixel.green, 255 * std::min(1.0, base / 2 + (shade - base)), 1);
         check_near("blue", pixel.blue, 255 * (shade - base), 1);
       }
     }},
    {0, "sample.map", "P1608",
     [](Host& host) {
       Volume volume(host, {6, 6, 6});
       host.write_register(reg::kPipeline, kNoShade | wire::kPipelineShade);
       Bytes map(wire::kReflectanceBytes);
       for (std::size_t i = 0; i < map.size(); ++i)
         map[i] = static_cast<std::uint8_t>(i / 16384 < 2 ? i % 128 : i / 128 % 128);
       host.write_memory(wire::kReflectanceMap.base, map);
       send_look(host, [](std::uint32_t, unsigned) {
         return Entry{{4095, 4095, 4095}, wire::kClassifiedOpacityOne, 0, 128, 128};
       });
       Noise noise(7);
       for (int i = 0; i < 12; ++i) {
         Vector normal{};
         for (double& part : normal) part = noise.below(2001) / 1000.0 - 1;
         const double length = std::hypot(normal[0], normal[1], normal[2]);
         wire::GradientEntry entry{};
         std::size_t main = 0;
         for (std::size_t a = 0; a < 3; ++a) {
           entry[a] = static_cast<std::int16_t>(std::lround(-511 * normal[a] / length));
           if (std::abs(entry[a]) > std::abs(entry[main])) main = a;
         }
         Bytes gradients(wire::kGradientCodes * wire::kGradientEntryBytes);
         wire::store(std::span(gradients), 4, wire::to_word(entry));
         host.write_memory(wire::kGradientLut.base, gradients);
         volume.fill([](int, int, int) { return wire::Voxel{100, 1}; });
         // On faces of x a texel is its column, by y; on others its row, by the later of the other axes.
         const std::size_t by = main == 0 ? 1 : main == 1 ? 2 : 1;
         const double texel = (-entry[by] / static_cast<double>(std::abs(entry[main])) + 1) * 63.5;
         check_near("red", middle(host, volume).red, 255 * texel / 128, 1.5);
       }
     }},
    {0, "picture.rows", "P1613",
     [](Host& host) {
       const Volume volume = noisy(host);
       for (const auto& [width, height] : {std::pair{1, 1}, std::pair{3, 1}, std::pair{5, 7}, std::pair{2, 9}}) {
         check_first_samples(host, volume, along(2, true, volume, width, height, 1.3));
         const std::uint64_t bytes = wire::packed36_bytes(static_cast<std::size_t>(width * height));
         host.refused_request(FrameType::kMemoryRead, long_words({wire::kFramebuffer.base, bytes + 1}),
                              ErrorCode::kBadAddress);
       }
     }},
    {0, "picture.again", "P1614",
     [](Host& host) {
       const Volume volume = noisy(host);
       const wire::RenderCommand command = along(2, true, volume, 9, 9, 2);
       const auto first = render(host, command);
       render(host, along(0, false, volume, 9, 9, 2));
       check(render(host, command) == first, "expected the same picture of the same volume");
     }},
};

}  // namespace

std::span<const Case> sample_cases() { return kCases; }

}  // namespace gicube::conformance
