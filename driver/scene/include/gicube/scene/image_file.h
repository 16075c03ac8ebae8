// Writes pictures from the board's framebuffer.
#pragma once

#include <filesystem>
#include <optional>

#include "gicube/image.h"
#include "gicube/scene/error.h"
#include "gicube/transfer_function.h"

namespace gicube::scene {

// All three write to a temporary file beside `path` and rename it when it is whole: a failure leaves what was there
// before. They throw FileError: an image without pixels or with a wrong number of them, a file that can't be written.

// 8 bits a channel, display-referred (sRGB) as the framebuffer's colours are. Without a background RGBA with
// unassociated alpha, as PNG wants it; with one (0..1 each) RGB over it, blended in display-referred values as the
// board blends.
GICUBE_API void write_png(const Image& image, const std::filesystem::path& path,
                          const std::optional<Colour>& background = {});

// 32-bit float RGBA, linear light with sRGB primaries, colour premultiplied by alpha. The sRGB curve is undone on the
// colour before premultiplication.
GICUBE_API void write_exr(const Image& image, const std::filesystem::path& path);

// By the extension, .png or .exr. An EXR keeps its alpha: a background with it is refused.
GICUBE_API void write_image(const Image& image, const std::filesystem::path& path,
                            const std::optional<Colour>& background = {});

// Linear light, 0..1, of a display-referred value, 0..1 (IEC 61966-2-1).
GICUBE_API double linear_light(double display);

}  // namespace gicube::scene
