#include "ray_interval.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datapath/opacity_correction.h"

namespace gicube::emu {

namespace {

constexpr std::size_t kDensities = wire::kSegmentationEntries / wire::kTags;
constexpr std::uint32_t kNone = ~std::uint32_t{0};
// Optical depth of an opaque position: 2^-24 of the light is half a unit of the opacity's word.
const double kOpaque = std::log(2.0 * wire::kOpacityOne);

double lerp(double a, double b, double w) { return a + (b - a) * w; }

// The interval in which the ray is in a cell, in steps from its sample.
struct Reach {
  double entry = -std::numeric_limits<double>::infinity(), exit = std::numeric_limits<double>::infinity();
};

class Path {
 public:
  explicit Path(const RayState& ray) : ray_(ray) {
    for (std::size_t axis = 0; axis < 3; ++axis) inverse_[axis] = 1.0 / ray.slope(axis);
    own_ = reach(ray.position, 0);
  }

  const Reach& own() const { return own_; }
  // An interval begins and ends half way between the cells of neighbouring samples, so that the intervals cover the ray once.
  double begin() const {
    const Point previous = moved(-1);
    if (same_cell(previous)) return -0.5;
    return (std::min(reach(previous, -1).exit, own_.entry) + own_.entry) / 2;
  }
  double end(const Point& extent) const {
    const Point next = moved(1);
    if (!inside(next, extent)) return to_the_face(extent);  // the path segment's last sample
    if (same_cell(next)) return 0.5;
    return (own_.exit + std::max(own_.exit, reach(next, 1).entry)) / 2;
  }

 private:
  Point moved(int steps) const { return units_of(emu::moved(ray_.fine_position(), ray_.fine_step(), steps)); }
  bool same_cell(const Point& other) const {
    const Point& at = ray_.position;
    return (((at[0] ^ other[0]) | (at[1] ^ other[1]) | (at[2] ^ other[2])) & -wire::kVoxel) == 0;
  }
  // The interval in the cell of a position that is `steps` away.
  Reach reach(const Point& position, double steps) const {
    Reach out;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (ray_.slope(axis) == 0) continue;
      const std::int32_t at = position[axis] & (wire::kVoxel - 1);
      const double low = -at * inverse_[axis] + steps, high = (wire::kVoxel - at) * inverse_[axis] + steps;
      out.entry = std::max(out.entry, std::min(low, high));
      out.exit = std::min(out.exit, std::max(low, high));
    }
    return out;
  }
  double to_the_face(const Point& extent) const {
    double steps = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (ray_.slope(axis) == 0) continue;
      const std::int32_t at = ray_.position[axis];
      steps = std::min(steps, (ray_.slope(axis) > 0 ? extent[axis] - at : -at) * inverse_[axis]);
    }
    return steps;
  }

  const RayState& ray_;
  std::array<double, 3> inverse_;
  Reach own_;
};

// The ray's position in the sample's cell, `steps` from the sample, 0..1.
std::array<double, 3> in_cell(const Cell& cell, const RayState& ray, double steps) {
  std::array<double, 3> w;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    w[axis] = std::clamp((cell.fraction[axis] + steps * ray.slope(axis)) / wire::kVoxel, 0.0, 1.0);
  }
  return w;
}

// The density at this position, 12 bits and a fraction.
double density_at(const std::int16_t* densities, const Neighbourhood& around, const std::array<double, 3>& w) {
  const auto along_x = [&](std::size_t voxel) { return lerp(densities[voxel], densities[voxel + 1], w[0]); };
  const std::size_t down = around.first + around.row, deep = around.first + around.slice;
  const double near = lerp(along_x(around.first), along_x(down), w[1]);
  const double far = lerp(along_x(deep), along_x(deep + around.row), w[1]);
  return lerp(near, far, w[2]) / (1 << kDensityFractionBits);
}

