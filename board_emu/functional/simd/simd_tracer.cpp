// Compiled once for each instruction set of Highway (foreach_target); the host's best is chosen at run time.
#include "words/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "functional/simd/simd_tracer.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include "simd_tracer.h"

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <new>
#include <vector>

#include "datapath/illuminate.h"
#include "datapath/interaction.h"
#include "functional/functional.h"

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

#include "functional/simd/lane_scheduler-inl.h"

template <Gathers kGathers, bool kJitter, bool kWide>
void trace_with(LaneScheduler& exchange, const PacketField& field, RayCounters& counters) {
  exchange.run<Lanes>([&](Lanes& lanes, std::size_t enough) {
    march<kGathers, kJitter, kWide>(lanes, exchange.seen(), field, enough, counters);
  });
  if constexpr (kGathers == Gathers::kColour) exchange.seen().finish<kWide>(field);
  exchange.finish_colours();
}

template <Gathers kGathers, bool kJitter>
void trace_gathering(LaneScheduler& exchange, const PacketField& field, RayCounters& counters) {
  return field.frame->wide ? trace_with<kGathers, kJitter, true>(exchange, field, counters)
                           : trace_with<kGathers, kJitter, false>(exchange, field, counters);
}

void trace(std::span<wire::Ray> rays, const Frame& frame, const PacketField& field, RayCounters& counters,
           std::span<std::int32_t> steps) {
  LaneScheduler exchange(rays, frame, counters, steps);
  switch (field.gathers) {
    case Gathers::kOpacity:
      return frame.jitter ? trace_gathering<Gathers::kOpacity, true>(exchange, field, counters)
                          : trace_gathering<Gathers::kOpacity, false>(exchange, field, counters);
    case Gathers::kColour:
      return frame.jitter ? trace_gathering<Gathers::kColour, true>(exchange, field, counters)
                          : trace_gathering<Gathers::kColour, false>(exchange, field, counters);
    case Gathers::kIntegral: return trace_gathering<Gathers::kIntegral, false>(exchange, field, counters);
  }
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

HWY_EXPORT(trace);

namespace {

// The exponent of all samples of the frame (space()); 0 if each ray has its own.
std::uint32_t common_exponent(const Frame& frame) {
  const auto& spacing = frame.spacing;
  if (frame.jitter || frame.segments() || spacing[0] != spacing[1] || spacing[1] != spacing[2]) return 0;
  RayState ray;
  ray.length = spacing[0];
  space(ray, frame.step, frame);
  return ray.exponent;
}

}  // namespace

SimdTracer::SimdTracer(const OpacityCorrection& correction) : correction_(correction) {
  for (std::size_t i = 0; i < tables_.exp2.size(); ++i) {
    const std::uint64_t here = correction.exp2_at(i), next = correction.exp2_at(i + 1);
    tables_.exp2[i] = here | (here - next) << 32;
  }
}

void SimdTracer::clear() {
  irradiance_.clear();
  ranges_.clear();
  volume_ = rays_ = 0;
  lut_writes_ = ~std::uint64_t{0};
}

void SimdTracer::read(std::span<const wire::SegmentationEntry> segmentation) {
  for (std::size_t i = 0; i < tables_.depth.size(); ++i) {
    const wire::SegmentationEntry& entry = segmentation[i];
    tables_.depth[i] = entry.opacity == wire::kClassifiedOpacityOne ? ~0u : correction_.depth(entry.opacity);
    const auto [red, green, blue] = entry.colour;
    const std::uint32_t low = red | std::uint32_t{green} << 12 | std::uint32_t{entry.ambient} << 24;
    const std::uint32_t high = blue | std::uint32_t{entry.reflect} << 12 | std::uint32_t{entry.knee} << 20;
    tables_.shading[i] = low | std::uint64_t{high} << 32;
  }
  tables_.specular.clear();
  if (std::all_of(segmentation.begin(), segmentation.end(), [](const auto& entry) { return entry.specular == 0; }))
    return;
  for (const wire::SegmentationEntry& entry : segmentation) tables_.specular.push_back(entry.specular);
  tables_.specular.resize(segmentation.size() + 3);  // four bytes are read at any index
}

void SimdTracer::correct(const Frame& frame, bool lut_changed) {
  const std::uint32_t exponent = common_exponent(frame);
  const bool wide = gathers_wide(frame);
  if (exponent_ == exponent && wide_ == wide && !lut_changed) return;
  exponent_ = exponent;
  wide_ = wide;
  tables_.alpha.clear();
  if (exponent == 0) return;
  for (std::size_t i = 0; i < wire::kSegmentationEntries; ++i) {
    const std::uint16_t opacity = frame.segmentation[i].opacity;
    const bool seen = wide ? frame.wide_depths[i] != 0 : opacity != 0;
    const std::uint32_t alpha = wide ? std::bit_cast<std::uint32_t>(wide_alpha(frame.wide_depths[i], exponent))
                                     : correction_(opacity, exponent);
    tables_.alpha.push_back(seen ? 1 + alpha : 0);
  }
}

bool SimdTracer::follow_irradiance(const Frame& frame) {
  if (!frame.lit_by_irradiance) {
    irradiance_.clear();
    return true;
  }
  const std::size_t edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  irradiance_.follow({frame.irradiance, frame.light_words}, frame.volume->block_count(), edge * edge * edge,
                     frame.wide);
  return irradiance_.words() != nullptr;
}

void SimdTracer::find_seen(const Frame& frame, unsigned threads) {
  ranges_.follow(*frame.volume, threads);
  constexpr std::size_t kDensities = wire::kSegmentationEntries / wire::kTags;
  // Number of a tag's visible entries below a density. All entries visible on the paper's datapath are visible on the
  // wide one.
  std::array<std::array<std::uint16_t, kDensities + 1>, wire::kTags> below{};
  for (std::size_t i = 0; i < wire::kSegmentationEntries; ++i) {
    const bool seen = frame.segmentation[i].opacity != 0 || (!frame.wide_depths.empty() && frame.wide_depths[i] != 0);
    auto& of_tag = below[i / kDensities];
    of_tag[i % kDensities + 1] = static_cast<std::uint16_t>(of_tag[i % kDensities] + (seen ? 1 : 0));
  }
  const auto seen = [&below](const CellRange& cell) {
    for (unsigned tags = cell.tags; tags != 0; tags &= tags - 1) {
      const auto& of_tag = below[static_cast<std::size_t>(std::countr_zero(tags))];
      if (of_tag[cell.most + 1u] != of_tag[cell.least]) return std::uint8_t{1};
    }
    return std::uint8_t{0};
  };
  seen_.resize(ranges_.cells().size());
  std::transform(ranges_.cells().begin(), ranges_.cells().end(), seen_.begin(), seen);
}

void SimdTracer::find_first(const Frame& frame) {
  const VolumeMemory& volume = *frame.volume;
  const std::array<int, 3>& size = ranges_.size();
  const auto cells = static_cast<std::size_t>(volume.block_voxels()) >> CellRanges::kEdgeShift;  // per block, along x
  const auto blocks = static_cast<std::size_t>(volume.blocks()[0]), down = static_cast<std::size_t>(volume.blocks()[1]);
  const auto rows = static_cast<std::size_t>(size[1]), slices = static_cast<std::size_t>(size[2]);
  // Jittered rays have their own sample positions, and integrals also take invisible samples.
  const bool passes = !frame.jitter && !frame.integral();
  tables_.first.resize(seen_.size());
  std::size_t cell = 0;
  for (std::size_t row = 0; row < rows * slices; ++row) {
    const std::size_t begin = blocks * (row % rows / cells + down * (row / rows / cells));
    for (std::size_t block = begin; block < begin + blocks; ++block, cell += cells) {
      std::int32_t* const out = tables_.first.data() + cell;
      if (frame.skip_empty && frame.empty[block] != 0) {
        std::fill_n(out, cells, kSkipped);
        continue;
      }
      const auto first = static_cast<std::int32_t>(volume.first()[block]);
      for (std::size_t i = 0; i < cells; ++i) out[i] = passes && seen_[cell + i] == 0 ? kUnseen : first;
    }
  }
}

bool SimdTracer::prepare(std::uint64_t rays, const Frame& frame, std::uint64_t lut_writes, unsigned threads) {
  if (frame.backprojects()) return false;
  if (!frame.gathers() && (frame.jitter || frame.segments())) return false;
  if (frame.jitter && (frame.segments() || frame.integral())) return false;
  const VolumeMemory& volume = *frame.volume;
  if (volume_ != volume.decodings()) {
    clear();
    volume_ = volume.decodings();
  }
  rays_ += rays;
  if (rays_ < volume.stored_blocks()) return false;   // chosen: a block's ranges take about as long as a long ray
  constexpr std::size_t kMax = std::size_t{1} << 30;  // byte offsets have 31 bits
  if (volume.decoded_densities().size() >= kMax || !follow_irradiance(frame)) return false;
  const bool lut_changed = lut_writes_ != lut_writes;  // also after clear()
  lut_writes_ = lut_writes;
  if (lut_changed) {
    read(frame.segmentation);
    find_seen(frame, threads);
  }
  correct(frame, lut_changed);
  find_first(frame);
  if (frame.jitter) {
    for (std::size_t i = 0; i < kJitterEntries; ++i) {
      tables_.distance[i] = static_cast<std::int32_t>(jittered(frame, kJitterLut[i]));
    }
  }
  if (!frame.plain() || (frame.shade && !frame.colourless() && !frame.integral())) {
    constexpr std::size_t kRow = wire::kReflectanceSize;
    const auto texel = [&](std::size_t i) {  // results for the last row and column are unused
      return i < wire::kReflectanceBytes ? std::uint32_t{frame.reflectance_map[i]} : 0;
    };
    tables_.reflectance_map.resize(wire::kReflectanceBytes);
    for (std::size_t i = 0; i < wire::kReflectanceBytes; ++i) {
      tables_.reflectance_map[i] = texel(i) | texel(i + 1) << 8 | texel(i + kRow) << 16 | texel(i + kRow + 1) << 24;
    }
  }
  return true;
}

PacketField SimdTracer::field_of(const Frame& frame) const {
  const VolumeMemory& volume = *frame.volume;
  PacketField field{};
  field.frame = &frame;
  field.densities = volume.decoded_densities().data();
  field.codes = volume.decoded_codes().empty() ? nullptr : volume.decoded_codes().data();
  field.gradients = volume.gradients().data();
  field.tagged = volume.has_tags();
  field.colours = volume.decoded_colours().empty() ? nullptr : volume.decoded_colours().data();
  field.premultiplied = volume.format() == wire::VoxelFormat::kRgba;
  field.tables = &tables_;
  field.corrected = !tables_.alpha.empty() && frame.gathers();
  field.opacities = field.corrected       ? static_cast<const void*>(tables_.alpha.data())
                    : gathers_wide(frame) ? static_cast<const void*>(frame.wide_depths.data())
                                          : tables_.depth.data();
  if (frame.lit_by_irradiance) {
    field.irradiance = irradiance_.words();
    field.irradiance_plane = frame.light_words > 1 ? irradiance_.plane() : 0;
    field.irradiance_first = irradiance_.first();
    field.specular = tables_.specular.empty() ? nullptr : tables_.specular.data();
  }
  field.threshold = static_cast<std::int32_t>(frame.opacity_threshold);
  field.edge = volume.block_voxels() + 1;
  field.block_shift = std::countr_zero(static_cast<unsigned>(volume.block_voxels())) + wire::kPositionFractionBits;
  field.across = volume.blocks()[0];
  field.slice = volume.blocks()[0] * volume.blocks()[1];
  field.cells_across = ranges_.size()[0];
  field.cells_slice = ranges_.size()[0] * ranges_.size()[1];
  field.gathers = frame.integral() ? Gathers::kIntegral : frame.colourless() ? Gathers::kOpacity : Gathers::kColour;
  field.cut_faces = frame.shade && frame.cut_faces && !frame.lit_by_irradiance;
  return field;
}

void SimdTracer::trace(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters,
                       std::span<std::int32_t> steps) const {
  HWY_DYNAMIC_DISPATCH(trace)(rays, frame, field_of(frame), counters, steps);
}

}  // namespace gicube::emu
#endif
