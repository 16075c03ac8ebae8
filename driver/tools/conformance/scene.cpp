#include "scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gicube::conformance {
namespace {

constexpr double kUnit = wire::kVoxel;

std::int64_t mixed(std::int64_t a, std::int64_t b, std::int64_t weight) {
  return a + (((b - a) * weight + (1 << 14)) >> 15);
}

// The 12-bit colour that becomes `value` in the 8 bits of a pixel.
std::uint16_t told(std::uint32_t value) { return static_cast<std::uint16_t>((value * 4095 * 2 + 255) / 510); }

}  // namespace

Bytes Noise::bytes(std::size_t count) {
  Bytes out(count);
  for (std::uint8_t& byte : out) byte = static_cast<std::uint8_t>(next());
  return out;
}

Bytes Noise::voxels(std::size_t bytes) {
  Bytes out(bytes);
  for (std::size_t i = 0; i < bytes / 9 * 2; ++i) wire::store36(out, i, next() & 0x1FF'FFFF);
  return out;
}

Volume::Volume(Host& host, const std::array<int, 3>& size)
    : host_(host),
      size_(size),
      n_(static_cast<int>(host.read_register(reg::kBlockVoxels))),
      voxels_(static_cast<std::size_t>(size[0] * size[1] * size[2])) {
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    host.write_register(reg::kVolumeX + 4 * axis, static_cast<std::uint32_t>(size[axis]));
  }
}

std::size_t Volume::blocks() const {
  std::size_t count = 1;
  for (const int edge : size_) count *= static_cast<std::size_t>((edge + n_ - 1) / n_);
  return count;
}

const wire::Voxel& Volume::at(int x, int y, int z) const {
  static constexpr wire::Voxel kNone{};
  if (x >= size_[0] || y >= size_[1] || z >= size_[2]) return kNone;
  return voxels_[static_cast<std::size_t>((z * size_[1] + y) * size_[0] + x)];
}

void Volume::fill(const Maker& make) {
  for (int i = 0; i < static_cast<int>(voxels_.size()); ++i) {
    voxels_[static_cast<std::size_t>(i)] = make(i % size_[0], i / size_[0] % size_[1], i / size_[0] / size_[1]);
  }
  const int nx = (size_[0] + n_ - 1) / n_, ny = (size_[1] + n_ - 1) / n_;
  for (int block = 0; block < static_cast<int>(blocks()); ++block) {
    Bytes bytes(block_bytes());
    const int x = block % nx * n_, y = block / nx % ny * n_, z = block / nx / ny * n_;
    for (int i = 0; i < n_ * n_ * n_; ++i) {
      const wire::Voxel& voxel = at(x + i % n_, y + i / n_ % n_, z + i / n_ / n_);
      wire::store36(bytes, static_cast<std::size_t>(i), wire::to_word(voxel));
    }
    host_.write_memory(wire::kVolume.base + static_cast<std::size_t>(block) * block_bytes(), bytes);
  }
}

std::uint32_t Volume::density(const Words& p) const {
  std::array<std::int64_t, 8> values{};
  for (int i = 0; i < 8; ++i) {
    values[static_cast<std::size_t>(i)] =
        at((p[0] >> 14) + (i & 1), (p[1] >> 14) + (i >> 1 & 1), (p[2] >> 14) + (i >> 2)).density * 8;
  }
  for (std::size_t axis = 0, count = 4; axis < 3; ++axis, count /= 2) {
    for (std::size_t i = 0; i < count; ++i) values[i] = mixed(values[2 * i], values[2 * i + 1], (p[axis] & 0x3FFF) * 2);
  }
  return static_cast<std::uint32_t>((values[0] + 4) >> 3);
}

unsigned Volume::tag(const Words& p) const {
  constexpr std::int32_t kHalf = wire::kVoxel / 2;
  return at((p[0] + kHalf) >> 14, (p[1] + kHalf) >> 14, (p[2] + kHalf) >> 14).tag;
}

