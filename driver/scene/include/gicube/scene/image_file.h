// Writes pictures from the board's framebuffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "gicube/image.h"
#include "gicube/scene/error.h"
#include "gicube/scene/provenance.h"
#include "gicube/transfer_function.h"

namespace gicube::scene {

// How a colour that is partly seen through and the background behind it are mixed: display-referred values, as the
// board mixes the samples of a ray, and as pictures are put together on a screen; or linear light, as compositing
// programs do with an EXR. The two differ only where alpha is neither 0 nor 1: white of alpha ½ over black is 0.5 or
// 0.735 on the display.
enum class Composite { kDisplay, kLinear };

struct Background {
  Background() = default;
  Background(const Colour& own, Composite how = Composite::kDisplay)
      : colour(own), composite(how) {}  // NOLINT: a colour is one

  Colour colour{};  // 0..1 each, display-referred
  Composite composite = Composite::kDisplay;

  // The display-referred value, 0..1, of a channel over it: `value` is not premultiplied.
  GICUBE_API double under(double value, double alpha, std::size_t channel) const;
};

// The pixels of a PNG, 8 bits a channel, rows from the top: RGBA with unassociated alpha, or RGB over a background.
// Throws FileError: an image without pixels or with a wrong number of them.
GICUBE_API std::vector<std::uint8_t> png_pixels(const Image& image, const std::optional<Background>& background = {});

// All three write to a temporary file beside `path` and rename it when it is whole: a failure leaves what was there
// before. They throw FileError: an image without pixels or with a wrong number of them, a file that can't be written.

// 8 bits a channel, display-referred (sRGB) as the framebuffer's colours are. Without a background RGBA with
// unassociated alpha, as PNG wants it; with one RGB over it.
GICUBE_API void write_png(const Image& image, const std::filesystem::path& path,
                          const std::optional<Background>& background = {}, const Provenance& provenance = {});

// 32-bit float, linear light with sRGB primaries. Without a background RGBA, colour premultiplied by alpha; the sRGB
// curve is undone on the colour before premultiplication. With one RGB over it.
GICUBE_API void write_exr(const Image& image, const std::filesystem::path& path,
                          const std::optional<Background>& background = {}, const Provenance& provenance = {});

// By the extension, .png or .exr.
GICUBE_API void write_image(const Image& image, const std::filesystem::path& path,
                            const std::optional<Background>& background = {}, const Provenance& provenance = {});

// Linear light, 0..1, of a display-referred value, 0..1 (IEC 61966-2-1).
GICUBE_API double linear_light(double display);
// Its inverse.
GICUBE_API double display_value(double linear);

}  // namespace gicube::scene
