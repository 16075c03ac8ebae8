// Visible samples are queued here until they fill a vector, because only some of the lanes have a visible sample at the
// same time, and shading is most of a sample's cost.
//
// A ray's colour may come later, because its opacity, on which all else depends, is composited at once. The samples of
// a ray keep their order, because sums of floats depend on it. Sums of integers may saturate at each addition or at the
// end.

#include "functional/simd/light-inl.h"

// Accumulated colour of a ray: three channels, floats on the wide datapath. The fourth completes a vector.
struct alignas(16) ColourSum {
  std::array<std::int32_t, 4> channel{};
};

class ShadingQueue {
 public:
  // `rays`: at most 2^18.
  explicit ShadingQueue(std::size_t rays) : sums_(rays) {}

  ColourSum& sum(std::size_t ray) { return sums_[ray]; }

  // Adds the samples of `seen`. `at_face`: other than 0 where a sample is not shaded. `ray`: indices of their rays;
  // `weight`: of the sample in the ray's colour, floats if wide.
  template <bool kWide>
  HWY_INLINE void add(const SamplePosition& at, V entry, V ray, V weight, V lit, V at_face, Mask seen,
                      const PacketField& field) {
    const auto put = [&](Word word, V v) { hn::StoreU(hn::Compress(v, seen), D32(), columns_[word].data() + count_); };
    const PackedPosition place = small(at);
    put(kIndex, place.index);
    put(kXAndY, place.x_and_y);
    put(kZ, place.z);
    put(kEntryAndRay, hn::Or(entry, hn::ShiftLeft<kEntryBits>(ray)));
    put(kWeight, weight);
    if (field.irradiance != nullptr) put(kLit, lit);
    if (field.cut_faces) put(kAtFace, at_face);
    count_ += hn::CountTrue(D32(), seen);
    if (count_ > kMax - hn::Lanes(D32())) shade_full<kWide>(field);
  }

  // Shades all queued samples.
  template <bool kWide>
  void finish(const PacketField& field) {
    shade_full<kWide>(field);
    if (count_ > 0) shade_from<kWide>(0, count_, field);
    count_ = 0;
  }

 private:
  static constexpr std::size_t kMax = 128;  // chosen: a few KiB, and remainders are seldom moved
  static constexpr int kEntryBits = 14;
  static_assert(wire::kSegmentationEntries == 1 << kEntryBits);
  enum Word : std::size_t { kIndex, kXAndY, kZ, kEntryAndRay, kWeight, kLit, kAtFace, kWords };

  template <bool kWide>
  void shade_full(const PacketField& field) {
    const std::size_t lanes = hn::Lanes(D32());
    std::size_t from = 0;
    for (; from + lanes <= count_; from += lanes) shade_from<kWide>(from, lanes, field);
    for (auto& column : columns_) hn::StoreU(hn::LoadU(D32(), column.data() + from), D32(), column.data());
    count_ -= from;
  }

  template <bool kWide>
  HWY_INLINE void shade_from(std::size_t from, std::size_t count, const PacketField& field) {
    const auto get = [&](Word word) { return hn::LoadU(D32(), columns_[word].data() + from); };
    const PackedPosition at{get(kIndex), get(kXAndY), get(kZ)};
    const V entry_and_ray = get(kEntryAndRay), weight = get(kWeight);
    const V entry = hn::And(entry_and_ray, set((1 << kEntryBits) - 1));
    ShadingEntry<V> shading = shading_entry(entry, field);
    if (field.colours != nullptr) {
      const std::array<V, 3> factor = voxel_colour(at, field);
      for (std::size_t c = 0; c < 3; ++c) shading.colour[c] = tinted(shading.colour[c], factor[c]);
    }
    auto seen = field.irradiance != nullptr ? illuminated(shading, entry, at, get(kLit), field)
                : field.frame->shade        ? shade(shading, resample_gradient(at, field), SquareOf{*field.tables})
                                            : shading.colour;
    if (field.cut_faces) {
      const Mask plain = hn::Ne(get(kAtFace), hn::Zero(D32()));
      for (std::size_t c = 0; c < 3; ++c) seen[c] = hn::IfThenElse(plain, shading.colour[c], seen[c]);
    }
    std::array<V, 3> part{};
    for (std::size_t c = 0; c < 3; ++c) {
      if constexpr (kWide) {
        part[c] = hn::BitCast(D32(), hn::Mul(hn::BitCast(DF(), weight), hn::ConvertTo(DF(), seen[c])));
      } else {
        part[c] = part_of(seen[c], weight);
      }
    }
    alignas(64) std::array<ColourSum, 16> parts;
    hn::StoreInterleaved4(part[0], part[1], part[2], hn::Zero(D32()), D32(), parts[0].channel.data());
    for (std::size_t i = 0; i < count; ++i) {
      const auto ray = static_cast<std::uint32_t>(columns_[kEntryAndRay][from + i]) >> kEntryBits;
      add_to<kWide>(sums_[ray], parts[i]);
    }
  }

  template <bool kWide>
  static HWY_INLINE void add_to(ColourSum& sum, const ColourSum& part) {
    const hn::FixedTag<std::int32_t, 4> d;
    const hn::RebindToFloat<decltype(d)> df;
    const auto a = hn::Load(d, sum.channel.data()), b = hn::Load(d, part.channel.data());
    if constexpr (kWide) {
      hn::Store(hn::BitCast(d, hn::Add(hn::BitCast(df, a), hn::BitCast(df, b))), d, sum.channel.data());
    } else {
      hn::Store(hn::Add(a, b), d, sum.channel.data());
    }
  }

  std::vector<ColourSum> sums_;
  std::size_t count_ = 0;
  // The queued samples. Unused elements are old values or zero, which may be read.
  alignas(64) std::array<std::array<std::int32_t, kMax + 16>, kWords> columns_{};
};
