#include "encode/volume/gradients.h"

#include <algorithm>
#include <array>
#include <future>
#include <thread>
#include <type_traits>

#include "encode/volume/samples.h"

namespace gicube {
namespace {

// Density units a voxel edge. chosen: well below a 12-bit density's own rounding, so that no visible slope is lost.
constexpr double kMinMagnitude = 1.0 / 8;
constexpr double kSobelWeight = 32;  // (1 + 2 + 1)^2 differences over two voxels each

// The filter of one row after another: along z while a row is read, then y, then x. 64 times a 16-bit sample fits in 32 bits.
template <typename T>
class SobelRows {
 public:
  using Word = std::conditional_t<std::is_floating_point_v<T>, double, std::int32_t>;

  SobelRows(Samples<T> samples, Dims dims) : samples_(samples), dims_(dims), nx_(static_cast<std::size_t>(dims[0])) {
    for (auto* rows : {&sum_, &difference_}) {
      for (auto& row : *rows) row.resize(nx_);
    }
    for (auto* row : {&x_, &y_, &z_}) row->resize(nx_ + 2);
  }

  // Calls take(y, gx, gy, gz) with the sums of each row of plane z, kSobelWeight times the difference a voxel.
  void plane(int z, auto&& take) {
    std::vector<Word> gx(nx_), gy(nx_), gz(nx_);
    read_row(0, z);
    for (int y = 0; y < dims_[1]; ++y) {
      if (y + 1 < dims_[1]) read_row(y + 1, z);
      filter_along_y(y);
      for (std::size_t x = 0; x < nx_; ++x) {
        gx[x] = x_[x + 2] - x_[x];
        gy[x] = y_[x] + 2 * y_[x + 1] + y_[x + 2];
        gz[x] = z_[x] + 2 * z_[x + 1] + z_[x + 2];
      }
      take(y, gx.data(), gy.data(), gz.data());
    }
  }

 private:
  void read_row(int y, int z) {
    const auto row = [&](int plane) { return index_of(dims_, 0, y, std::clamp(plane, 0, dims_[2] - 1)); };
    const std::size_t before = row(z - 1), here = row(z), after = row(z + 1);
    Word* sum = sum_[static_cast<std::size_t>(y % 3)].data();
    Word* difference = difference_[static_cast<std::size_t>(y % 3)].data();
    for (std::size_t x = 0; x < nx_; ++x) {
      const Word a = samples_[before + x], b = samples_[here + x], c = samples_[after + x];
      sum[x] = a + 2 * b + c;
      difference[x] = c - a;
    }
  }

  void filter_along_y(int y) {
    const auto before = static_cast<std::size_t>(std::max(y - 1, 0) % 3), here = static_cast<std::size_t>(y % 3),
               after = static_cast<std::size_t>(std::min(y + 1, dims_[1] - 1) % 3);
    const Word *s0 = sum_[before].data(), *s1 = sum_[here].data(), *s2 = sum_[after].data();
    const Word *d0 = difference_[before].data(), *d1 = difference_[here].data(), *d2 = difference_[after].data();
    Word *gx = x_.data() + 1, *gy = y_.data() + 1, *gz = z_.data() + 1;
    for (std::size_t x = 0; x < nx_; ++x) {
      gx[x] = s0[x] + 2 * s1[x] + s2[x];
      gy[x] = s2[x] - s0[x];
      gz[x] = d0[x] + 2 * d1[x] + d2[x];
    }
    for (auto* row : {&x_, &y_, &z_}) {
      row->front() = (*row)[1];
      row->back() = (*row)[nx_];
    }
  }

  Samples<T> samples_;
  Dims dims_;
  std::size_t nx_;
  std::array<std::vector<Word>, 3> sum_, difference_;  // along z; row y stands at y mod 3
  std::vector<Word> x_, y_, z_;                        // along z and y, with a clamped voxel at both ends
};

template <typename T>
void sobel_slab(Samples<T> samples, Dims dims, Vec3 scale, const GradientCodebook& codebook, int begin, int end,
                std::uint16_t* codes) {
  const auto nx = static_cast<std::size_t>(dims[0]);
  SobelRows<T> rows(samples, dims);
  for (int z = begin; z < end; ++z) {
    rows.plane(z, [&](int y, const auto* gx, const auto* gy, const auto* gz) {
      std::uint16_t* out = codes + index_of(dims, 0, y, z);
      for (std::size_t x = 0; x < nx; ++x) {
        const Vec3 gradient{scale.x * gx[x], scale.y * gy[x], scale.z * gz[x]};
        const bool flat = dot(gradient, gradient) < kMinMagnitude * kMinMagnitude;
        out[x] = flat ? wire::kNoGradient : codebook.nearest(gradient);
      }
    });
  }
}

void supplied_slab(const VolumeView& view, const GradientCodebook& codebook, int begin, int end, std::uint16_t* codes) {
  for (std::size_t i = index_of(view.dims, 0, 0, begin); i < index_of(view.dims, 0, 0, end); ++i) {
    const float* g = view.gradients.data() + 3 * i;
    codes[i] = codebook.nearest({g[0], g[1], g[2]});
  }
}

// Calls work(begin, end) for slabs that make up 0..planes, each on a thread of its own.
void for_each_slab(int planes, unsigned threads, const auto& work) {
  const unsigned wanted = threads == 0 ? std::max(1u, std::thread::hardware_concurrency()) : threads;
  const int slabs = static_cast<int>(std::min(wanted, static_cast<unsigned>(planes)));
  std::vector<std::future<void>> others;
  for (int i = 1; i < slabs; ++i) {
    others.push_back(std::async(std::launch::async, work, planes * i / slabs, planes * (i + 1) / slabs));
  }
  work(0, planes / slabs);
  for (auto& other : others) other.get();
}

}  // namespace

std::vector<std::uint16_t> gradient_codes(const VolumeView& view, ValueRange range, const GradientCodebook& codebook,
                                          unsigned threads) {
  if (view.gradients.empty() && !view.find_gradients) return {};
  std::vector<std::uint16_t> codes(voxel_count(view.dims));
  if (!view.gradients.empty()) {
    for_each_slab(view.dims[2], threads,
                  [&](int begin, int end) { supplied_slab(view, codebook, begin, end, codes.data()); });
    return codes;
  }
  const Vec3 edges = relative_spacing(view.spacing);
  const double density = wire::kDensityMax / (range.high - range.low) / kSobelWeight;
  const Vec3 scale{density / edges.x, density / edges.y, density / edges.z};
  with_samples(view, [&](auto samples) {
    for_each_slab(view.dims[2], threads, [&](int begin, int end) {
      sobel_slab(samples, view.dims, scale, codebook, begin, end, codes.data());
    });
  });
  return codes;
}

}  // namespace gicube
