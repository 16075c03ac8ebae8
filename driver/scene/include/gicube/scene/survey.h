// The kind of values of a volume, estimated from a sample, and the transfer function that `--transfer-function auto`
// chooses.
#pragma once

#include <optional>
#include <string>

#include "gicube/scene/transfer_function_file.h"
#include "gicube/scene/volume_file.h"

namespace gicube::scene {

enum class DataKind { kConstant, kMask, kLabels, kCt, kMicroCt, kSolid, kPart, kMri, kMriT2, kSigned, kOther };

// All values are the file's. Found from at most 2^18 samples, so a detail of fewer than some ten voxels does not count.
struct Survey {
  DataKind kind = DataKind::kOther;
  ValueRange whole;   // the least and the greatest finite value; of 8-bit samples 0..255
  ValueRange range;   // for the board's densities: `whole` without padding and single extreme values
  ValueRange robust;  // background, and the 99.9th percentile of what is above it: a `values robust` function's 0 and 1
  ValueRange ct{-1000, 0};        // air and water: where a `values hounsfield` function's -1000 and 0 lie
  bool has_bone = false;          // kCt: more than 3 of 1000 voxels of the body are above 250 HU
  std::optional<double> padding;  // a value outside of the scanner's field of view
  double usual =
      0;  // median of what is above the background; kMicroCt: where the soft tissue ends; kSolid: the material
  std::string why;  // the kind and how it was told, a clause for people
};

// Throws what Volume::planes does.
GICUBE_API Survey survey_of(const Volume& volume);

// The function in the volume's own values (TransferScale::kAbsolute). `range`: the volume's.
GICUBE_API TransferFunctionFile in_values_of(const Survey& survey, const ValueRange& range,
                                             const TransferFunctionFile& file);

struct AutomaticLook {
  std::string name;  // of the preset
  TransferFunctionFile function;
  std::string why;  // one line: which preset, and why
};
// `given`: a range that the user has set, which takes the place of the percentiles.
GICUBE_API AutomaticLook automatic_look(const Survey& survey, const std::optional<ValueRange>& given = std::nullopt);

}  // namespace gicube::scene
