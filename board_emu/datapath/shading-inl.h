// Colours of classified samples: shading by the reflectance map, light by irradiance, and voxels' colours [P §2.1,
// §3.4]. One source: it is included into the namespace of a ray alone, where an `Int` is a std::int32_t
// (datapath/one_lane.h), and into that of each instruction set (functional/simd), where it is a vector of them.
// Quotients are IEEE single precision, correctly rounded, hence the same on every machine and in every lane.

// An entry of the segmentation LUT.
template <class Int>
struct ShadingEntry {
  std::array<Int, 3> colour;
  Int ambient, reflect, knee;
};

// Bilinear reflectance of the normal opposite to `gradient`, which is not zero; 15 fraction bits. `square(i)`: texels i
// and i + 1, and those of the next row, in the bytes of a word.
template <class Int, class Square>
[[gnu::always_inline]] inline Int reflectance(const std::array<Int, 3>& gradient, const Square& square) {
  const auto number = [&](std::int32_t x) { return like(gradient[0], x); };
  std::array<Int, 3> normal, size;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    normal[axis] = number(0) - gradient[axis];
    size[axis] = Abs(normal[axis]);
  }
  const Int larger = Max(size[0], size[1]);
  const auto y_larger = size[1] > size[0], z_major = size[2] > larger;
  const Int b = IfThenElse(z_major, normal[0], IfThenElse(y_larger, normal[0], normal[1]));
  const Int c = IfThenElse(z_major, normal[1], normal[2]);
  const Int main = IfThenElse(z_major, normal[2], IfThenElse(y_larger, normal[1], normal[0]));
  const Int first_face = IfThenElse(z_major, number(4), IfThenElse(y_larger, number(2), number(0)));
  const Int face = first_face - ShiftRight<31>(main);

  // Maps [-1, 1] to texel 0..127 with 8 fraction bits.
  const auto major = to_float(Max(Max(larger, size[2]), number(1)));
  const auto to_texel = [&](Int minor) {
    return nearest(to_float(minor) / major * to_float(number(127 * 128))) + number(127 * 128);
  };
  const Int column = to_texel(b), row = to_texel(c), last = number(wire::kReflectanceSize - 2);
  const Int i = Min(ShiftRight<8>(column), last), j = Min(ShiftRight<8>(row), last);
  const Int s = column - ShiftLeft<8>(i), t = row - ShiftLeft<8>(j);  // 0..256

  constexpr int kRowBits = 7;
  static_assert(wire::kReflectanceSize == 1 << kRowBits);
  const Int texels = square(ShiftLeft<kRowBits>(ShiftLeft<kRowBits>(face) + j) + i), byte = number(0xFF);
  const Int across = number(256) - s;
  const Int top = (texels & byte) * across + (ShiftRight<8>(texels) & byte) * s;
  const Int bottom = (ShiftRight<16>(texels) & byte) * across + (ShiftRight<24>(texels) & byte) * s;
  const Int sum = top * (number(256) - t) + bottom * t;  // 7 + 16 fraction bits
  return ShiftRight<8>(sum + number(128));
}

// Whether a gradient is too short to have a direction.
template <class Int>
[[gnu::always_inline]] inline auto is_flat(const std::array<Int, 3>& gradient) {
  const Int square = gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
  return square < like(square, kShortestGradient * kShortestGradient);
}

// colour * base + highlight, 15 fraction bits, at most one. The sums stay below 2^31.
template <class Int>
[[gnu::always_inline]] inline Int lit_colour(Int colour, Int base, Int highlight) {
  const Int one = like(colour, static_cast<std::int32_t>(wire::kColourOne));
  return Min(ShiftRight<kShadeFractionBits>(colour * base + one * highlight + like(colour, kShadeUnit / 2)), one);
}

// A classified sample's colour, shaded by its interpolated gradient.
template <class Int, class Square>
[[gnu::always_inline]] inline std::array<Int, 3> shade(const ShadingEntry<Int>& entry,
                                                       const std::array<Int, 3>& gradient, const Square& square) {
  const auto flat = is_flat(gradient);
  if (all(flat)) return entry.colour;
  constexpr int kCoefficientShift = kShadeFractionBits - 7;  // from units of 1/128
  const Int lit = ShiftRight<7>(entry.reflect * reflectance(gradient, square) + like(entry.reflect, 64));
  const Int total = ShiftLeft<kCoefficientShift>(entry.ambient) + lit;
  const Int base = Min(total, ShiftLeft<kCoefficientShift>(entry.knee));
  std::array<Int, 3> out;
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = IfThenElse(flat, entry.colour[c], lit_colour(entry.colour[c], base, total - base));
  }
  return out;
}

// A sample's colour with the diffuse light `lit`, 15 fraction bits: the reflectance map, which may be black, has the
// highlights of point lights [P §3.4].
template <class Int, class Square>
[[gnu::always_inline]] inline std::array<Int, 3> illuminated(const ShadingEntry<Int>& entry, Int specular,
                                                             const std::array<Int, 3>& lit,
                                                             const std::array<Int, 3>& gradient, const Square& square) {
  Int highlight = like(specular, 0);
  const auto flat = is_flat(gradient);
  if (!all(flat)) {
    const Int shine = ShiftRight<7>(specular * reflectance(gradient, square) + like(specular, 64));
    highlight = IfThenElse(flat, highlight, shine);
  }
  std::array<Int, 3> out;
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = lit_colour(entry.colour[c], lit[c] + ShiftLeft<kShadeFractionBits - 7>(entry.ambient), highlight);
  }
  return out;
}

// A factor of the segmentation LUT's colours, 4095 = one, from resampled colour words. Premultiplied words are divided
// by their alpha, the fourth; alpha 0 gives black.
template <class Int>
[[gnu::always_inline]] inline std::array<Int, 3> factor_of_words(const std::array<Int, 4>& words, bool premultiplied) {
  const Int zero = like(words[0], 0), one = like(words[0], static_cast<std::int32_t>(wire::kColourOne));
  const auto alpha = to_float(Max(words[3], like(words[3], 1)));
  std::array<Int, 3> out;
  for (std::size_t c = 0; c < 3; ++c) {
    const Int whole = ShiftRight<kDensityFractionBits>(words[c] + like(zero, 1 << (kDensityFractionBits - 1)));
    const Int part = Min(nearest(to_float(words[c]) / alpha * to_float(one)), one);
    out[c] = premultiplied ? IfThenElse(words[3] > zero, part, zero) : whole;
  }
  return out;
}

// colour * factor, 4095 = one.
template <class Int>
[[gnu::always_inline]] inline Int tinted(Int colour, Int factor) {
  const Int product = colour * factor + like(colour, 1 << 11);
  return ShiftRight<12>(product + ShiftRight<12>(product));
}
