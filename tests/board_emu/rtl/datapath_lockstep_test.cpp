// The datapath in SystemVerilog against board_emu/datapath, bit by bit, on random and on extreme words.
#include <Vadvance.h>
#include <Vcomposite.h>
#include <Vdraw.h>
#include <Vopacity_correction.h>
#include <Vresample.h>
#include <Vsegmentation.h>
#include <Vshade.h>
#include <Vspacing.h>
#include <Vsplit.h>

#include "asic/cache/splat_tiles.h"
#include "datapath/illuminate.h"
#include "datapath/random_stream.h"
#include "datapath/ray_step.h"
#include "datapath/trilinear_splat.h"
#include "lockstep.h"

namespace gicube::emu::lockstep {
namespace {

// Words that are often at an end of their range, or next to one.
class Words {
 public:
  explicit Words(unsigned seed) : chance_(seed, 1) {}

  std::uint64_t bits(std::size_t count) {
    const std::uint64_t most = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
    switch (chance_.below(8)) {
      case 0: return chance_.below(3) & most;
      case 1: return most - chance_.below(3) % (most + (most == ~std::uint64_t{0} ? 0 : 1));
      case 2: return most >> chance_.below(static_cast<std::size_t>(count));
      default: return chance_.word() & most;
    }
  }
  std::int32_t within(std::int32_t least, std::int32_t most) {
    const auto range = static_cast<std::uint64_t>(most - least);
    const std::uint64_t step = chance_.below(8) < 6 ? chance_.word() % (range + 1) : chance_.below(3) % (range + 1);
    return chance_.below(2) == 0 ? least + static_cast<std::int32_t>(step) : most - static_cast<std::int32_t>(step);
  }

 private:
  Chance chance_;
};

template <typename Model>
void write(Clocked<Model>& rtl, std::size_t address, std::uint64_t word) {
  rtl->write = 1;
  put(rtl->write_address, 0, 8 * sizeof rtl->write_address, address);
  put(rtl->write_word, 0, std::min<std::size_t>(64, 8 * sizeof rtl->write_word), word);
  rtl.cycle();
  rtl->write = 0;
}

TEST(ResampleInLockstep, DecodesAndInterpolates) {
  Clocked<Vresample> rtl("resample");
  Words words(1);
  std::vector<ChannelWords> gradients(2048);
  for (std::size_t code = 0; code < gradients.size(); ++code) {
    const auto entry = wire::to_gradient(static_cast<std::uint32_t>(words.bits(30)));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // A gradient has at most the length of a unit vector, so that differences fit a word.
      const auto part = static_cast<std::int16_t>(std::max<std::int16_t>(entry[axis], -511));
      gradients[code].channel[axis + 1] = static_cast<std::int16_t>(part * (1 << kGradientFractionBits));
    }
    wire::GradientEntry part{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      part[axis] = static_cast<std::int16_t>(gradients[code].channel[axis + 1] >> kGradientFractionBits);
    }
    write(rtl, code, wire::to_word(part));
  }
  for (Cycle now = 0; now < cycles(); ++now) {
    std::array<std::int16_t, 8> densities{};
    std::array<std::uint16_t, 8> codes{};
    std::array<std::uint32_t, 8> irradiances{};
    Cell cell{};
    for (std::size_t i = 0; i < 8; ++i) {
      const std::uint64_t density = words.bits(12), code = words.bits(11), tag = words.bits(2);
      densities[i] = static_cast<std::int16_t>(density << kDensityFractionBits);
      codes[i] = static_cast<std::uint16_t>(code | tag << kCodeBits);
      irradiances[i] = static_cast<std::uint32_t>(words.bits(11));
      put(rtl->voxels, 36 * i, 36, density | code << 12 | tag << 23 | std::uint64_t{irradiances[i]} << 25);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell.fraction[axis] = static_cast<std::uint32_t>(words.bits(14));
      put(rtl->fraction, 14 * axis, 14, cell.fraction[axis]);
    }
    rtl.settle();
    BlockView view{};
    view.densities = densities.data();
    view.codes = codes.data();
    view.gradients = gradients.data();
    const SampleSite site{cell, view, 0, 2};
    const Neighbourhood at = around(site);
    ASSERT_EQ(resample_density(densities.data(), at), static_cast<std::int16_t>(rtl->density));
    const Channels gradient = gradient_at(view, at);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(gradient[axis + 1], static_cast<std::int16_t>(bits(rtl->gradient, 16 * axis, 16))) << now;
    }
    ASSERT_EQ(irradiance(irradiances.data(), 2, 4, at.weight, false), rtl->irradiance) << now;
    ASSERT_EQ(tag_at(site, at), rtl->tag) << now;
  }
}

