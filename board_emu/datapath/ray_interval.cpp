#include "ray_interval.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datapath/one_lane.h"
#include "datapath/opacity_correction.h"

namespace gicube::emu {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
// Optical depth of an opaque position: 2^-24 of the light is half a unit of the opacity's word.
const double kOpaque = std::log(2.0 * wire::kOpacityOne);

#include "datapath/interval-inl.h"

PathAround<double, bool> path_around(const RayState& ray, bool first, const Point& extent) {
  const FinePoint at = ray.fine_position(), step = ray.fine_step();
  const Point &here = ray.position, before = units_of(moved(at, step, -1)), after = units_of(moved(at, step, 1));
  PathAround<double, bool> out;
  std::int32_t left_cell = 0, right_cell = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    constexpr std::int32_t kFraction = wire::kVoxel - 1;
    const double slope = ray.slope(axis);
    out.here[axis] = here[axis] & kFraction;
    out.before[axis] = before[axis] & kFraction;
    out.after[axis] = after[axis] & kFraction;
    out.ahead[axis] = (slope > 0 ? extent[axis] : 0) - here[axis];
    out.per_unit[axis] = slope == 0 ? 0 : 1.0 / slope;
    left_cell |= here[axis] ^ before[axis];
    right_cell |= here[axis] ^ after[axis];
  }
  out.begins_here = (left_cell & -wire::kVoxel) == 0;
  out.ends_here = (right_cell & -wire::kVoxel) == 0;
  out.first = first;
  out.last = !inside(after, extent);
  return out;
}

std::array<double, 8> corners_of(const std::int16_t* densities, const Neighbourhood& around) {
  std::array<double, 8> out;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = densities[around.first + (i & 1) + around.row * (i >> 1 & 1) + around.slice * (i >> 2)];
  }
  return out;
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
    const bool first = i % kTagEntries == 0;
    run_[i] = i == 0 ? 0 : run_[i - 1] + (first || entries[i].opacity != entries[i - 1].opacity);
    opaque_down_[i] = opaque(i) ? static_cast<std::uint32_t>(i) : first ? kNone : opaque_down_[i - 1];
  }
  for (std::size_t i = entries.size(); i-- > 0;) {
    const bool last = i % kTagEntries == kTagEntries - 1;
    opaque_up_[i] = opaque(i) ? static_cast<std::uint32_t>(i) : last ? kNone : opaque_up_[i + 1];
  }
}

DepthTable::Depth DepthTable::between(unsigned tag, double from, double to, double length) const {
  const double first = tag * double{kTagEntries};
  const BinPosition<double> a = bin_position(first, from, sum_.data()), b = bin_position(first, to, sum_.data());
  const double way = b.at - a.at;
  const auto a_bin = static_cast<std::size_t>(a.bin), b_bin = static_cast<std::size_t>(b.bin);
  const std::uint32_t opaque = way < 0 ? opaque_down_[a_bin] : opaque_up_[a_bin];
  Depth out;
  if (opaque == kNone || (way < 0 ? opaque < b_bin : opaque > b_bin)) {
    out.depth = length * mean_depth(a, b);
    return out;
  }
  const double begins = std::clamp(way < 0 ? opaque + 1.0 : opaque, std::min(a.at, b.at), std::max(a.at, b.at));
  const double bin = std::min(std::trunc(begins), static_cast<double>(sum_.size() - 2));
  out.opaque = opaque == a_bin || way == 0 ? 0 : (begins - a.at) / way;
  out.depth = length * out.opaque * mean_depth(a, bin_at(begins, bin, sum_.data()));
  return out;
}

double DepthTable::way_to(double share, unsigned tag, double from, double to) const {
  const double first = tag * double{kTagEntries};
  const BinPosition<double> a = bin_position(first, from, sum_.data()), b = bin_position(first, to, sum_.data());
  const double whole = b.until - a.until;
  if (whole == 0) return share;
  const double wanted = a.until + share * whole;
  const auto low = sum_.begin() + static_cast<std::ptrdiff_t>(std::min(a.bin, b.bin));
  const auto high = sum_.begin() + static_cast<std::ptrdiff_t>(std::max(a.bin, b.bin)) + 1;
  const auto above = std::upper_bound(low + 1, high, wanted);
  const double in_bin = *above > above[-1] ? std::min((wanted - above[-1]) / (*above - above[-1]), 1.0) : 0;
  const double at = static_cast<double>(above - sum_.begin() - 1) + in_bin;
  return std::clamp((at - a.at) / (b.at - a.at), 0.0, 1.0);
}