// The tag of the voxel nearest to this position.
unsigned tag_at(const BlockView& view, const Neighbourhood& around, const std::array<double, 3>& w) {
  return tag_of(view.codes[around.first + (w[0] >= 0.5) + around.row * (w[1] >= 0.5) + around.slice * (w[2] >= 0.5)]);
}

}  // namespace

DepthTable::DepthTable(std::span<const wire::SegmentationEntry> entries)
    : sum_(entries.size() + 1), run_(entries.size()), opaque_up_(entries.size(), kNone), opaque_down_(opaque_up_) {
  const auto opaque = [&](std::size_t i) { return entries[i].opacity == wire::kClassifiedOpacityOne; };
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const double depth = -std::log1p(-entries[i].opacity / double{wire::kClassifiedOpacityOne});
    sum_[i + 1] = sum_[i] + (opaque(i) ? 0 : depth);
    const bool first = i % kDensities == 0;
    run_[i] = i == 0 ? 0 : run_[i - 1] + (first || entries[i].opacity != entries[i - 1].opacity);
    opaque_down_[i] = opaque(i) ? static_cast<std::uint32_t>(i) : first ? kNone : opaque_down_[i - 1];
  }
  for (std::size_t i = entries.size(); i-- > 0;) {
    const bool last = i % kDensities == kDensities - 1;
    opaque_up_[i] = opaque(i) ? static_cast<std::uint32_t>(i) : last ? kNone : opaque_up_[i + 1];
  }
}

DepthTable::BinPosition DepthTable::bin_position(unsigned tag, double density) {
  const double at = std::clamp(density + 0.5, 0.0, kDensities - 1e-9);
  const std::size_t first = tag * kDensities;
  return {first + static_cast<std::size_t>(at), static_cast<double>(first) + at};
}

double DepthTable::until(const BinPosition& at) const {
  return lerp(sum_[at.bin], sum_[at.bin + 1], at.at - static_cast<double>(at.bin));
}

DepthTable::Depth DepthTable::between(unsigned tag, double from, double to, double length) const {
  const BinPosition a = bin_position(tag, from), b = bin_position(tag, to);
  const double way = b.at - a.at;
  const std::uint32_t opaque = way < 0 ? opaque_down_[a.bin] : opaque_up_[a.bin];
  Depth out;
  BinPosition until_there = b;
  if (opaque != kNone && (way < 0 ? opaque >= b.bin : opaque <= b.bin)) {
    const double begins = std::clamp(way < 0 ? opaque + 1.0 : opaque, std::min(a.at, b.at), std::max(a.at, b.at));
    out.opaque = opaque == a.bin || way == 0 ? 0 : (begins - a.at) / way;
    until_there.at = begins;
    until_there.bin = std::min(static_cast<std::size_t>(begins), sum_.size() - 2);
    length *= out.opaque;
  }
  const double passed = until_there.at - a.at;
  const double mean =
      std::abs(passed) < kNoWay ? sum_[a.bin + 1] - sum_[a.bin] : (until(until_there) - until(a)) / passed;
  out.depth = length * mean;
  return out;
}

double DepthTable::way_to(double share, unsigned tag, double from, double to) const {
  const BinPosition a = bin_position(tag, from), b = bin_position(tag, to);
  const double begin = until(a), whole = until(b) - begin;
  if (whole == 0) return share;
  const double wanted = begin + share * whole;
  const auto low = sum_.begin() + static_cast<std::ptrdiff_t>(std::min(a.bin, b.bin));
  const auto high = sum_.begin() + static_cast<std::ptrdiff_t>(std::max(a.bin, b.bin)) + 1;
  const auto above = std::upper_bound(low + 1, high, wanted);
  const double in_bin = *above > above[-1] ? std::min((wanted - above[-1]) / (*above - above[-1]), 1.0) : 0;
  const double at = static_cast<double>(above - sum_.begin() - 1) + in_bin;
  return std::clamp((at - a.at) / (b.at - a.at), 0.0, 1.0);
}

