#include "scene/formats/plane_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace gicube::scene {
namespace {

// Reads a file's samples plane by plane. Plane 0 restarts from the beginning.
class PlaneFile {
 public:
  explicit PlaneFile(const StoredFile& file)
      : file_(file), all_(checked_bytes(file.layout)), stream_(open_data(file.place, all_)) {}

  void read(int first, int planes, std::span<std::byte> out) {
    if (first == 0 && next_ > 0) {
      stream_ = open_data(file_.place, all_);
      next_ = 0;
    }
    if (first != next_)
      throw FileError(file_.place.file, "planes", fmt::format("the next, {}", next_), fmt::format("{}", first));
    StoredLayout part = file_.layout;
    part.dims[2] = planes;
    part.first_sample = voxels_of({part.dims[0], part.dims[1], first});
    const bool kept = is_kept(part);
    std::vector<std::byte> bytes(kept ? 0 : voxels_of(part.dims) * bytes_of(part.type));
    const std::span<std::byte> stored = kept ? out : std::span(bytes);
    if (const std::size_t came = stream_->read(stored); came < stored.size()) {
      throw_truncated(file_.place, all_, fmt::format("{}", part.first_sample * bytes_of(part.type) + came));
    }
    next_ = first + planes;
    if (next_ == file_.layout.dims[2]) end_data(*stream_, file_.place, all_);
    if (kept) return to_machine(out, part);
    const Volume volume = to_volume(std::move(bytes), part);
    std::ranges::copy(volume.samples, out.begin());
  }

 private:
  StoredFile file_;
  std::size_t all_;  // bytes of samples
  std::unique_ptr<DataStream> stream_;
  int next_ = 0;
};

}  // namespace

Volume open_stored(const StoredFile& file) {
  const auto& [layout, place, encoding] = file;
  const std::size_t bytes = checked_bytes(layout);
  const std::uint64_t begin = place.offset + place.skip;
  if (encoding == Encoding::kHex) return to_volume(read_hex(place.file, begin, bytes), layout);
  if (encoding == Encoding::kNumbers)
    return to_volume(read_numbers(place.file, begin, layout.type, bytes / bytes_of(layout.type)), layout);
  if (layout.channels > 1 || !place.series.empty()) return to_volume(read_data(place, bytes), layout);
  Volume volume = to_volume({}, layout);
  volume.planes = [planes = std::make_shared<PlaneFile>(file)](int first, int count, std::span<std::byte> out) {
    planes->read(first, count, out);
  };
  return volume;
}

Volume read_stored(const StoredFile& file) {
  Volume volume = open_stored(file);
  take_planes(volume);
  return volume;
}

void take_planes(Volume& volume) {
  if (!volume.planes) return;
  constexpr int kPlanes = 8;  // chosen: this many are in memory both as stored and as floats
  const std::size_t voxels = voxels_of({volume.dims[0], volume.dims[1], 1});
  const auto grow = [](auto& values, std::size_t count) {
    values.resize(values.size() + count);
    return std::as_writable_bytes(std::span(values).last(count));
  };
  // Unwritten memory costs nothing if a compressed file ends early.
  volume.samples.reserve(voxels_of(volume.dims) * bytes_per_sample(volume.type));
  for (int z = 0; z < volume.dims[2]; z += kPlanes) {
    const int count = std::min(kPlanes, volume.dims[2] - z);
    const std::size_t more = voxels * static_cast<std::size_t>(count);
    volume.planes(z, count, grow(volume.samples, more * bytes_per_sample(volume.type)));
    if (volume.colour_planes) volume.colour_planes(z, count, grow(volume.colours, 3 * more));
  }
  volume.planes = volume.colour_planes = nullptr;
}

void for_each_plane(const Volume& volume, const std::function<void(int, std::span<const std::byte>)>& use) {
  const std::size_t bytes = voxels_of({volume.dims[0], volume.dims[1], 1}) * bytes_per_sample(volume.type);
  std::vector<std::byte> room(volume.planes ? bytes : 0);
  for (int z = 0; z < volume.dims[2]; ++z) {
    if (volume.planes) {
      volume.planes(z, 1, room);
      use(z, room);
    } else {
      use(z, std::span(volume.samples).subspan(static_cast<std::size_t>(z) * bytes, bytes));
    }
  }
}

}  // namespace gicube::scene
