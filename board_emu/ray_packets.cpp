// Compiled once for each instruction set that Highway knows (foreach_target); the host's best is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ray_packets.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include "ray_packets.h"

#include <algorithm>
#include <bit>

#include "functional.h"
#include "march.h"
#include "meet.h"
#include "packet_stages-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

void trace(std::span<wire::Ray> rays, const Frame& frame, const PacketField&, RayCounters& counters,
           std::span<std::int32_t> steps) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    integrate(rays[i], frame, counters, steps.empty() ? nullptr : &steps[i]);
  }
}

#else

// One word of each of the rays under way, lane by lane.
struct alignas(64) Word {
  std::array<std::int32_t, 16> lane{};

  V load() const { return hn::Load(D32(), lane.data()); }
  void store(V v) { hn::Store(v, D32(), lane.data()); }
};

// The rays under way. A ray ends when no steps are left, or by its opacity.
struct Lanes {
  std::array<Word, 3> position, step;
  std::array<Word, 3> colour;  // of integrals: the sum's low kSumBits, and what is above
  Word exponent, opacity;
  Word left;  // steps to the end of a segment or of the volume
  Word more;  // by which a leap may go beyond that: a leaping ray overshoots the volume, but not its segment
};

constexpr int kSumBits = 20;

// Takes all lanes on until at least `enough` of them have ended. What addresses the samples hangs on steps alone, so that
// the next are fetched while one is composited: a ray that has become opaque goes on as a ghost, of which nothing is kept.
template <Gathers kGathers>
HWY_INLINE void march(Lanes& lanes, const PacketField& field, std::size_t enough, RayCounters& counters) {
  const D32 d;
  std::array<V, 3> p{}, s{}, colour{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    p[axis] = lanes.position[axis].load();
    s[axis] = lanes.step[axis].load();
    if (kGathers != Gathers::kOpacity) colour[axis] = lanes.colour[axis].load();
  }
  V left = lanes.left.load(), opacity = lanes.opacity.load();
  const V exponent = lanes.exponent.load(), more = lanes.more.load();
  const V zero = hn::Zero(d), one = set(1), size = set(1 << field.block_shift);
  const V inside_mask = set((1 << field.block_shift) - 1), fraction_mask = set(wire::kVoxel - 1);
  const V threshold = set(field.threshold);
  V taken = zero;  // steps
  while (true) {
    const Mask stepping = hn::Gt(left, zero);
    const Mask running = hn::And(stepping, hn::Lt(opacity, threshold));
    if (hn::Lanes(d) - hn::CountTrue(d, running) >= enough) break;

    const auto block_of = [&](std::size_t axis) {
      return hn::ShiftRightSame(hn::IfThenElseZero(stepping, p[axis]), field.block_shift);
    };
    const V block =
        hn::Add(block_of(0), hn::Add(hn::Mul(block_of(1), set(field.across)), hn::Mul(block_of(2), set(field.slice))));
    const V first = gather(field.tables->first.data(), hn::ShiftLeft<2>(block));
    const Mask leaps = hn::And(stepping, hn::Lt(first, zero));
    const Mask samples = hn::AndNot(leaps, stepping);
    V steps = hn::IfThenElseZero(stepping, one);

    std::array<V, 3> inside_block{};
    for (std::size_t axis = 0; axis < 3; ++axis) inside_block[axis] = hn::And(p[axis], inside_mask);
    if (!hn::AllFalse(d, leaps)) {
      V out = hn::Min(size, hn::Add(left, more));
      for (std::size_t axis = 0; axis < 3; ++axis) out = hn::Min(out, steps_out(inside_block[axis], s[axis], size));
      steps = hn::IfThenElse(leaps, out, steps);
      counters.leaps += hn::CountTrue(d, hn::And(leaps, running));
    }
    if (!hn::AllFalse(d, samples)) {
      Place at{};
      std::array<V, 3> voxel{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        voxel[axis] = hn::ShiftRight<wire::kPositionFractionBits>(inside_block[axis]);
        at.fraction[axis] = hn::And(p[axis], fraction_mask);
        at.weight[axis] = hn::ShiftLeft<kWeightBits - wire::kPositionFractionBits>(at.fraction[axis]);
      }
      const V rows = hn::Add(voxel[1], hn::Mul(voxel[2], set(field.edge)));
      at.index = hn::IfThenElseZero(samples, hn::Add(first, hn::Add(voxel[0], hn::Mul(rows, set(field.edge)))));
      const V density = resample_density(at, field);
      const Mask taking = hn::And(samples, running);
      counters.samples += hn::CountTrue(d, taking);
      if constexpr (kGathers == Gathers::kIntegral) {
        const V sum = hn::Add(colour[0], hn::IfThenElseZero(taking, density));
        colour[0] = hn::And(sum, set((1 << kSumBits) - 1));
        colour[1] = hn::Add(colour[1], hn::ShiftRight<kSumBits>(sum));
        counters.visible_samples += hn::CountTrue(d, hn::And(taking, hn::Ne(density, zero)));
      } else {
        const V entry = classify(density, at, field);
        const V depth = hn::IfThenElseZero(taking, gather(field.tables->depth.data(), hn::ShiftLeft<2>(entry)));
        const Mask visible = hn::Ne(depth, zero);
        if (!hn::AllFalse(d, visible)) {
          counters.visible_samples += hn::CountTrue(d, visible);
          const V weight = weight_of(depth, exponent, opacity, field);
          opacity = hn::Add(opacity, weight);
          if constexpr (kGathers == Gathers::kColour) {
            const Look look = look_of(entry, field);
            const auto seen = field.shaded ? shade(look, resample_gradient(at, field), field) : look.colour;
            for (std::size_t c = 0; c < 3; ++c) {
              colour[c] = hn::Min(hn::Add(colour[c], part_of(seen[c], weight)),
                                  set(static_cast<std::int32_t>(wire::kColourOne)));
            }
          }
        }
      }
    }
    taken = hn::Add(taken, hn::IfThenElseZero(running, steps));
    left = hn::Sub(left, steps);
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = hn::Add(p[axis], hn::Mul(steps, s[axis]));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lanes.position[axis].store(hn::Add(lanes.position[axis].load(), hn::Mul(taken, s[axis])));
    if (kGathers != Gathers::kOpacity) lanes.colour[axis].store(colour[axis]);
  }
  lanes.left.store(hn::Sub(lanes.left.load(), taken));
  lanes.opacity.store(opacity);
}