TEST(SegmentationInLockstep, LooksUpEachEntry) {
  Clocked<Vsegmentation> rtl("segmentation");
  Words words(2);
  std::vector<std::array<std::uint64_t, 2>> entries(wire::kSegmentationEntries);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i] = {words.bits(64), words.bits(20)};
    put(rtl->write_word, 64, 20, entries[i][1]);
    write(rtl, i, entries[i][0]);
  }
  for (unsigned tag = 0; tag < 4; ++tag) {
    for (int density = 0; density <= 4095 << kDensityFractionBits; ++density) {
      rtl->density = static_cast<SData>(density);
      rtl->tag = static_cast<CData>(tag);
      rtl.settle();
      const auto& entry = entries[segmentation_index(density, tag)];
      ASSERT_EQ(entry[0], bits(rtl->entry, 0, 64)) << density;
      ASSERT_EQ(entry[1], bits(rtl->entry, 64, 20)) << density;
    }
  }
}

TEST(SpacingInLockstep, JittersAndSteps) {
  Clocked<Vspacing> rtl("spacing");
  Words words(3);
  for (std::size_t i = 0; i < kJitterEntries; ++i) write(rtl, i, kJitterLut[i]);
  Frame frame;
  for (Cycle now = 0; now < cycles(); ++now) {
    RayState ray;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ray.position[axis] = static_cast<std::int32_t>(words.bits(24));
      ray.direction[axis] = static_cast<std::int16_t>(words.bits(16));
      put(rtl->position, 32 * axis, 32, static_cast<std::uint32_t>(ray.position[axis]));
      put(rtl->direction, 16 * axis, 16, static_cast<std::uint16_t>(ray.direction[axis]));
    }
    ray.u = rtl->u = static_cast<SData>(words.bits(16));
    ray.v = rtl->v = static_cast<SData>(words.bits(16));
    ray.length = rtl->voxel_length = static_cast<IData>(words.bits(20));
    frame.step = rtl->frame_step = static_cast<IData>(words.bits(24));
    frame.jitter = words.bits(1) != 0;
    rtl->jitters = frame.jitter;
    rtl.settle();
    frame.jitter ? jitter_step(ray, frame) : space(ray, frame.step, frame);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(ray.step[axis], static_cast<std::int32_t>(bits(rtl->step, 32 * axis, 32))) << now;
    }
    ASSERT_EQ(ray.exponent, rtl->exponent) << now;
  }
}

TEST(OpacityCorrectionInLockstep, RaisesTransparency) {
  Clocked<Vopacity_correction> rtl("opacity_correction");
  Words words(4);
  const OpacityCorrection correction;
  // The tables, from the depths of transparencies 2^15 + segment * 2^5 and from the other one's entries.
  const std::uint32_t full_scale = correction.depth(wire::kClassifiedOpacityOne - 1);
  rtl->full_scale = full_scale;
  for (std::size_t i = 0; i <= OpacityCorrection::kSegments; ++i) {
    rtl->write_address = static_cast<SData>(i);
    const auto alpha = static_cast<std::uint16_t>(wire::kClassifiedOpacityOne - (0x8000u + 32 * i));
    rtl->write_word = i == OpacityCorrection::kSegments ? 1u << 24 : full_scale - correction.depth(alpha) - (15u << 24);
    rtl->write_log2 = 1;
    rtl.cycle();
    rtl->write_log2 = 0;
    rtl->write_word = correction.exp2_at(i);
    rtl->write_exp2 = 1;
    rtl.cycle();
    rtl->write_exp2 = 0;
  }
  for (Cycle now = 0; now < cycles(); ++now) {
    rtl->alpha = static_cast<SData>(now < 65536 ? now : words.bits(16));
    rtl->exponent = static_cast<IData>(words.bits(words.bits(1) != 0 ? 32 : 20));
    rtl.settle();
    ASSERT_EQ(correction(rtl->alpha, rtl->exponent), rtl->result) << rtl->alpha << ' ' << rtl->exponent;
  }
}

