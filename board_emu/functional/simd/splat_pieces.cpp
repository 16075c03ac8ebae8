// Compiled once for each instruction set that Highway knows (foreach_target); the host's best is chosen at run time.
#include "words/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "functional/simd/splat_pieces.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include "splat_pieces.h"

#include <hwy/highway.h>

#include <algorithm>
#include <array>

#include "datapath/trilinear_splat.h"
#include "gicube/wire/ray.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

void splat(std::span<const Piece> pieces, std::int64_t* pairs, std::size_t row, std::size_t slice) {
  splat_one_by_one(pieces, pairs, row, slice);
}

#else

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<std::int32_t, 8>;  // a piece has some twenty samples
using V = hn::Vec<D>;

// upper_part() where the product has 32 bits.
HWY_INLINE V upper(V amount, V fraction) {
  constexpr int kBits = wire::kPositionFractionBits;
  return hn::ShiftRight<kBits>(hn::Add(hn::Mul(amount, fraction), hn::Set(D(), 1 << (kBits - 1))));
}

// A pair's halves as words of 32 bits: a negative lower one takes one from the upper.
struct Pair {
  V low, high;
};
HWY_INLINE Pair pair(V amount, V fraction) {
  const V up = upper(amount, fraction), low = hn::Sub(amount, up);
  return {low, hn::Add(up, hn::ShiftRight<31>(low))};
}

HWY_INLINE void splat_in_vectors(const Piece& piece, std::int64_t* pairs, std::int32_t row, std::int32_t slice) {
  constexpr int kBits = wire::kPositionFractionBits;
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  const V mask = hn::Set(d, wire::kVoxel - 1), amount = hn::Set(d, piece.amount);
  std::array<V, 3> at{}, step{}, rest{}, step_rest{};
  const V whole = hn::Set(d, (1 << kRestBits) - 1), all = hn::Set(d, static_cast<std::int32_t>(lanes));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const V one = hn::Set(d, piece.step[axis]), below = hn::Set(d, piece.step_rest[axis]);
    const V first = hn::Add(hn::Set(d, piece.rest[axis]), hn::Mul(below, hn::Iota(d, 0)));
    at[axis] =
        hn::Add(hn::Add(hn::Set(d, piece.first[axis]), hn::Mul(one, hn::Iota(d, 0))), hn::ShiftRight<kRestBits>(first));
    rest[axis] = hn::And(first, whole);
    step[axis] = hn::Mul(one, all);
    step_rest[axis] = hn::Mul(below, all);
  }
  for (std::size_t done = 0; done < piece.count; done += lanes) {
    alignas(32) std::array<std::int32_t, 8> index;
    alignas(32) std::array<std::int64_t, 16> near, far;  // the pairs at y and y + 1, of each sample
    const V voxel =
        hn::Add(hn::ShiftRight<kBits>(at[0]), hn::Add(hn::Mul(hn::ShiftRight<kBits>(at[1]), hn::Set(d, row)),
                                                      hn::Mul(hn::ShiftRight<kBits>(at[2]), hn::Set(d, slice))));
    hn::Store(voxel, d, index.data());
    const V fx = hn::And(at[0], mask), fy = hn::And(at[1], mask), fz = hn::And(at[2], mask);
    const V back = upper(amount, fz), front = hn::Sub(amount, back);
    const auto store = [&](V part, std::array<std::int64_t, 16>& to) {
      const V up = upper(part, fy);
      const Pair here = pair(hn::Sub(part, up), fx), next = pair(up, fx);
      hn::StoreInterleaved4(here.low, here.high, next.low, next.high, d, reinterpret_cast<std::int32_t*>(to.data()));
    };
    store(front, near);
    store(back, far);
    const std::size_t count = std::min(lanes, piece.count - done);
    for (std::size_t i = 0; i < count; ++i) {
      std::int64_t* const to = pairs + index[i];
      to[0] += near[2 * i];
      to[row] += near[2 * i + 1];
      to[slice] += far[2 * i];
      to[slice + row] += far[2 * i + 1];
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rest[axis] = hn::Add(rest[axis], step_rest[axis]);
      at[axis] = hn::Add(hn::Add(at[axis], step[axis]), hn::ShiftRight<kRestBits>(rest[axis]));
      rest[axis] = hn::And(rest[axis], whole);
    }
  }
}

void splat(std::span<const Piece> pieces, std::int64_t* pairs, std::size_t row, std::size_t slice) {
  constexpr std::int32_t kMax = (1 << (31 - wire::kPositionFractionBits)) - 1;  // whose products have 32 bits
  for (const Piece& piece : pieces) {
    if (piece.amount > kMax || piece.amount < -kMax) {
      splat_one_by_one({&piece, 1}, pairs, row, slice);
    } else {
      splat_in_vectors(piece, pairs, static_cast<std::int32_t>(row), static_cast<std::int32_t>(slice));
    }
  }
}

#endif

}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {
namespace {

// add(word, share of it, share of the word beside it) for each of a sample's four rows.
template <typename Add>
void each_row(std::span<const Piece> pieces, std::size_t row, std::size_t slice, const Add& add) {
  constexpr int kBits = wire::kPositionFractionBits;
  constexpr std::uint32_t kMask = static_cast<std::uint32_t>(wire::kVoxel) - 1;
  for (const Piece& piece : pieces) {
    const FinePoint step = fine(piece.step, piece.step_rest);
    FinePoint place = fine(piece.first, piece.rest);
    for (std::uint32_t i = 0; i < piece.count; ++i, place = moved(place, step, 1)) {
      std::array<std::uint32_t, 3> at{};
      for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = static_cast<std::uint32_t>(place[axis] >> kRestBits);
      const std::size_t word = (at[0] >> kBits) + row * (at[1] >> kBits) + slice * (at[2] >> kBits);
      const SignedShares shares = spread(piece.amount, {at[0] & kMask, at[1] & kMask, at[2] & kMask});
      for (std::size_t k = 0; k < 4; ++k) {
        add(word + row * (k & 1) + slice * (k >> 1), shares[2 * k], shares[2 * k + 1]);
      }
    }
  }
}

}  // namespace

void splat_to_words(std::span<const Piece> pieces, std::int64_t* words, std::size_t row, std::size_t slice) {
  each_row(pieces, row, slice, [words](std::size_t word, std::int64_t share, std::int64_t beside) {
    words[word] += share;
    words[word + 1] += beside;
  });
}

void splat_one_by_one(std::span<const Piece> pieces, std::int64_t* pairs, std::size_t row, std::size_t slice) {
  each_row(pieces, row, slice, [pairs](std::size_t word, std::int64_t share, std::int64_t beside) {
    pairs[word] += share + beside * (std::int64_t{1} << 32);
  });
}

HWY_EXPORT(splat);

void splat(std::span<const Piece> pieces, std::int64_t* pairs, std::size_t row, std::size_t slice) {
  HWY_DYNAMIC_DISPATCH(splat)(pieces, pairs, row, slice);
}

}  // namespace gicube::emu
#endif
