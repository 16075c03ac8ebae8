// The kind of values of a volume, estimated from a sample, and the transfer function that `--transfer-function auto`
// chooses.
#pragma once

#include <optional>
#include <string>

#include "gicube/scene/transfer_function_file.h"
#include "gicube/scene/volume_file.h"

namespace gicube::scene {

enum class DataKind { kConstant, kMask, kLabels, kCt, kMicroCt, kSolid, kPart, kMri, kMriT2, kSigned, kOther };

// All values are the file's. They are found from at most 2^18 samples, so small details may be missed.
struct Survey {
  DataKind kind = DataKind::kOther;
  ValueRange whole;         // the least and the greatest finite value; 0..255 for 8-bit samples
  ValueRange range;         // for the board's densities: `whole` without padding and single extreme values
  ValueRange robust;        // background, and the 99.9th percentile above it: 0 and 1 of a `values robust` function
  ValueRange ct{-1000, 0};  // air and water: -1000 and 0 of a `values hounsfield` function
  bool has_bone = false;    // kCt: more than 3 of 1000 voxels of the body are above 250 HU
  std::optional<double> padding;  // the value outside the scanner's field of view
  // The median of the values above the background; kMicroCt: the end of soft tissue; kSolid: the material.
  double usual = 0;
  std::string why;  // the kind and its evidence, a clause
};

// Throws what Volume::planes throws.
GICUBE_API Survey survey_of(const Volume& volume);

// The function in the volume's own values (TransferScale::kAbsolute). `range`: the volume's.
GICUBE_API TransferFunctionFile in_values_of(const Survey& survey, const ValueRange& range,
                                             const TransferFunctionFile& file);

struct AutomaticLook {
  std::string name;  // of the preset
  TransferFunctionFile function;
  std::string why;  // one line: the preset and the reason
};
// `given`: the user's range, which replaces the percentiles.
GICUBE_API AutomaticLook automatic_look(const Survey& survey, const std::optional<ValueRange>& given = std::nullopt);

}  // namespace gicube::scene
