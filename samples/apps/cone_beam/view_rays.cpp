#include "cone_beam/view_rays.h"

namespace gicube::samples {

Projector projector_of(Board& board, const ConeGeometry& geometry, double step, PixelRays of_pixel) {
  check(geometry);
  ProjectorSetup setup{.dims = geometry.volume.dims,
                       .spacing = geometry.volume.spacing,
                       .columns = geometry.detector.columns * of_pixel.u,
                       .rows = geometry.detector.rows * of_pixel.v,
                       .step = step};
  for (std::size_t view = 0; view < geometry.angles.size(); ++view) {
    const ViewPose at = pose(geometry, view);
    setup.views.push_back({at.source, at.centre, (1.0 / of_pixel.u) * at.u, (1.0 / of_pixel.v) * at.v});
  }
  return {board, std::move(setup)};
}

Projections project_by_board(Board& board, const ConeGeometry& geometry, std::span<const float> volume, double step,
                             const Progress& progress) {
  Projector projector = projector_of(board, geometry, step);
  Projections out{geometry.detector.columns, geometry.detector.rows, {}};
  const auto told = [&, all = static_cast<std::uint32_t>(geometry.angles.size())](std::size_t done) {
    if (progress) progress(static_cast<std::uint32_t>(done), all);
  };
  told(0);
  projector.project(volume, {}, [&](std::size_t view, const std::vector<float>& values) {
    out.values.insert(out.values.end(), values.begin(), values.end());
    told(view + 1);
  });
  return out;
}

void make_up_for_faces(std::vector<float>& sums, const Dims& dims) {
  const auto half = [](int i, int dim) { return i == 0 || i == dim - 1 ? 2.0F : 1.0F; };
  float* sum = sums.data();
  for (int z = 0; z < dims[2]; ++z) {
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x) *sum++ *= half(x, dims[0]) * half(y, dims[1]) * half(z, dims[2]);
    }
  }
}

std::vector<float> backproject(Projector& projector, double max_density, const ViewDensities& densities,
                               Reconstruction& counts) {
  std::vector<float> sums = projector.backproject({}, max_density, densities);
  make_up_for_faces(sums, projector.setup().dims);
  counts.rays = projector.counts().rays;
  counts.deposits = projector.counts().deposits;
  counts.overflowed = projector.counts().overflowed;
  return sums;
}

}  // namespace gicube::samples