// The steps after which the ray is out of the volume.
std::int32_t steps_inside(const Traveller& ray, const Frame& frame) {
  if (!inside(ray.position, frame.extent)) return 0;
  std::int32_t least = std::int32_t{1} << 29;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t s = ray.step[axis], p = ray.position[axis];
    if (s > 0) least = std::min(least, (frame.extent[axis] - p) / s + 1);
    if (s < 0) least = std::min(least, p / -s + 1);
  }
  return least;
}

// The rays of a span one after the other on the lanes.
class Exchange {
 public:
  Exchange(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters, std::span<std::int32_t> steps)
      : rays_(rays), frame_(frame), counters_(counters), steps_(steps) {}

  bool has_more() const { return next_ < rays_.size(); }
  std::size_t busy() const { return busy_; }

  // Takes ended rays off their lanes and puts new ones there.
  void serve(Lanes& lanes, std::size_t count) {
    for (std::size_t lane = 0; lane < count; ++lane) {
      Slot& slot = slots_[lane];
      if (slot.ray != nullptr) {
        if (lanes.left.lane[lane] > 0 &&
            lanes.opacity.lane[lane] < static_cast<std::int32_t>(frame_.opacity_threshold)) {
          continue;
        }
        take(lanes, lane);
      }
      if (has_more()) {
        put(lanes, lane);
      } else {
        lanes.left.lane[lane] = 0;
      }
    }
  }

 private:
  struct Slot {
    Traveller traveller;
    wire::Ray* ray = nullptr;
    std::int32_t steps = 0;  // as it set out
  };

  void put(Lanes& lanes, std::size_t lane) {
    Slot& slot = slots_[lane];
    slot.ray = &rays_[next_++];
    slot.traveller = set_out(*slot.ray, frame_);
    const Traveller& ray = slot.traveller;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lanes.position[axis].lane[lane] = ray.position[axis];
      lanes.step[axis].lane[lane] = ray.step[axis];
      lanes.colour[axis].lane[lane] = frame_.integral ? 0 : ray.colour[axis];
    }
    const std::int32_t volume = steps_inside(ray, frame_), limit = std::int32_t{1} << 29,
                       segment = frame_.segments ? static_cast<std::int32_t>(ray.interacted) : limit;
    slot.steps = std::min(volume, segment);
    lanes.left.lane[lane] = slot.steps;
    lanes.more.lane[lane] = segment - slot.steps;
    lanes.exponent.lane[lane] = static_cast<std::int32_t>(ray.exponent);
    lanes.opacity.lane[lane] = static_cast<std::int32_t>(ray.opacity);
    ++busy_;
  }

  void take(const Lanes& lanes, std::size_t lane) {
    Slot& slot = slots_[lane];
    Traveller& ray = slot.traveller;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ray.position[axis] = lanes.position[axis].lane[lane];
      if (!frame_.colourless) ray.colour[axis] = static_cast<std::uint16_t>(lanes.colour[axis].lane[lane]);
    }
    if (frame_.integral) {
      const auto low = static_cast<std::uint64_t>(lanes.colour[0].lane[lane]);
      set_energy(ray.colour, low | static_cast<std::uint64_t>(lanes.colour[1].lane[lane]) << kSumBits);
    }
    if (frame_.segments) ray.interacted -= static_cast<std::uint32_t>(slot.steps - lanes.left.lane[lane]);
    ray.opacity = static_cast<std::uint32_t>(lanes.opacity.lane[lane]);
    count_end(ray, end(ray, frame_), frame_, counters_);
    finish(ray, frame_, *slot.ray);
    if (!steps_.empty()) {
      steps_[static_cast<std::size_t>(slot.ray - rays_.data())] = slot.steps - lanes.left.lane[lane];
    }
    slot.ray = nullptr;
    --busy_;
  }

  std::span<wire::Ray> rays_;
  const Frame& frame_;
  RayCounters& counters_;
  std::span<std::int32_t> steps_;
  std::array<Slot, 16> slots_{};
  std::size_t next_ = 0, busy_ = 0;
};

