// Volumes that the cases put on a board, and the pictures that they expect by the rules P1601 to P1613.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "gicube/wire/command.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/mix64.h"
#include "gicube/wire/voxel.h"
#include "host.h"

namespace gicube::conformance {

using Vector = std::array<double, 3>;
using Words = std::array<std::int32_t, 3>;

// Random numbers, the same in each run.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() { return wire::mix64(++state_); }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(next() % n); }
  Bytes bytes(std::size_t count);
  // Packed voxels without irradiance; `bytes` is a multiple of nine.
  Bytes voxels(std::size_t bytes);

 private:
  std::uint64_t state_;
};

class Volume {
 public:
  // Sets the VOLUME registers.
  Volume(Host& host, const std::array<int, 3>& size);

  using Maker = std::function<wire::Voxel(int x, int y, int z)>;
  // Sets all voxels and sends all blocks.
  void fill(const Maker& make);
  const wire::Voxel& at(int x, int y, int z) const;  // zero beyond the volume

  const std::array<int, 3>& size() const { return size_; }
  int block() const { return n_; }
  std::size_t block_bytes() const { return wire::packed36_bytes(static_cast<std::size_t>(n_ * n_ * n_)); }
  std::size_t bytes() const { return block_bytes() * blocks(); }
  std::size_t blocks() const;
  // P1606: the density, 12 bits, and the tag of a sample at a position in words of 14 fraction bits.
  std::uint32_t density(const Words& position) const;
  unsigned tag(const Words& position) const;

 private:
  Host& host_;
  std::array<int, 3> size_;
  int n_;
  std::vector<wire::Voxel> voxels_;
};

using Entry = wire::SegmentationEntry;
// Sends the segmentation LUT.
void send_look(Host& host, const std::function<Entry(std::uint32_t density, unsigned tag)>& entry);
// A volume of density kFog everywhere: an orange medium with an opacity of `alpha` / 65535 for a voxel length, drawn
// without shading. Other densities are clear.
inline constexpr std::uint16_t kFog = 1000;
Volume fog(Host& host, const std::array<int, 3>& size, std::uint16_t alpha);
// Opacity, 0..1, of such a medium after so many voxel lengths.
double opacity_after(double lengths, std::uint16_t alpha);
// An opaque entry that encodes its density in red and green, and its tag in blue, so that a pixel shows both for the
// first visible sample.
Entry telling(std::uint32_t density, unsigned tag);
std::uint32_t told_density(const wire::Pixel& pixel);

// A picture along an axis, `step` voxels a pixel from `corner` on: columns along the next axis, rows along the third.
wire::RenderCommand along(int axis, bool up, const Volume& volume, int width, int height, double step,
                          Vector corner = {});
std::vector<wire::Pixel> render(Host& host, const wire::RenderCommand& command);

// P1602: the first position, in words, of the ray through image point (x, y), and its direction.
struct Start {
  bool hits = false;
  Words position{}, direction{};
};
Start start_of(const wire::RenderCommand& command, double x, double y, const std::array<int, 3>& size);

}  // namespace gicube::conformance
