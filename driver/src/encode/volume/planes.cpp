#include "encode/volume/planes.h"

#include <algorithm>
#include <span>

#include "encode/volume/samples.h"
#include "gicube/wire/voxel.h"

namespace gicube {

Planes::Planes(const VolumeStream& stream)
    : shape_{.samples = {},
             .type = stream.type,
             .dims = stream.dims,
             .spacing = stream.spacing,
             .range = stream.range,
             .find_gradients = stream.find_gradients},
      read_(stream.read),
      read_colours_(stream.read_colours) {}

std::size_t Planes::bytes_of(int planes) const {
  return voxel_count({shape_.dims[0], shape_.dims[1], planes}) * bytes_per_sample(shape_.type);
}

std::size_t Planes::colour_bytes_of(int planes) const {
  return wire::kColourBytes * voxel_count({shape_.dims[0], shape_.dims[1], planes});
}

namespace {

// Moves the last `kept` of the first `of` bytes to the front, and makes room for `all` bytes. Returns the room after
// the kept ones.
std::span<std::byte> make_room(std::vector<std::byte>& held, std::size_t of, std::size_t kept, std::size_t all) {
  const auto old = std::span(held).first(of).last(kept);
  std::copy(old.begin(), old.end(), held.begin());
  held.resize(std::max(held.size(), all));
  return std::span(held).first(all).subspan(kept);
}

}  // namespace

VolumeView Planes::window(int first, int count) {
  VolumeView out = shape_;
  out.dims[2] = count;
  if (!read_) {
    const std::size_t before = voxel_count({shape_.dims[0], shape_.dims[1], first}), voxels = voxel_count(out.dims);
    out.samples = shape_.samples.subspan(bytes_of(first), bytes_of(count));
    if (!shape_.gradients.empty()) out.gradients = shape_.gradients.subspan(3 * before, 3 * voxels);
    if (!shape_.colours.empty()) out.colours = shape_.colours.subspan(colour_bytes_of(first), colour_bytes_of(count));
    if (!shape_.tags.empty()) out.tags = shape_.tags.subspan(before, voxels);
    return out;
  }
  if (first == 0) first_ = end_ = 0;
  const int kept = std::max(0, end_ - first);
  const int before = end_ - first_;
  const std::span<std::byte> fresh = make_room(held_, bytes_of(before), bytes_of(kept), bytes_of(count));
  std::span<std::byte> fresh_colours;
  if (read_colours_) {
    fresh_colours = make_room(held_colours_, colour_bytes_of(before), colour_bytes_of(kept), colour_bytes_of(count));
  }
  first_ = first;
  end_ = first + kept;  // valid even if reading throws
  if (count > kept) {
    read_(end_, count - kept, fresh);
    VolumeView added = out;
    added.dims[2] = count - kept;
    added.samples = fresh;
    check_samples(added, end_);
    if (read_colours_) read_colours_(end_, count - kept, fresh_colours);
    end_ = first + count;
  }
  out.samples = std::span(held_).first(bytes_of(count));
  if (read_colours_) {
    const auto colours = std::span(held_colours_).first(colour_bytes_of(count));
    out.colours = {reinterpret_cast<const std::uint8_t*>(colours.data()), colours.size()};
  }
  return out;
}

ValueRange resolve_range(Planes& planes) {
  if (!planes.are_read() || has_range(planes.shape())) return resolve_range(planes.shape());
  constexpr int kPlanes = 8;  // chosen: little memory, and not one call per plane
  const int all = planes.shape().dims[2];
  ValueRange found = extremes(planes.window(0, std::min(kPlanes, all)));
  for (int first = kPlanes; first < all; first += kPlanes) {
    const ValueRange more = extremes(planes.window(first, std::min(kPlanes, all - first)));
    found = {std::min(found.low, more.low), std::max(found.high, more.high)};
  }
  return with_span(found);
}

void for_each_layer(Planes& planes, int n, ValueRange range, const GradientCodebook& codebook, unsigned threads,
                    const std::function<void(const BlockLayer&)>& take) {
  const Dims dims = planes.shape().dims;
  std::size_t before = 0;
  for (int low = 0; low < dims[2]; low += n) {
    // One more plane above for the blocks' +1 faces, and one more on both sides for the gradient filter.
    const int first = std::max(low - 1, 0), end = std::min(low + n + 2, dims[2]);
    const VolumeView window = planes.window(first, end - first);
    const std::vector<std::uint16_t> densities = to_densities(window, range);
    const std::vector<std::uint16_t> codes = gradient_codes(window, range, codebook, threads);
    const Dims part{dims[0], dims[1], std::min(n + 1, dims[2] - low)};
    const auto of_part = [&](auto all) {
      return all.empty() ? all : all.subspan(voxel_count({dims[0], dims[1], low - first}), voxel_count(part));
    };
    VoxelBlocks::Voxels voxels{of_part(std::span(densities)), of_part(std::span(codes)), of_part(window.tags), {}};
    if (!window.colours.empty()) {
      voxels.colours = window.colours.subspan(wire::kColourBytes * voxel_count({dims[0], dims[1], low - first}),
                                              wire::kColourBytes * voxel_count(part));
    }
    const VoxelBlocks blocks(part, n, voxels);
    const std::size_t count = voxel_count({blocks.blocks()[0], blocks.blocks()[1], 1});
    take({blocks, before, count});
    before += count;
  }
}

}  // namespace gicube