TEST(ShadeInLockstep, ReadsTheReflectanceMap) {
  Clocked<Vshade> rtl("shade");
  Words words(5);
  std::vector<std::uint8_t> map(wire::kReflectanceBytes + 256);
  for (std::size_t i = 0; i < wire::kReflectanceBytes; ++i) {
    map[i] = static_cast<std::uint8_t>(words.bits(8));
    write(rtl, i, map[i]);
  }
  for (Cycle now = 0; now < cycles(); ++now) {
    Point gradient{};
    const std::int32_t longest = static_cast<std::int32_t>(words.bits(2)) == 0 ? 40 : kGradientUnit;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gradient[axis] = words.within(-longest, longest);
      put(rtl->gradient, 16 * axis, 16, static_cast<std::uint16_t>(gradient[axis]));
    }
    wire::SegmentationEntry entry;
    for (std::size_t c = 0; c < 3; ++c) {
      entry.colour[c] = static_cast<std::uint16_t>(words.bits(12));
      put(rtl->entry, 12 * c, 12, entry.colour[c]);
    }
    entry.ambient = static_cast<std::uint8_t>(words.bits(8));
    entry.reflect = static_cast<std::uint8_t>(words.bits(8));
    entry.knee = static_cast<std::uint8_t>(words.bits(8));
    put(rtl->entry, 52, 24, entry.ambient | std::uint64_t{entry.reflect} << 8 | std::uint64_t{entry.knee} << 16);
    rtl.settle();
    const Colour12 colour = shade(entry, gradient, map.data());
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(colour[c], static_cast<std::int32_t>(bits(rtl->colour, 12 * c, 12)))
          << gradient[0] << ' ' << gradient[1] << ' ' << gradient[2];
    }
  }
}

TEST(CompositeInLockstep, AddsASampleBehindTheRay) {
  Clocked<Vcomposite> rtl("composite");
  Words words(6);
  for (Cycle now = 0; now < cycles(); ++now) {
    RayState ray;
    Colour12 colour{};
    for (std::size_t c = 0; c < 3; ++c) {
      ray.colour[c] = static_cast<std::uint16_t>(words.bits(12));
      colour[c] = static_cast<std::int32_t>(words.bits(12));
      put(rtl->ray_colour, 12 * c, 12, ray.colour[c]);
      put(rtl->colour, 12 * c, 12, static_cast<std::uint32_t>(colour[c]));
    }
    ray.opacity = rtl->ray_opacity = static_cast<IData>(words.bits(24));
    rtl->alpha = static_cast<IData>(words.bits(24));
    rtl.settle();
    over(ray, colour, rtl->alpha);
    ASSERT_EQ(ray.opacity, rtl->next_opacity) << now;
    ASSERT_EQ(contribution(ray.opacity), rtl->contribution) << now;
    for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(ray.colour[c], bits(rtl->next_colour, 12 * c, 12)) << now;
  }
}

