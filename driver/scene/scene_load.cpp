#include "gicube/scene/scene.h"

namespace gicube::scene {

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
  if (setup.volume.planes) {
    VolumeStream stream = setup.volume.stream();
    stream.find_gradients = gradients;
    board.load_volume(stream, progress);
  } else {
    board.load_volume(volume, progress);
  }
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < setup.materials.size(); ++tag) {
    board.set_transfer_function(in_values_of(range, setup.materials[tag]), static_cast<int>(tag));
  }
}

}  // namespace gicube::scene
