// Compiled once for each instruction set of Highway (foreach_target); the host's best is chosen at run time.
#include "words/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "functional/simd/splat_pieces.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include "splat_pieces.h"

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "datapath/trilinear_splat.h"
#include "gicube/wire/ray.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

void splat(std::span<const Piece> pieces, const Tile& tile, std::int32_t* cells) {
  splat_one_by_one(pieces, tile, cells);
}
void join(const Tile& tile, std::int32_t* cells, std::int64_t* words) { join_one_by_one(tile, cells, words); }

#else

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<std::int32_t, 8>;  // a piece has some twenty samples
using V = hn::Vec<D>;
using D16 = hn::Repartition<std::int16_t, D>;
using V16 = hn::Vec<D16>;
constexpr int kBits = wire::kPositionFractionBits;

// A node of the trilinear tree run backwards, for amounts of 16 bits and fractions of 15: `all` keeps the lower half.
HWY_INLINE void halve(V16& all, V16& high, V16 fraction) {
  high = hn::MulFixedPoint15(all, fraction);  // upper_part()
  all = hn::Sub(all, high);
}

// spread() for each lane. Without loops, because compilers would keep them and put the shares into memory.
HWY_INLINE std::array<V16, 8> spread_lanes(V16 amount, const std::array<V16, 3>& fraction) {
  V16 a = amount, b, c, d, e, f, g, h;
  halve(a, e, fraction[2]);
  halve(a, c, fraction[1]);
  halve(e, g, fraction[1]);
  halve(a, b, fraction[0]);
  halve(c, d, fraction[0]);
  halve(e, f, fraction[0]);
  halve(g, h, fraction[0]);
  return {a, b, c, d, e, f, g, h};
}

// Positions of consecutive samples of a piece, one per lane, relative to the tile's corner.
template <bool kWide>
struct Places {
  HWY_INLINE explicit Places(const Piece& piece) {
    const D d;
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const V one = hn::Set(d, piece.step[axis]);
      at[axis] = hn::Add(hn::Set(d, piece.first[axis]), hn::Mul(one, hn::Iota(d, 0)));
      step[axis] = hn::Set(d, piece.step[axis] * lanes);
      if constexpr (!kWide) continue;
      const V begin = hn::Add(hn::Set(d, piece.rest[axis]), hn::Mul(hn::Set(d, piece.step_rest[axis]), hn::Iota(d, 0)));
      at[axis] = hn::Add(at[axis], hn::ShiftRight<kRestBits>(begin));
      rest[axis] = hn::And(begin, hn::Set(d, (1 << kRestBits) - 1));
      step_rest[axis] = hn::Set(d, piece.step_rest[axis] * lanes);
    }
  }

  HWY_INLINE void advance() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis] = hn::Add(at[axis], step[axis]);
      if constexpr (!kWide) continue;
      rest[axis] = hn::Add(rest[axis], step_rest[axis]);
      at[axis] = hn::Add(at[axis], hn::ShiftRight<kRestBits>(rest[axis]));
      rest[axis] = hn::And(rest[axis], hn::Set(D(), (1 << kRestBits) - 1));
    }
  }

  // First words of the samples' cells.
  HWY_INLINE V words(int across_bits) const {
    const V x = hn::ShiftRight<kBits>(at[0]), y = hn::ShiftRight<kBits>(at[1]), z = hn::ShiftRight<kBits>(at[2]);
    const V rows = hn::Add(hn::ShiftLeftSame(z, across_bits), y);
    return hn::ShiftLeft<3>(hn::Add(hn::ShiftLeftSame(rows, across_bits), x));
  }

  std::array<V, 3> at, step, rest, step_rest;
};

constexpr std::size_t kMaxLanes = 8, kMaxAcross = 64;

// Adds a sample's eight shares to its cell.
HWY_INLINE void add_to_cell(const std::int16_t* shares, std::int32_t* cell) {
  const D d;
  for (std::size_t k = 0; k < 8; k += hn::Lanes(d)) {
    const V share = hn::PromoteTo(d, hn::Load(hn::Rebind<std::int16_t, D>(), shares + k));
    hn::Store(hn::Add(hn::Load(d, cell + k), share), d, cell + k);
  }
}