TEST(AdvanceInLockstep, StepsAndSkips) {
  Clocked<Vadvance> rtl("advance");
  Words words(7);
  constexpr std::int32_t kEdge = 32 * wire::kVoxel;
  Frame frame;
  for (Cycle now = 0; now < cycles(); ++now) {
    RayState ray;
    Point low{};
    const auto least = static_cast<std::int32_t>(words.bits(2)) == 0 ? 1 : 300;  // at most a block's steps of each
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = kEdge * words.within(0, 7);
      ray.position[axis] = low[axis] + words.within(0, kEdge - 1);
      const std::int32_t size = words.within(least, 4 * wire::kVoxel);
      ray.step[axis] = words.bits(3) == 0 ? 0 : words.bits(1) != 0 ? size : -size;
      frame.extent[axis] = 8 * kEdge - wire::kVoxel - words.within(0, kEdge);
      put(rtl->position, 32 * axis, 32, static_cast<std::uint32_t>(ray.position[axis]));
      put(rtl->step, 32 * axis, 32, static_cast<std::uint32_t>(ray.step[axis]));
      put(rtl->low, 32 * axis, 32, static_cast<std::uint32_t>(low[axis]));
      put(rtl->extent, 32 * axis, 32, static_cast<std::uint32_t>(frame.extent[axis]));
    }
    if (ray.step == Point{}) ray.step[0] = 1, put(rtl->step, 0, 32, 1);
    rtl->skips = words.bits(1) != 0;
    rtl.settle();
    const std::int32_t steps = rtl->skips ? skip_steps(ray, low, kEdge, frame) : 1;
    ASSERT_EQ(steps, static_cast<std::int32_t>(rtl->steps)) << now;
    std::array<std::int64_t, 3> next{};
    bool fits = true;  // other axes may go beyond any volume where one hardly moves
    for (std::size_t axis = 0; axis < 3; ++axis) {
      next[axis] = ray.position[axis] + std::int64_t{steps} * ray.step[axis];
      fits = fits && std::abs(next[axis]) < (std::int64_t{1} << 31);
    }
    if (!fits) continue;
    advance(ray, steps, frame);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(ray.position[axis], static_cast<std::int32_t>(bits(rtl->next, 32 * axis, 32))) << now;
    }
    ASSERT_EQ(inside(ray.position, frame.extent), rtl->is_inside != 0) << now;
  }
}

TEST(SplitInLockstep, SharesWholeUnits) {
  Clocked<Vsplit> rtl("split");
  Words words(8);
  for (Cycle now = 0; now < cycles(); ++now) {
    std::array<std::uint32_t, 3> fraction{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      fraction[axis] = static_cast<std::uint32_t>(words.bits(14));
      put(rtl->fraction, 14 * axis, 14, fraction[axis]);
    }
    rtl->units = static_cast<IData>(words.bits(words.bits(1) != 0 ? 32 : 8));
    const std::uint64_t chance = words.bits(64);
    rtl->offset = static_cast<IData>(chance >> 36);
    rtl.settle();
    const Shares shares = split(rtl->units, fraction, chance);
    for (std::size_t i = 0; i < 8; ++i) ASSERT_EQ(shares[i], bits(rtl->shares, 32 * i, 32)) << now;
  }
}

TEST(DrawInLockstep, HashesRayAndPlace) {
  Clocked<Vdraw> rtl("draw");
  Words words(9);
  for (Cycle now = 0; now < cycles(); ++now) {
    std::array<std::int32_t, 3> position{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = static_cast<std::int32_t>(words.bits(32));
      put(rtl->position, 32 * axis, 32, static_cast<std::uint32_t>(position[axis]));
    }
    rtl->what = static_cast<CData>(1 + words.bits(3));
    rtl->u = static_cast<SData>(words.bits(16));
    rtl->v = static_cast<SData>(words.bits(16));
    rtl->lifetime = static_cast<SData>(words.bits(16));
    rtl->seed = static_cast<IData>(words.bits(32));
    rtl.settle();
    const auto what = static_cast<RandomStream>(rtl->what);
    ASSERT_EQ(draw(what, rtl->u, rtl->v, rtl->lifetime, rtl->seed), rtl->of_segment) << now;
    ASSERT_EQ(draw_at(what, position, rtl->u, rtl->v, rtl->lifetime, rtl->seed), rtl->of_place) << now;
  }
}

}  // namespace
}  // namespace gicube::emu::lockstep
