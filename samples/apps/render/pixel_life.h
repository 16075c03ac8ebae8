// --explain-pixel: the board's report on one pixel's rays, as JSON, as a table and as a picture.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "scene/names.h"

namespace gicube::samples {

// The life of a pixel of the last picture in a file of events: the line "life" of docs/guide/observation.md. At the
// cycle level each iteration also has processor, cycle (its tags were checked), missing (packets), stalled (cycles that
// the pipeline was stalled for them), links (that the ray passed since the previous iteration) and overflows. Throws
// InputError if the board has refused the pixel, FileError.
nlohmann::ordered_json pixel_life(const std::filesystem::path& events);

// The report as lines of text.
std::string pixel_table(const nlohmann::ordered_json& life);
// The report as SVG, with a column for each iteration and a strip for each ray.
std::string pixel_svg(const nlohmann::ordered_json& life);

}  // namespace gicube::samples
