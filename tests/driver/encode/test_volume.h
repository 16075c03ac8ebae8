// Volumes whose samples are a function of the voxel, for tests.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "gicube/volume.h"
#include "voxels.h"

namespace gicube {

template <typename T>
struct TestVolume {
  Dims dims{};
  std::vector<T> samples;
  SampleType type;

  // value(x, y, z) of each voxel, cast to T.
  template <typename Value>
  TestVolume(Dims size, SampleType sample_type, Value&& value) : dims(size), type(sample_type) {
    for_each_voxel(dims, [&](int x, int y, int z) { samples.push_back(static_cast<T>(value(x, y, z))); });
  }

  VolumeView view() const {
    VolumeView view;
    view.samples = std::as_bytes(std::span(samples));
    view.type = type;
    view.dims = dims;
    return view;
  }

  std::size_t index(int x, int y, int z) const {
    const int voxel = (z * dims[1] + y) * dims[0] + x;
    return static_cast<std::size_t>(voxel);
  }
};

}  // namespace gicube