void send_look(Host& host, const std::function<Entry(std::uint32_t density, unsigned tag)>& entry) {
  Bytes table;
  for (std::uint32_t i = 0; i < wire::kSegmentationEntries; ++i) wire::append(table, entry(i & 0xFFF, i >> 12));
  host.write_memory(wire::kSegmentationLut.base, table);
}

Volume fog(Host& host, const std::array<int, 3>& size, std::uint16_t alpha) {
  Volume volume(host, size);
  volume.fill([](int, int, int) { return wire::Voxel{kFog}; });
  host.write_register(reg::kPipeline, wire::kPipelineLeap);
  send_look(host, [alpha](std::uint32_t density, unsigned) {
    Entry entry{{4095, 2048, 0}, density == kFog ? alpha : std::uint16_t{0}};
    entry.set_gain(256);
    return entry;
  });
  return volume;
}

double opacity_after(double lengths, std::uint16_t alpha) { return 1 - std::pow(1 - alpha / 65535.0, lengths); }

Entry telling(std::uint32_t density, unsigned tag) {
  return {{told(density >> 4), told(density & 15), told(tag)}, wire::kClassifiedOpacityOne};
}

std::uint32_t told_density(const wire::Pixel& pixel) { return std::uint32_t{pixel.red} << 4 | pixel.green; }

wire::RenderCommand along(int axis, bool up, const Volume& volume, int width, int height, double step, Vector corner) {
  wire::RenderCommand command;
  command.width = static_cast<std::uint16_t>(width);
  command.height = static_cast<std::uint16_t>(height);
  command.projection = wire::Projection::kOrthographic;
  const auto ahead = static_cast<std::size_t>(axis), across = (ahead + 1) % 3, down = (ahead + 2) % 3;
  command.origin = corner;
  command.origin[ahead] = up ? -3.0 : volume.size()[ahead] + 2.0;
  command.forward[ahead] = up ? 1 : -1;
  command.du[across] = command.dv[down] = step;
  return command;
}

std::vector<wire::Pixel> render(Host& host, const wire::RenderCommand& command) {
  const Bytes result = host.run(wire::encoded(command));
  check(result.empty(), "expected an empty completion of a rendering, got {} bytes", result.size());
  const std::size_t pixels = std::size_t{command.width} * static_cast<std::size_t>(wire::rows_of(command));
  const Bytes bytes = host.read_memory(wire::kFramebuffer.base, wire::packed36_bytes(pixels));
  std::vector<wire::Pixel> picture;
  for (std::size_t i = 0; i < pixels; ++i) picture.push_back(wire::to_pixel(wire::load36(bytes, i)));
  return picture;
}

Start start_of(const wire::RenderCommand& command, double x, double y, const std::array<int, 3>& size) {
  Vector origin = command.origin, direction = command.forward;
  Vector& moved = command.projection == wire::Projection::kPerspective ? direction : origin;
  for (std::size_t i = 0; i < 3; ++i) moved[i] += x * command.du[i] + y * command.dv[i];
  double begin = 0, end = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    for (const auto& [value, slope] :
         {std::pair{origin[i], direction[i]}, std::pair{size[i] - 1 - origin[i], -direction[i]}}) {
      if (slope > 0) begin = std::max(begin, -value / slope);
      if (slope < 0) end = std::min(end, value / -slope);
      if (slope == 0 && value < 0) end = -1;
    }
  }
  Start start;
  const double length = std::hypot(direction[0], direction[1], direction[2]);
  start.hits = begin <= end;
  for (std::size_t i = 0; i < 3 && start.hits; ++i) {
    const double at = std::clamp((origin[i] + begin * direction[i]) * kUnit, 0.0, (size[i] - 1) * kUnit);
    start.position[i] = static_cast<std::int32_t>(std::lround(at));
    start.direction[i] = static_cast<std::int32_t>(std::lround(direction[i] / length * kUnit));
  }
  return start;
}

}  // namespace gicube::conformance
