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

// How a translucent colour is mixed with the background behind it: in display-referred values, like the board mixes the
// samples of a ray and browsers mix pictures, or in linear light, like compositing programs do with an EXR. The two
// differ only where alpha is neither 0 nor 1: white of alpha ½ over black is 0.5 or 0.735 on the display.
enum class Composite { kDisplay, kLinear };

struct Background {
  Background() = default;
  Background(const Colour& own, Composite how = Composite::kDisplay)
      : colour(own), composite(how) {}  // NOLINT: a colour is one

  Colour colour{};  // 0..1 each, display-referred
  Composite composite = Composite::kDisplay;

  // The display-referred value, 0..1, of a channel over this background; `value` is not premultiplied.
  GICUBE_API double under(double value, double alpha, std::size_t channel) const;
};

// The pixels of a PNG, 8 bits per channel, rows from the top: RGBA with unassociated alpha, or RGB over a background.
// Throws FileError: an image without pixels or with a wrong number of them.
GICUBE_API std::vector<std::uint8_t> png_pixels(const Image& image, const std::optional<Background>& background = {});

// All three write to a temporary file beside `path` and rename it when it is complete: a failure leaves an existing
// file as it was. They throw FileError: an image without pixels or with a wrong number of them, a file that cannot be
// written.

// 8 bits per channel, display-referred (sRGB) like the framebuffer's colours. Without a background RGBA with
// unassociated alpha, as PNG requires; with one, RGB over it.
GICUBE_API void write_png(const Image& image, const std::filesystem::path& path,
                          const std::optional<Background>& background = {}, const Provenance& provenance = {});

// 32-bit float, linear light with sRGB primaries. Without a background RGBA, colour premultiplied by alpha; the sRGB
// curve is undone on the colour before premultiplication. With one RGB over it.
GICUBE_API void write_exr(const Image& image, const std::filesystem::path& path,
                          const std::optional<Background>& background = {}, const Provenance& provenance = {});

// The extension, .png or .exr, gives the format.
GICUBE_API void write_image(const Image& image, const std::filesystem::path& path,
                            const std::optional<Background>& background = {}, const Provenance& provenance = {});

// Linear light, 0..1, of a display-referred value, 0..1 (IEC 61966-2-1).
GICUBE_API double linear_light(double display);
// Its inverse.
GICUBE_API double display_value(double linear);

}  // namespace gicube::scene
