#include "measure.h"

#include "reference/march.h"

namespace gicube::accuracy {

Image render_on_board(const samples::SceneSetup& setup, Board& board) {
  board.load_volume(setup.volume_view());
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < setup.materials.size(); ++tag) {
    board.set_transfer_function(samples::in_values_of(range, setup.materials[tag]), static_cast<int>(tag));
  }
  board.set_shading(setup.shading);
  return board.render(setup.view);
}

Figures measure(const samples::SceneSetup& setup, Board& board, unsigned threads) {
  const reference::Scene scene = to_reference(setup);
  const auto march = [&](const reference::Quantisers& quantisers) {
    return reference::Renderer(scene, quantisers).render(threads);
  };
  const Image image = render_on_board(setup, board);
  const reference::Picture exact = march({}), quantised = march(reference::Quantisers::all());

  Figures figures{setup.volume.dims, setup.view.width, setup.view.height, setup.view.step, {}, {}, {}, {}};
  figures.board = compare(image, exact);
  figures.together = compare(quantised, exact);
  figures.unexplained = compare(image, quantised);
  for (std::size_t i = 0; i < kQuantisers.size(); ++i) {
    reference::Quantisers one;
    one.*kQuantisers[i].quantiser = true;
    figures.alone[i] = compare(march(one), exact);
  }
  return figures;
}

std::string uri_for(const StudyScene& study, const std::string& uri) {
  if (study.max_volume_voxels == 0 || !uri.starts_with("emu:")) return uri;
  const char* separator = uri.find('?') == std::string::npos ? "?" : "&";
  return uri + separator + "set=asic.max_volume_voxels=" + std::to_string(study.max_volume_voxels);
}

}  // namespace gicube::accuracy
