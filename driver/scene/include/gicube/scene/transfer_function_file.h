// Transfer functions as plain text files, and the presets of the library. One statement per line:
//
//   # a comment, to the end of the line
//   values absolute            in the volume's own values; the default
//   values normalised          0 and 1 are the ends of the volume's value range
//   values hounsfield          Hounsfield units; in a CT with other values, air counts as -1000 and soft tissue as 40
//   values robust              0 is the background, 1 the 99.9th percentile above it (gicube/scene/survey.h)
//   colour VALUE R G B         0..1, display-referred; also "color"
//   opacity VALUE ALPHA        0..1, of one voxel length
//
// The function is linear between its points and constant beyond them. The values of each kind increase from line to
// line; two lines with the same value make a step.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/scene/error.h"
#include "gicube/transfer_function.h"
#include "gicube/volume.h"

namespace gicube::scene {

enum class TransferScale { kAbsolute, kNormalised, kHounsfield, kRobust };

struct TransferFunctionFile {
  TransferFunction function;
  TransferScale scale = TransferScale::kAbsolute;
};

// Throws InputError with all faults of `text`, one per line: "NAME:LINE: field: expected ..., got ...".
GICUBE_API TransferFunctionFile parse_transfer_function(std::string_view text, const std::string& name);
// Reads a file. Also throws InputError if the file cannot be read.
GICUBE_API TransferFunctionFile read_transfer_function(const std::filesystem::path& path);

// The function in the values of a volume with this range, if nothing else is known about the volume: `robust` counts as
// `normalised`, and `hounsfield` as `absolute`.
GICUBE_API TransferFunction in_values_of(const ValueRange& range, const TransferFunctionFile& file);

// Built into the library, and installed as share/gicube/presets/*.tf.
struct Preset {
  std::string_view name;
  std::string_view text;
};
GICUBE_API const std::vector<Preset>& presets();
GICUBE_API std::string preset_names();  // for messages: "ct-bone, ct-engine, ..."
// Throws InputError with the list of names if there is no such preset.
GICUBE_API TransferFunctionFile find_preset(std::string_view name);

// Finds a preset by its name, or reads a file ("./ct-bone" is always a file).
GICUBE_API TransferFunctionFile find_transfer_function(const std::string& preset_or_path);

}  // namespace gicube::scene