RayInterval RayInterval::even(double begin, double end, std::uint32_t opacity, unsigned tag) {
  RayInterval out;
  out.add(begin, end, 1, 0, 0, tag);
  out.last_ = 1;
  out.tag_ = tag;
  out.depth_ = 1;
  out.opacity_ = opacity;
  return out;
}

RayInterval RayInterval::of(const KnownInterval& known) {
  const auto tag = static_cast<unsigned>(known.entry / kTagEntries);
  if (known.even) return even(known.ends.front(), known.ends.back(), known.opacity, tag);
  RayInterval out;
  for (std::size_t i = 0; i < known.depth.size(); ++i) {
    if (known.ends[i + 1] - known.ends[i] <= 0) continue;
    const double from = known.density[i == 0 ? 0 : i - 1], to = known.density[std::min<std::size_t>(i, 2)];
    out.add(known.ends[i], known.ends[i + 1], known.depth[i], from, to, tag);
    out.depth_ += known.depth[i];
  }
  out.last_ = out.pieces_;
  out.tag_ = tag;
  out.opacity_ = known.opacity;
  return out;
}

RayInterval RayInterval::of(const RayState& ray, const SampleSite& site, unsigned tag, std::uint16_t opacity,
                            bool first, const Frame& frame) {
  const Cell& cell = site.cell;
  const Neighbourhood voxels = around(site);
  const bool one_tag = has_one_tag(site);
  const Interval<double> interval = interval_of(path_around(ray, first, frame.extent));
  const double begin = interval.begin, end = interval.end;
  if (one_tag && frame.depths->uniform(tag, density_range(site.view.densities, voxels))) {
    const auto exponent = static_cast<std::uint32_t>(std::lround(ray.exponent * (end - begin)));
    return even(begin, end, (*frame.opacity_correction)(opacity, exponent), tag);
  }

  const double entry = std::max(begin, interval.own.entry), exit = std::min(end, interval.own.exit);
  const std::array<double, 3> slope{ray.slope(0), ray.slope(1), ray.slope(2)};
  std::array<double, 8> ends{begin, entry, std::clamp(0.0, entry, exit), exit, end};
  std::size_t count = 5;
  if (!one_tag) {  // a material ends half way between two voxels
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (slope[axis] == 0) continue;
      const double half_way = (wire::kVoxel / 2 - static_cast<double>(cell.fraction[axis])) / slope[axis];
      ends[count++] = std::clamp(half_way, entry, exit);
    }
    std::sort(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(count));
  }
  const std::array<double, 3> fraction{double(cell.fraction[0]), double(cell.fraction[1]), double(cell.fraction[2])};
  const std::array<double, 8> corners = corners_of(site.view.densities, voxels);
  // Beyond its cell the medium is constant, as on the cell's face.
  const auto within = [&](double steps) { return in_cell(fraction, slope, std::clamp(steps, entry, exit)); };
  const double lengths = ray.exponent / 65536.0;  // reference voxel lengths per step
  double to = density_at(corners, within(begin));
  RayInterval out;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const double way = ends[i + 1] - ends[i], from = to;
    if (way <= 0) continue;
    to = density_at(corners, within(ends[i + 1]));
    const unsigned here = one_tag ? tag : tag_at(site.view, voxels, within((ends[i] + ends[i + 1]) / 2));
    const DepthTable::Depth depth = frame.depths->between(here, from, to, way * lengths);
    if (depth.opaque > 1) {
      out.add(ends[i], ends[i + 1], depth.depth, from, to, here);
      continue;
    }
    const double wall = ends[i] + depth.opaque * way;
    // A ray that leaves a surface interacts with the medium behind it.
    const bool passes = ray.is(wire::kTrapped);
    if (!passes) out.add(ends[i], wall, depth.depth, from, lerp(from, to, depth.opaque), here);
    out.add(wall, wall, kOpaque, 0, 0, here);
    if (!passes) break;
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