RayInterval RayInterval::step(std::uint32_t opacity, unsigned tag) {
  RayInterval out;
  out.piece_[out.pieces_++] = {0, 1, 1, 0, 0, tag};
  out.next();
  out.opacity_ = opacity;
  return out;
}

RayInterval RayInterval::of(const RayState& ray, const SampleSite& site, unsigned tag, std::uint16_t opacity,
                            bool first, const Frame& frame) {
  RayInterval out;
  const Cell& cell = site.cell;
  const Neighbourhood voxels = around(site);
  const std::int16_t* const densities = site.view.densities;
  const bool one_tag = has_one_tag(site);

  const Path path(ray);
  const double begin = first ? 0.0 : path.begin(), end = path.end(frame.extent);
  if (one_tag && frame.depths->uniform(tag, density_range(densities, voxels))) {
    const auto exponent = static_cast<std::uint32_t>(std::lround(ray.exponent * (end - begin)));
    out.piece_[out.pieces_++] = {begin, end, 1, 0, 0, tag};
    out.next();
    out.opacity_ = (*frame.opacity_correction)(opacity, exponent);
    return out;
  }

  const double entry = std::max(begin, path.own().entry), exit = std::min(end, path.own().exit);
  std::array<double, 8> ends{begin, entry, std::clamp(0.0, entry, exit), exit, end};
  std::size_t count = 5;
  if (!one_tag) {  // a material ends half way between two voxels
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (ray.slope(axis) == 0) continue;
      const double half_way = (wire::kVoxel / 2 - static_cast<double>(cell.fraction[axis])) / ray.slope(axis);
      ends[count++] = std::clamp(half_way, entry, exit);
    }
    std::sort(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(count));
  }
  // Beyond its cell the medium is constant, as on the cell's face.
  const auto within = [&](double steps) { return in_cell(cell, ray, std::clamp(steps, entry, exit)); };
  const double lengths = ray.exponent / 65536.0;  // reference voxel lengths per step
  double to = density_at(densities, voxels, within(begin));
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const double way = ends[i + 1] - ends[i], from = to;
    if (way <= 0) continue;
    to = density_at(densities, voxels, within(ends[i + 1]));
    const unsigned here = one_tag ? tag : tag_at(site.view, voxels, within((ends[i] + ends[i + 1]) / 2));
    const DepthTable::Depth depth = frame.depths->between(here, from, to, way * lengths);
    if (depth.opaque > 1) {
      out.piece_[out.pieces_++] = {ends[i], ends[i + 1], depth.depth, from, to, here};
      continue;
    }
    const double wall = ends[i] + depth.opaque * way;
    out.piece_[out.pieces_++] = {ends[i], wall, depth.depth, from, lerp(from, to, depth.opaque), here};
    out.piece_[out.pieces_++] = {wall, wall, kOpaque, 0, 0, here};
    break;
  }
  out.next();
  return out;
}

bool RayInterval::next() {
  first_ = last_;
  if (first_ == pieces_) return false;
  tag_ = piece_[first_].tag;
  depth_ = 0;
  bool opaque = false;
  for (; last_ < pieces_ && piece_[last_].tag == tag_; ++last_) {
    depth_ += piece_[last_].depth;
    opaque = piece_[last_].begin == piece_[last_].end;
  }
  opacity_ = opaque ? wire::kOpacityOne : opacity_of_depth(depth_);
  return true;
}

double RayInterval::place(double share, const Frame& frame) const {
  double left = share * depth_;
  for (std::size_t i = first_; i < last_; ++i) {
    const Piece& piece = piece_[i];
    if (left <= piece.depth && piece.depth > 0) {
      const double here = left / piece.depth;
      const double way = piece.from == piece.to ? here : frame.depths->way_to(here, tag_, piece.from, piece.to);
      return lerp(piece.begin, piece.end, way);
    }
    left -= piece.depth;
  }
  return last_ == 0 ? 0 : piece_[last_ - 1].end;
}

}  // namespace gicube::emu
