// Slices and projections of a board's volume, and the values that a page needs to show them.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/scene/scene.h"
#include "scene/names.h"
#include "view/request.h"

namespace gicube::samples::view {

// Adds further fields of hello's volume (protocol.h): look, look_why, window, unit, whole, marks, patient, labels.
void describe_values(const SceneSetup& setup, const ValueRange& range, nlohmann::ordered_json& volume);

// The function as the text of a .tf file.
std::string tf_text(const TransferFunctionFile& file);

// A preset in the values of the setup's volume, if these are known.
std::string tf_text(const Preset& preset, const SceneSetup* setup);

struct Slice {
  int width = 0, height = 0;
  std::vector<std::uint8_t> words;  // 16 bits each, little endian: 0..4095 over the volume's range, or a label's index
};

// The slice at voxel `request.at` of its axis. Throws InputError, and the exceptions of Board::read_volume().
Slice slice_of(Board& board, const SceneSetup& setup, const Request& request);

// The greatest or the mean value along the ray of each pixel of the setup's view, in steps of the smallest voxel edge.
Slice projection_of(Board& board, const SceneSetup& setup, Request::Projection projection, const Progress& progress);

}  // namespace gicube::samples::view