// Samples whose amounts have 16 bits, of all pieces one after the other, so that no lane is idle.
class Samples {
 public:
  template <bool kWide>
  HWY_INLINE void append(const Piece& piece, int across_bits, std::int32_t* cells) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    const V whole = hn::Set(d, 2 * wire::kVoxel - 1), upper_whole = hn::ShiftLeft<16>(whole);
    const V amount = hn::ShiftLeft<16>(hn::Set(d, piece.amount));
    Places<kWide> places(piece);
    std::size_t count = count_;
    for (std::size_t left = piece.count; left > 0; left -= std::min(left, lanes), places.advance()) {
      hn::StoreU(places.words(across_bits), d, words_.data() + count);
      const V x = hn::And(hn::ShiftLeft<1>(places.at[0]), whole);
      const V y = hn::And(hn::ShiftLeft<17>(places.at[1]), upper_whole);
      const V z = hn::And(hn::ShiftLeft<1>(places.at[2]), whole);
      hn::StoreU(hn::Or(x, y), d, xy_.data() + count);
      hn::StoreU(hn::Or(z, amount), d, z_and_amount_.data() + count);
      count += std::min(left, lanes);
      if (count < kFull) continue;
      count_ = std::exchange(count, 0);
      splat(cells);
    }
    count_ = count;
  }

  // Adds all samples to the cells.
  void splat(std::int32_t* cells) {
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t i = count_; i < count_ + 2 * lanes; ++i) words_[i] = z_and_amount_[i] = 0;  // samples of amount 0
    for (std::size_t i = 0; i < count_; i += 2 * lanes) {
      alignas(32) std::array<std::int32_t, 8 * kMaxLanes> parts;  // two shares each
      const Halves xy(xy_.data() + i), z_and_amount(z_and_amount_.data() + i);
      const auto shares = spread_lanes(z_and_amount.upper, std::array{xy.lower, xy.upper, z_and_amount.lower});
      const auto lower = [&](std::size_t k) {
        return hn::BitCast(d, hn::InterleaveLower(D16(), shares[2 * k], shares[2 * k + 1]));
      };
      const auto upper = [&](std::size_t k) {
        return hn::BitCast(d, hn::InterleaveUpper(D16(), shares[2 * k], shares[2 * k + 1]));
      };
      hn::StoreInterleaved4(lower(0), lower(1), lower(2), lower(3), d, parts.data());
      hn::StoreInterleaved4(upper(0), upper(1), upper(2), upper(3), d, parts.data() + 4 * lanes);
      // Interleaving works in blocks of four lanes, which gives the samples this order.
      const auto* const share = reinterpret_cast<const std::int16_t*>(parts.data());
      HWY_UNROLL(16)
      for (std::size_t k = 0; k < 2 * lanes; ++k) {
        const std::size_t sample = k % lanes / 4 * 4 + k % 4 / 2 + 2 * (k / lanes) + k % 2 * lanes;
        add_to_cell(share + 8 * k, cells + words_[i + sample]);
      }
    }
    count_ = 0;
  }

 private:
  // The halves of the words of two vectors of samples; of each two lanes, the first comes from the first vector.
  struct Halves {
    HWY_INLINE explicit Halves(const std::int32_t* words) {
      const D d;
      const V one = hn::Load(d, words), other = hn::Load(d, words + hn::Lanes(d));
      lower = hn::OddEven(hn::BitCast(D16(), hn::ShiftLeft<16>(other)), hn::BitCast(D16(), one));
      upper = hn::OddEven(hn::BitCast(D16(), other), hn::BitCast(D16(), hn::ShiftRight<16>(one)));
    }
    V16 lower, upper;
  };

  static constexpr std::size_t kFull = 512;
  using Words = std::array<std::int32_t, kFull + 3 * kMaxLanes>;
  alignas(32) Words words_, xy_, z_and_amount_;
  std::size_t count_ = 0;
};

void splat(std::span<const Piece> pieces, const Tile& tile, std::int32_t* cells) {
  constexpr std::int32_t kHalves = (1 << 15) - 1;
  const int bits = std::countr_zero(tile.across);
  Samples samples;
  for (const Piece& piece : pieces) {
    if (piece.amount > kHalves || piece.amount < -kHalves) {
      splat_one_by_one({&piece, 1}, tile, cells);
    } else {
      piece.wide ? samples.append<true>(piece, bits, cells) : samples.append<false>(piece, bits, cells);
    }
  }
  samples.splat(cells);
}

// The shares of a row of cells for one of the four rows of voxels around it.
struct Row {
  alignas(32) std::array<std::int32_t, kMaxAcross> lower;
  std::array<std::int32_t, kMaxAcross + kMaxLanes> upper;  // from the row's second voxel on
};