void trace(std::span<wire::Ray> rays, const Frame& frame, const PacketField& field, RayCounters& counters,
           std::span<std::int32_t> steps) {
  const std::size_t count = hn::Lanes(D32());
  Lanes lanes{};
  Exchange exchange(rays, frame, counters, steps);
  while (true) {
    exchange.serve(lanes, count);
    if (exchange.busy() == 0) return;
    // A few idle lanes cost less than an exchange for each; without new rays one of the busy ones must end.
    const std::size_t enough = exchange.has_more() ? std::max<std::size_t>(count / 4, 1) : count - exchange.busy() + 1;
    switch (field.gathers) {
      case Gathers::kOpacity: march<Gathers::kOpacity>(lanes, field, enough, counters); break;
      case Gathers::kColour: march<Gathers::kColour>(lanes, field, enough, counters); break;
      case Gathers::kIntegral: march<Gathers::kIntegral>(lanes, field, enough, counters); break;
    }
  }
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

HWY_EXPORT(trace);

RayPackets::RayPackets(const OpacityCorrection& correction) : correction_(correction) {
  for (std::size_t i = 0; i < tables_.exp2.size(); ++i) {
    const std::uint64_t here = correction.exp2_at(i), next = correction.exp2_at(i + 1);
    tables_.exp2[i] = here | (here - next) << 32;
  }
}

void RayPackets::clear() {
  copy_.clear();
  volume_ = rays_ = 0;
}

void RayPackets::read(std::span<const wire::SegmentationEntry> segmentation) {
  for (std::size_t i = 0; i < tables_.depth.size(); ++i) {
    const wire::SegmentationEntry& entry = segmentation[i];
    tables_.depth[i] = entry.opacity == wire::kClassifiedOpacityOne ? ~0u : correction_.depth(entry.opacity);
    std::uint64_t look = 0;
    for (std::size_t c = 0; c < 3; ++c) look |= std::uint64_t{entry.colour[c]} << (12 * c);
    tables_.look[i] = look | std::uint64_t{entry.ambient} << 36 | std::uint64_t{entry.reflect} << 44 |
                      std::uint64_t{entry.knee} << 52;
  }
}

bool RayPackets::prepare(std::uint64_t rays, const Frame& frame, std::uint64_t lut_writes, unsigned threads) {
  if (!frame.plain || frame.backprojects || frame.jitter || !frame.cut_planes.empty()) return false;
  const VolumeMemory& volume = *frame.volume;
  if (volume_ != volume.decodings()) {
    clear();
    volume_ = volume.decodings();
  }
  rays_ += rays;
  if (rays_ < volume.stored_blocks()) return false;  // chosen: a block's copy takes about as long as a long ray
  copy_.follow(volume, threads);
  if (copy_.densities() == nullptr) return false;
  if (lut_writes_ != lut_writes) read(frame.segmentation);
  lut_writes_ = lut_writes;
  tables_.first.resize(volume.block_count());
  for (std::size_t block = 0; block < tables_.first.size(); ++block) {
    const bool leap = frame.leap && frame.empty[block] != 0;
    tables_.first[block] = leap ? -1 : static_cast<std::int32_t>(volume.first()[block]);
  }
  if (frame.shade) {
    tables_.reflectance_map.resize(kBeforeMap + wire::kReflectanceBytes);
    std::copy_n(frame.reflectance_map, wire::kReflectanceBytes, tables_.reflectance_map.begin() + kBeforeMap);
  }
  return true;
}

void RayPackets::trace(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters,
                       std::span<std::int32_t> steps) const {
  const VolumeMemory& volume = *frame.volume;
  PacketField field{};
  field.densities = copy_.densities();
  field.voxels = volume.decoded().data();
  field.tags = volume.decoded_tags().empty() ? nullptr : volume.decoded_tags().data();
  field.tables = &tables_;
  field.threshold = static_cast<std::int32_t>(frame.opacity_threshold);
  field.edge = volume.block_voxels() + 1;
  field.block_shift = std::countr_zero(static_cast<unsigned>(volume.block_voxels())) + wire::kPositionFractionBits;
  field.across = volume.blocks()[0];
  field.slice = volume.blocks()[0] * volume.blocks()[1];
  field.gathers = frame.integral ? Gathers::kIntegral : frame.colourless ? Gathers::kOpacity : Gathers::kColour;
  field.shaded = frame.shade;
  HWY_DYNAMIC_DISPATCH(trace)(rays, frame, field, counters, steps);
}

}  // namespace gicube::emu
#endif
