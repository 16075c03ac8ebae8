#include "scene/program/board_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "scene/geometry/codebook.h"
#include "scene/program/input_error.h"

namespace gicube::samples {

Board open_board(const BoardOptions& options) {
  const std::string uri = board_uri(options);
  try {
    return Board::open(uri);
  } catch (const BadArgument& error) {
    throw UsageError(error.what());
  }
}

void check_fits(const Dims& dims, const BoardInfo& info, const std::string& source) {
  const int longest = *std::max_element(dims.begin(), dims.end());
  if (longest <= info.max_volume_voxels) return;
  const unsigned needed = std::bit_ceil(static_cast<unsigned>(longest));
  throw InputError(source,
                   fmt::format("at most {} voxels an edge, which this board holds (--set asic.max_volume_voxels={} "
                               "makes an emulated one larger)",
                               info.max_volume_voxels, needed),
                   fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]));
}

void set_own_codebook(Board& board, const SceneSetup& setup) {
  const std::vector<Vec3> codebook = codebook_of(setup.gradients);
  if (codebook.size() > 1) board.set_gradient_codebook(codebook);
}

void load(Board& board, const SceneSetup& setup, bool own_codebook, const Progress& progress) {
  if (own_codebook) set_own_codebook(board, setup);
  VolumeView volume = setup.volume_view();
  // Only light asks for gradients: the reflectance map, scattering, and lighting rays.
  const bool gradients = setup.view.shade || setup.view.scatter || setup.lighting.on;
  volume.find_gradients = gradients;
  if (!gradients) volume.gradients = {};
  board.load_volume(volume, progress);
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < setup.materials.size(); ++tag) {
    board.set_transfer_function(in_values_of(range, setup.materials[tag]), static_cast<int>(tag));
  }
}

}  // namespace gicube::samples