// Splits the row's shares by rows of voxels, and clears the cells.
HWY_INLINE void take_row(std::int32_t* cells, std::size_t across, std::array<Row, 4>& rows) {
  const D d;
  const hn::Repartition<std::uint64_t, D> two;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t x = 0; x < across; x += lanes, cells += 8 * lanes) {
    std::array<hn::Vec<decltype(two)>, 4> near,
        far;  // first and second half of the cells: both shares of a row
    const auto* const shares = reinterpret_cast<const std::uint64_t*>(cells);
    hn::LoadInterleaved4(two, shares, near[0], near[1], near[2], near[3]);
    hn::LoadInterleaved4(two, shares + 2 * lanes, far[0], far[1], far[2], far[3]);
    for (std::size_t i = 0; i < 8; ++i) hn::Store(hn::Zero(d), d, cells + i * lanes);
    for (std::size_t k = 0; k < 4; ++k) {
      const V one = hn::BitCast(d, near[k]), other = hn::BitCast(d, far[k]);
      hn::Store(hn::ConcatEven(d, other, one), d, rows[k].lower.data() + x);
      hn::StoreU(hn::ConcatOdd(d, other, one), d, rows[k].upper.data() + 1 + x);
    }
  }
}

HWY_INLINE void add_row(const Row& row, std::size_t across, std::int64_t* words) {
  const hn::CappedTag<std::int64_t, kMaxLanes / 2> d64;
  const hn::Rebind<std::int32_t, decltype(d64)> d32;
  for (std::size_t x = 0; x < across; x += hn::Lanes(d64)) {
    const auto sum = hn::Add(hn::Load(d32, row.lower.data() + x), hn::LoadU(d32, row.upper.data() + x));
    hn::StoreU(hn::Add(hn::LoadU(d64, words + x), hn::PromoteTo(d64, sum)), d64, words + x);
  }
  words[across] += row.upper[across];
}

void join(const Tile& tile, std::int32_t* cells, std::int64_t* words) {
  const std::size_t row = tile.across + 1, slice = row * row;
  std::array<Row, 4> rows;
  for (Row& each : rows) each.upper[0] = 0;
  for (std::size_t z = 0; z < tile.depth; ++z) {
    for (std::size_t y = 0; y < tile.across; ++y, cells += 8 * tile.across) {
      take_row(cells, tile.across, rows);
      for (std::size_t k = 0; k < 4; ++k) {
        add_row(rows[k], tile.across, words + row * (y + (k & 1)) + slice * (z + (k >> 1)));
      }
    }
  }
}

#endif

}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

void splat_one_by_one(std::span<const Piece> pieces, const Tile& tile, std::int32_t* cells) {
  constexpr int kBits = wire::kPositionFractionBits;
  constexpr std::uint32_t kMask = static_cast<std::uint32_t>(wire::kVoxel) - 1;
  for (const Piece& piece : pieces) {
    const FinePoint step = fine(piece.step, piece.step_rest);
    FinePoint place = fine(piece.first, piece.rest);
    for (std::uint32_t i = 0; i < piece.count; ++i, place = moved(place, step, 1)) {
      std::array<std::uint32_t, 3> at{};
      for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = static_cast<std::uint32_t>(place[axis] >> kRestBits);
      const std::size_t cell =
          (at[0] >> kBits) + tile.across * ((at[1] >> kBits) + tile.across * std::size_t{at[2] >> kBits});
      const SignedShares shares = spread(piece.amount, {at[0] & kMask, at[1] & kMask, at[2] & kMask});
      for (std::size_t k = 0; k < 8; ++k) cells[8 * cell + k] += shares[k];
    }
  }
}

void join_one_by_one(const Tile& tile, std::int32_t* cells, std::int64_t* words) {
  const std::size_t row = tile.across + 1, slice = row * row;
  for (std::size_t z = 0; z < tile.depth; ++z) {
    for (std::size_t y = 0; y < tile.across; ++y) {
      std::int64_t* const to = words + row * y + slice * z;
      for (std::size_t x = 0; x < tile.across; ++x, cells += 8) {
        for (std::size_t k = 0; k < 8; ++k) to[x + (k & 1) + row * (k >> 1 & 1) + slice * (k >> 2)] += cells[k];
        std::fill_n(cells, 8, 0);
      }
    }
  }
}

HWY_EXPORT(splat);

void splat(std::span<const Piece> pieces, const Tile& tile, std::int32_t* cells) {
  HWY_DYNAMIC_DISPATCH(splat)(pieces, tile, cells);
}

HWY_EXPORT(join);

void join(const Tile& tile, std::int32_t* cells, std::int64_t* words) {
  HWY_DYNAMIC_DISPATCH(join)(tile, cells, words);
}

}  // namespace gicube::emu
#endif
