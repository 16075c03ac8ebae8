// Compiled once for each instruction set that Highway knows (foreach_target); the host's best is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "opacity_march.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "functional.h"
#include "march.h"
#include "meet.h"
#include "opacity_march.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

void trace(std::span<wire::Ray> rays, const Frame& frame, const OpacityField&, RayCounters& counters) {
  for (wire::Ray& ray : rays) {
    if (ray.flags != 0) integrate(ray, frame, counters);
  }
}

#else

namespace hn = hwy::HWY_NAMESPACE;

using D32 = hn::CappedTag<std::int32_t, 16>;
using DU32 = hn::RebindToUnsigned<D32>;
using DU64 = hn::Repartition<std::uint64_t, D32>;
using V = hn::Vec<D32>;
using VU = hn::Vec<DU32>;
using VU64 = hn::Vec<DU64>;

// One word of each of the rays under way, lane by lane.
struct alignas(64) Word {
  std::array<std::int32_t, 16> lane{};

  V load() const { return hn::Load(D32(), lane.data()); }
  void store(V v) { hn::Store(v, D32(), lane.data()); }
};

// The rays under way: what changes from sample to sample, and what each ray has of its own.
struct Rays {
  std::array<Word, 3> position, step;
  Word left, exponent, opacity;
};

HWY_INLINE V set(std::int32_t x) { return hn::Set(D32(), x); }

HWY_INLINE V gather(const void* base, V byte_offsets) {
  return hn::GatherOffset(D32(), static_cast<const std::int32_t*>(base), byte_offsets);
}

// Two neighbours along x in one word, and the weight between them: lerp() of pipeline/resample.h.
HWY_INLINE V lerp(V a, V b, V weight) {
  const V product = hn::Mul(hn::Sub(b, a), weight);
  return hn::Add(a, hn::ShiftRight<kWeightBits>(hn::Add(product, set(1 << (kWeightBits - 1)))));
}
HWY_INLINE V along_x(V pair, V weight) {
  const V high = hn::BitCast(D32(), hn::ShiftRight<16>(hn::BitCast(DU32(), pair)));
  return lerp(hn::And(pair, set(0xFFFF)), high, weight);
}

// A sample's place: the index of its cell in the copy, and its fractions.
struct Place {
  V index;
  std::array<V, 3> fraction;
};

// What one voxel length of the sample's material absorbs, 8.24 in base 2.
HWY_INLINE VU classify(const Place& at, const OpacityField& field) {
  const V two = hn::ShiftLeft<1>(at.index);
  const std::int16_t* const row = field.densities;
  const std::ptrdiff_t down = field.edge, deep = std::ptrdiff_t{field.edge} * field.edge;
  std::array<V, 3> weight{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    weight[axis] = hn::ShiftLeft<kWeightBits - wire::kPositionFractionBits>(at.fraction[axis]);
  }
  const V near = lerp(along_x(gather(row, two), weight[0]), along_x(gather(row + down, two), weight[0]), weight[1]);
  const V far =
      lerp(along_x(gather(row + deep, two), weight[0]), along_x(gather(row + deep + down, two), weight[0]), weight[1]);
  const V density = lerp(near, far, weight[2]);
  constexpr int kHalf = 1 << (kDensityFractionBits - 1);
  V entry = hn::ShiftRight<kDensityFractionBits>(hn::Add(density, set(kHalf)));
  if (field.tags != nullptr) {  // of the nearest voxel
    constexpr int kToHalf = wire::kPositionFractionBits - 1;
    const V nearest = hn::Add(hn::Add(at.index, hn::ShiftRight<kToHalf>(at.fraction[0])),
                              hn::Add(hn::Mul(hn::ShiftRight<kToHalf>(at.fraction[1]), set(field.edge)),
                                      hn::Mul(hn::ShiftRight<kToHalf>(at.fraction[2]), set(field.edge * field.edge))));
    const V tag = hn::And(gather(field.tags, nearest), set(0xFF));
    entry = hn::Or(entry, hn::ShiftLeft<12>(tag));
  }
  return hn::BitCast(DU32(), gather(field.tables->depth.data(), hn::ShiftLeft<2>(entry)));
}

