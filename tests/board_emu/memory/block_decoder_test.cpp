#include "memory/block_decoder.h"

#include "../functional/simd/instruction_sets.h"
#include "gicube/wire/voxel.h"
#include "test.h"

namespace gicube::emu {
namespace {

// A block's words, all bits random, in memory of their own: a sanitizer sees what is read beyond it.
std::vector<std::uint8_t> random_words(std::size_t n, std::mt19937& random) {
  std::vector<std::uint8_t> bytes(wire::packed36_bytes(n * n * n));
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

struct Decoded {
  explicit Decoded(std::size_t n) : densities((n + 1) * (n + 1) * (n + 1), 5), codes(densities.size(), 6) {}

  DecodedBlock to(bool want_codes) { return {densities.data(), want_codes ? codes.data() : nullptr}; }

  friend bool operator==(const Decoded&, const Decoded&) = default;

  std::vector<std::int16_t> densities;
  std::vector<std::uint16_t> codes;
};

TEST(BlockDecoder, MakesWhatIsMadeWordByWordInEveryBlockSizeOnEveryInstructionSet) {
  on_every_target([] {
    std::mt19937 random(6);
    for (const std::size_t n : {8, 8, 8, 16, 16, 32, 64}) {
      const std::vector<std::uint8_t> words = random_words(n, random);
      for (const bool codes : {false, true}) {
        Decoded got(n), expected(n);
        const std::uint16_t any = decode(words, n, got.to(codes));
        ASSERT_EQ(any, decode_one_by_one(words, n, expected.to(codes)));
        ASSERT_TRUE(got == expected) << n << ' ' << codes;
      }
    }
  });
}

TEST(BlockDecoder, MakesEveryDensityGradientAndTagOfAWord) {
  on_every_target([] {
    constexpr std::size_t kWords = std::size_t{16} * 16 * 16;
    for (std::size_t shift = 0; shift < 2; ++shift) {  // each in the first and in the second place of a pair
      std::vector<std::uint8_t> bytes(wire::packed36_bytes(kWords));
      const auto voxel_at = [shift](std::size_t i) {
        const std::size_t k = i + shift;
        return wire::Voxel{static_cast<std::uint16_t>(k % 4096), static_cast<std::uint16_t>(k / 2 % 2048),
                           static_cast<std::uint8_t>(k / 3 % 4), static_cast<std::uint16_t>(2047 - k % 2048)};
      };
      for (std::size_t i = 0; i < kWords; ++i) wire::store36(bytes, i, wire::to_word(voxel_at(i)));
      Decoded got(16);
      EXPECT_EQ(decode(bytes, 16, got.to(true)), 0x1FFF);
      for (std::size_t i = 0; i < kWords; ++i) {
        const wire::Voxel voxel = voxel_at(i);
        const std::size_t at = i % 16 + 17 * (i / 16 % 16 + 17 * (i / 256));
        ASSERT_EQ(got.densities[at], voxel.density << kDensityFractionBits) << i;
        ASSERT_EQ(gradient_code(got.codes[at]), voxel.gradient) << i;
        ASSERT_EQ(tag_of(got.codes[at]), voxel.tag) << i;
      }
    }
  });
}

// One code and tag among all the words, wherever it lies; the density and irradiance beside it are none.
TEST(BlockDecoder, SeesACodeInAnyPlace) {
  on_every_target([] {
    constexpr std::size_t kWords = std::size_t{8} * 8 * 8;
    Decoded got(8);
    for (std::size_t place = 0; place <= kWords; ++place) {
      std::vector<std::uint8_t> bytes(wire::packed36_bytes(kWords));
      for (std::size_t i = 0; i < kWords; ++i) {
        const auto tag = static_cast<std::uint8_t>(i == place ? 1 + place % 3 : 0);
        wire::store36(bytes, i, wire::to_word(wire::Voxel{4095, 0, tag, 2047}));
      }
      ASSERT_EQ(decode(bytes, 8, got.to(place % 2 == 0)), place < kWords ? (1 + place % 3) << kCodeBits : 0) << place;
    }
  });
}

TEST(BlockDecoder, PacksTheWordsThatItHasDecoded) {
  std::mt19937 random(8);
  for (const std::size_t n : {8, 16, 32}) {
    std::vector<std::uint8_t> words(wire::packed36_bytes(n * n * n)), back(words.size());
    for (std::size_t i = 0; i < n * n * n; ++i) wire::store36(words, i, random() & 0x1FF'FFFFu);
    Decoded decoded(n);
    decode(words, n, decoded.to(true));
    pack(decoded.densities.data(), decoded.codes.data(), n, back);
    ASSERT_EQ(back, words) << n;
  }
}

TEST(BlockDecoder, SeesIrradianceBitsInAnyPlaceAndNoOthers) {
  std::vector<std::uint8_t> words(wire::packed36_bytes(512));
  for (std::size_t i = 0; i < 512; ++i) wire::store36(words, i, 0x1FF'FFFFu);
  EXPECT_FALSE(has_irradiance_bits(words));
  for (const std::size_t word : {0, 1, 2, 255, 510, 511}) {
    for (int bit = 25; bit < 36; ++bit) {
      std::vector<std::uint8_t> one = words;
      wire::store36(one, word, 0x1FF'FFFFu | std::uint64_t{1} << bit);
      EXPECT_TRUE(has_irradiance_bits(one)) << word << ' ' << bit;
    }
  }
}

}  // namespace
}  // namespace gicube::emu
