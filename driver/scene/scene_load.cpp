#include <string_view>

#include "gicube/error.h"
#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"

namespace gicube::scene {

void set_own_codebook(Board& board, const SceneSetup& setup) {
  const std::vector<Vec3> codebook = codebook_of(setup.gradients);
  if (codebook.size() > 1) board.set_gradient_codebook(codebook);
}

namespace {

constexpr std::string_view kSamplesAt = "samples at ";  // of Board::load_volume(): a voxel

// Sends the samples to the board. The error for an invalid value names the file and a remedy.
void load_samples(Board& board, const SceneSetup& setup, bool gradients, const Progress& progress) {
  try {
    if (setup.volume.planes) {
      VolumeStream stream = setup.volume.stream();
      stream.find_gradients = gradients;
      board.load_volume(stream, progress);
      return;
    }
    VolumeView volume = setup.volume_view();
    volume.find_gradients = gradients;
    if (!gradients) volume.gradients = {};
    board.load_volume(volume, progress);
  } catch (const BadArgument& error) {
    if (setup.volume.source.empty() || !error.field().starts_with(kSamplesAt)) throw;
    throw FileError(setup.volume.source, error.field(),
                    error.expected() + ", or a number in its place (--nan VALUE; in Python nan=VALUE)", error.got());
  }
}

}  // namespace

void load(Board& board, const SceneSetup& setup, bool own_codebook, const Progress& progress) {
  if (own_codebook) set_own_codebook(board, setup);
  // Only light needs gradients: the reflectance map, scattering, and lighting rays.
  load_samples(board, setup, setup.view.shade || setup.view.scatter || setup.lighting.on, progress);
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < setup.materials.size(); ++tag) {
    board.set_transfer_function(in_values_of(range, setup.materials[tag]), static_cast<int>(tag));
  }
}

}  // namespace gicube::scene
