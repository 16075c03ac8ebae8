#include "memory/block_decoder.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "../functional/simd/instruction_sets.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {
namespace {

// A block's words and its neighbours', all bits random, in memory of their own: a sanitizer sees what is read beyond it.
struct Words {
  Words(std::size_t n, std::mt19937& random) {
    from.voxels = n;
    for (std::size_t i = 0; i < 8; ++i) {
      if (random() % 3 == 0) continue;  // never written
      bytes[i].resize(wire::packed36_bytes(n * n * n));
      for (std::uint8_t& byte : bytes[i]) byte = static_cast<std::uint8_t>(random());
      from.packed[i] = bytes[i];
    }
  }

  std::array<std::vector<std::uint8_t>, 8> bytes;
  BlockWords from;
};

// As the gradient LUT fills it: nothing in the density's place.
std::vector<DecodedVoxel> random_codes(std::mt19937& random) {
  std::vector<DecodedVoxel> codes(wire::kGradientCodes);
  for (DecodedVoxel& code : codes) {
    for (std::size_t axis = 1; axis < 4; ++axis) code.channel[axis] = static_cast<std::int16_t>(random());
  }
  return codes;
}

struct Decoded {
  explicit Decoded(std::size_t n) : voxels((n + 1) * (n + 1) * (n + 1)), densities(voxels.size()), tags(voxels.size()) {
    for (DecodedVoxel& voxel : voxels) voxel = {{1, 2, 3, 4}};
    densities.assign(densities.size(), 5);
    tags.assign(tags.size(), 6);
  }

  DecodedBlock to(bool want_voxels, bool want_densities, bool want_tags) {
    return {want_voxels ? voxels.data() : nullptr, want_densities ? densities.data() : nullptr,
            want_tags ? tags.data() : nullptr};
  }

  friend bool operator==(const Decoded&, const Decoded&) = default;

  std::vector<DecodedVoxel> voxels;
  std::vector<std::int16_t> densities;
  std::vector<std::uint8_t> tags;
};

TEST(BlockDecoder, MakesWhatIsMadeWordByWordInEveryBlockSizeOnEveryInstructionSet) {
  on_every_target([] {
    std::mt19937 random(6);
    const std::vector<DecodedVoxel> codes = random_codes(random);
    for (const std::size_t n : {8, 8, 8, 16, 16, 32, 64}) {
      const Words words(n, random);
      for (unsigned wanted = 0; wanted < 8; ++wanted) {
        Decoded got(n), expected(n);
        const auto to = [wanted](Decoded& decoded) {
          return decoded.to((wanted & 1) != 0, (wanted & 2) != 0, (wanted & 4) != 0);
        };
        const bool tagged = decode(words.from, codes, to(got));
        ASSERT_EQ(tagged, decode_one_by_one(words.from, codes, to(expected)));
        ASSERT_TRUE(got == expected) << n << " wanted " << wanted;
      }
    }
  });
}

TEST(BlockDecoder, MakesEveryDensityGradientAndTagOfAWord) {
  on_every_target([] {
    std::mt19937 random(7);
    const std::vector<DecodedVoxel> codes = random_codes(random);
    constexpr std::size_t kWords = std::size_t{16} * 16 * 16;
    for (std::size_t shift = 0; shift < 2; ++shift) {  // each in the first and in the second place of a pair
      std::vector<std::uint8_t> bytes(wire::packed36_bytes(kWords));
      const auto voxel_at = [shift](std::size_t i) {
        const std::size_t k = i + shift;
        return wire::Voxel{static_cast<std::uint16_t>(k % 4096), static_cast<std::uint16_t>(k / 2 % 2048),
                           static_cast<std::uint8_t>(k / 3 % 4), static_cast<std::uint16_t>(2047 - k % 2048)};
      };
      for (std::size_t i = 0; i < kWords; ++i) wire::store36(bytes, i, wire::to_word(voxel_at(i)));
      BlockWords from;
      from.voxels = 16;
      from.packed[0] = bytes;
      Decoded got(16);
      EXPECT_TRUE(decode(from, codes, got.to(true, true, true)));
      for (std::size_t i = 0; i < kWords; ++i) {
        const wire::Voxel voxel = voxel_at(i);
        const std::size_t at = i % 16 + 17 * (i / 16 % 16 + 17 * (i / 256));
        DecodedVoxel expected = codes[voxel.gradient];
        expected.channel[0] = static_cast<std::int16_t>(voxel.density << kDensityFractionBits);
        ASSERT_EQ(got.voxels[at], expected) << i;
        ASSERT_EQ(got.densities[at], expected.channel[0]) << i;
        ASSERT_EQ(got.tags[at], voxel.tag) << i;
      }
    }
  });
}

// One tag among all the words, wherever it lies; the irradiance beside it is none.
TEST(BlockDecoder, SeesATagInAnyPlace) {
  const std::vector<DecodedVoxel> codes(wire::kGradientCodes);
  on_every_target([&codes] {
    constexpr std::size_t kWords = std::size_t{8} * 8 * 8;
    for (std::size_t place = 0; place <= kWords; ++place) {
      std::vector<std::uint8_t> bytes(wire::packed36_bytes(kWords));
      for (std::size_t i = 0; i < kWords; ++i) {
        const auto tag = static_cast<std::uint8_t>(i == place ? 1 + place % 3 : 0);
        wire::store36(bytes, i, wire::to_word(wire::Voxel{4095, 2047, tag, 2047}));
      }
      BlockWords from;
      from.voxels = 8;
      from.packed[0] = bytes;
      ASSERT_EQ(decode(from, codes, {}), place < kWords) << place;
    }
  });
}

}  // namespace
}  // namespace gicube::emu