// What `depth` over `exponent` adds behind `opacity`, all in the low halves of 64-bit lanes: OpacityCorrection and over().
HWY_INLINE VU64 added(VU64 depth, VU64 exponent, VU64 opacity, const OpacityField& field) {
  const DU64 d;
  constexpr int kFraction = OpacityCorrection::kFractionBits, kRest = kFraction - OpacityCorrection::kSegmentBits;
  const auto product = [](VU64 a, VU64 b) { return hn::MulEven(hn::BitCast(DU32(), a), hn::BitCast(DU32(), b)); };
  const VU64 one = hn::Set(d, std::uint64_t{wire::kOpacityOne});

  // Beyond 25 halvings nothing is left, and more would not fit a shift.
  const VU64 x = hn::Min(hn::ShiftRight<16>(hn::Add(product(depth, exponent), hn::Set(d, std::uint64_t{1} << 15))),
                         hn::Set(d, std::uint64_t{25} << kFraction));
  const VU64 whole = hn::ShiftRight<kFraction>(x);
  const VU64 fraction = hn::And(x, hn::Set(d, (std::uint64_t{1} << kFraction) - 1));
  const VU64 segment = hn::GatherIndex(d, field.tables->exp2.data(),
                                       hn::BitCast(hn::RebindToSigned<DU64>(), hn::ShiftRight<kRest>(fraction)));
  const VU64 begin = hn::And(segment, hn::Set(d, 0xFFFF'FFFFu));
  const VU64 fall =
      product(hn::ShiftRight<32>(segment), hn::And(fraction, hn::Set(d, (std::uint64_t{1} << kRest) - 1)));
  const VU64 value = hn::Sub(hn::ShiftLeft<kRest>(begin), fall);
  const VU64 rounding = hn::Shl(hn::Set(d, std::uint64_t{1} << (kRest - 1)), whole);
  const VU64 through = hn::Shr(hn::ShiftRight<kRest>(hn::Add(value, rounding)), whole);
  const auto opaque = hn::Eq(depth, hn::Set(d, 0xFFFF'FFFFu));
  const VU64 alpha = hn::IfThenElse(opaque, one, hn::Sub(one, through));

  const VU64 t = hn::Add(product(hn::Sub(one, opacity), alpha), hn::Set(d, std::uint64_t{1} << 23));
  return hn::ShiftRight<24>(hn::Add(t, hn::ShiftRight<24>(t)));  // divide_by_full_scale<24>
}

HWY_INLINE V composite(VU depth, V exponent, V opacity, const OpacityField& field) {
  const DU64 d;
  const auto low = [&](VU64 v) { return hn::And(v, hn::Set(d, 0xFFFF'FFFFu)); };
  const VU64 all = hn::BitCast(d, depth), e = hn::BitCast(d, exponent), o = hn::BitCast(d, opacity);
  const VU64 even = added(low(all), low(e), low(o), field);
  const VU64 odd = added(hn::ShiftRight<32>(all), hn::ShiftRight<32>(e), hn::ShiftRight<32>(o), field);
  return hn::Add(opacity, hn::BitCast(D32(), hn::Or(even, hn::ShiftLeft<32>(odd))));
}

// leap_steps() of pipeline/advance.h. Dividends have at most 24 bits, so a float's quotient, rounded down, is exact: the
// true one is at least 1 / divisor below the next whole number, and the rounding is less.
HWY_INLINE V steps_out(V inside_block, V step, V size) {
  const hn::RebindToFloat<D32> df;
  const auto forward = hn::Gt(step, hn::Zero(D32()));
  const V way = hn::Abs(step), one = set(1);
  const V dividend =
      hn::IfThenElse(forward, hn::Add(hn::Sub(size, inside_block), hn::Sub(way, one)), hn::Add(inside_block, way));
  const auto quotient = hn::Div(hn::ConvertTo(df, dividend), hn::ConvertTo(df, hn::Max(way, one)));
  return hn::IfThenElse(hn::Eq(way, hn::Zero(D32())), size, hn::ConvertTo(D32(), quotient));
}

struct Counts {
  std::uint64_t samples = 0, visible = 0, leaps = 0;
};

// Takes all lanes on until at least `enough` of them have no steps left, or one has ended otherwise. An idle lane has no
// steps left. What masks a step must not hang on opacity: the next samples are fetched while this one is composited.
HWY_INLINE void march(Rays& rays, const OpacityField& field, std::size_t enough, Counts& counts) {
  const D32 d;
  std::array<V, 3> p{}, s{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    p[axis] = rays.position[axis].load();
    s[axis] = rays.step[axis].load();
  }
  V left = rays.left.load(), opacity = rays.opacity.load();
  const V exponent = rays.exponent.load();
  const V zero = hn::Zero(d), one = set(1), size = set(1 << field.block_shift);
  const V inside_mask = set((1 << field.block_shift) - 1), fraction_mask = set(wire::kVoxel - 1);
  const V last = set(field.threshold - 1);
  while (true) {
    const auto stepping = hn::Gt(left, zero);
    if (hn::Lanes(d) - hn::CountTrue(d, stepping) >= enough) break;
    V ended = hn::Sub(last, opacity);  // its sign: it has left the volume, or is opaque
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ended = hn::Or(ended, hn::Or(p[axis], hn::Sub(set(field.extent[axis]), p[axis])));
    }
    if (!hn::AllFalse(d, hn::And(stepping, hn::Lt(ended, zero)))) break;

    const auto block_of = [&](std::size_t axis) {
      return hn::ShiftRightSame(hn::IfThenElseZero(stepping, p[axis]), field.block_shift);
    };
    const V block =
        hn::Add(block_of(0), hn::Add(hn::Mul(block_of(1), set(field.across)), hn::Mul(block_of(2), set(field.slice))));
    const V first = gather(field.tables->first.data(), hn::ShiftLeft<2>(block));
    const auto leaps = hn::And(stepping, hn::Lt(first, zero));
    const auto samples = hn::AndNot(leaps, stepping);
    V steps = hn::IfThenElseZero(stepping, one);

    std::array<V, 3> inside_block{};
    for (std::size_t axis = 0; axis < 3; ++axis) inside_block[axis] = hn::And(p[axis], inside_mask);
    if (!hn::AllFalse(d, leaps)) {
      V out = hn::Min(size, left);
      for (std::size_t axis = 0; axis < 3; ++axis) out = hn::Min(out, steps_out(inside_block[axis], s[axis], size));
      steps = hn::IfThenElse(leaps, out, steps);
      counts.leaps += hn::CountTrue(d, leaps);
    }
    if (!hn::AllFalse(d, samples)) {
      Place at{};
      std::array<V, 3> voxel{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        voxel[axis] = hn::ShiftRight<wire::kPositionFractionBits>(inside_block[axis]);
        at.fraction[axis] = hn::And(p[axis], fraction_mask);
      }
      const V rows = hn::Add(voxel[1], hn::Mul(voxel[2], set(field.edge)));
      at.index = hn::IfThenElseZero(samples, hn::Add(first, hn::Add(voxel[0], hn::Mul(rows, set(field.edge)))));
      const VU depth = hn::IfThenElseZero(hn::RebindMask(DU32(), samples), classify(at, field));
      counts.samples += hn::CountTrue(d, samples);
      const auto visible = hn::Ne(depth, hn::Zero(DU32()));
      if (!hn::AllFalse(DU32(), visible)) {
        counts.visible += hn::CountTrue(DU32(), visible);
        opacity = composite(depth, exponent, opacity, field);
      }
    }
    left = hn::Sub(left, steps);
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = hn::Add(p[axis], hn::Mul(steps, s[axis]));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) rays.position[axis].store(p[axis]);
  rays.left.store(left);
  rays.opacity.store(opacity);
}

struct Slot {
  Traveller traveller;
  wire::Ray* ray = nullptr;
};

void put(const Traveller& from, Rays& to, std::size_t lane) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    to.position[axis].lane[lane] = from.position[axis];
    to.step[axis].lane[lane] = from.step[axis];
  }
  to.left.lane[lane] = static_cast<std::int32_t>(from.interacted);
  to.exponent.lane[lane] = static_cast<std::int32_t>(from.exponent);
  to.opacity.lane[lane] = static_cast<std::int32_t>(from.opacity);
}

void get(const Rays& from, std::size_t lane, Traveller& to) {
  for (std::size_t axis = 0; axis < 3; ++axis) to.position[axis] = from.position[axis].lane[lane];
  to.interacted = static_cast<std::uint32_t>(from.left.lane[lane]);
  to.opacity = static_cast<std::uint32_t>(from.opacity.lane[lane]);
}

void trace(std::span<wire::Ray> all, const Frame& frame, const OpacityField& field, RayCounters& counters) {
  const std::size_t lanes = hn::Lanes(D32());
  Rays rays{};
  std::array<Slot, 16> slots{};
  Counts counts;
  std::size_t next = 0, busy = 0;
  while (true) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      Slot& slot = slots[lane];
      if (slot.ray != nullptr) {
        get(rays, lane, slot.traveller);
        const End how = end(slot.traveller, frame);
        if (how == End::kNot) continue;
        count_end(slot.traveller, how, frame, counters);
        finish(slot.traveller, frame, *slot.ray);
        slot.ray = nullptr;
        --busy;
      }
      while (next < all.size() && all[next].flags == 0) ++next;
      if (next == all.size()) {
        rays.left.lane[lane] = 0;
        continue;
      }
      slot.ray = &all[next++];
      slot.traveller = set_out(*slot.ray, frame);
      put(slot.traveller, rays, lane);
      ++busy;
    }
    if (busy == 0) break;
    // A few idle lanes cost less than an exchange for each; with no new rays all of the busy ones must end.
    const std::size_t idle = lanes - busy;
    march(rays, field, next < all.size() ? std::max<std::size_t>(lanes / 4, 1) : idle + 1, counts);
  }
  counters.samples += counts.samples;
  counters.visible_samples += counts.visible;
  counters.leaps += counts.leaps;
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

HWY_EXPORT(trace);

OpacityMarch::OpacityMarch(const OpacityCorrection& correction) : correction_(correction) {
  for (std::size_t i = 0; i < tables_.exp2.size(); ++i) {
    const std::uint64_t here = correction.exp2_at(i), next = correction.exp2_at(i + 1);
    tables_.exp2[i] = here | (here - next) << 32;
  }
}

void OpacityMarch::clear() {
  copy_.clear();
  volume_ = rays_ = 0;
}

bool OpacityMarch::prepare(std::uint64_t rays, const Frame& frame, std::uint64_t lut_writes, unsigned threads) {
  if (!frame.plain || !frame.segments || !frame.colourless || frame.jitter || !frame.cut_planes.empty()) return false;
  if (volume_ != frame.volume->decodings()) {
    copy_.clear();
    volume_ = frame.volume->decodings();
    rays_ = 0;
  }
  rays_ += rays;
  if (rays_ < frame.volume->stored_blocks()) return false;  // chosen: a block's copy takes about as long as a long ray
  copy_.follow(*frame.volume, threads);
  if (!copy_.fits()) return false;
  if (lut_writes_ != lut_writes) {
    lut_writes_ = lut_writes;
    for (std::size_t i = 0; i < tables_.depth.size(); ++i) {
      const std::uint16_t opacity = frame.segmentation[i].opacity;
      tables_.depth[i] = opacity == wire::kClassifiedOpacityOne ? ~0u : correction_.depth(opacity);
    }
  }
  tables_.first = copy_.first();
  for (std::size_t block = 0; frame.leap && block < tables_.first.size(); ++block) {
    if (frame.empty[block] != 0) tables_.first[block] = -1;
  }
  return true;
}

void OpacityMarch::trace(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters) const {
  const VolumeMemory& volume = *frame.volume;
  OpacityField field{};
  field.densities = copy_.densities();
  field.tags = copy_.tags();
  field.tables = &tables_;
  field.extent = frame.extent;
  field.threshold = static_cast<std::int32_t>(frame.opacity_threshold);
  field.edge = volume.block_voxels() + 1;
  field.block_shift = std::countr_zero(static_cast<unsigned>(volume.block_voxels())) + wire::kPositionFractionBits;
  field.across = volume.blocks()[0];
  field.slice = volume.blocks()[0] * volume.blocks()[1];
  HWY_DYNAMIC_DISPATCH(trace)(rays, frame, field, counters);
}

}  // namespace gicube::emu
#endif
