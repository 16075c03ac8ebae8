// The DSP's command for pairs of elements: closed forms, seeds, and what its fields may hold.
#include "commands_rig.h"
#include "gicube/wire/pair.h"
#include "test.h"

namespace gicube::emu {
namespace {

namespace reg = wire::reg;

std::vector<std::uint8_t> pairs_payload(const wire::PairsHeader& header, const std::vector<wire::Element>& elements,
                                        const std::vector<wire::Pair>& pairs) {
  std::vector<std::uint8_t> bytes = wire::encoded(header);
  for (const wire::Element& element : elements) wire::append(bytes, element);
  for (const wire::Pair& pair : pairs) wire::append(bytes, pair);
  return bytes;
}

const wire::Element kFloor{wire::ElementKind::kPatch, {6, 6, 2}, {1, 0, 0}, {0, 1, 0}, {}};
const wire::Element kCeiling{wire::ElementKind::kPatch, {6, 6, 12}, {0, 1, 0}, {1, 0, 0}, {}};

// Two unit squares ten apart: 1 / (100 pi) within a percent; all arrives, or what one opacity of ten voxels leaves.
TEST(PairsCommand, SumsUpItsRaysAtBothLevelsToTheSameBits) {
  std::vector<std::uint8_t> functional;
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    load_fog(board, 6553);  // a tenth a voxel
    const wire::PairsHeader header{.elements = 2, .pairs = 2, .rays = 32, .first = 0, .seed = 3};
    const auto payload = pairs_payload(header, {kFloor, kCeiling}, {{0, 1, 7}, {1, 1, 8}});
    const Completion done = carry_out(board, payload);
    ASSERT_EQ(done.error, wire::ErrorCode::kNone);
    ASSERT_EQ(done.payload.size(), 32u);
    const auto pair = wire::decode<wire::PairResult>(std::span(done.payload));
    EXPECT_NEAR(pair.geometric, 1 / (100 * 3.14159265), 0.03e-3);
    EXPECT_NEAR(pair.transported / pair.geometric, std::pow(0.9, 10), 0.01);
    EXPECT_EQ(wire::decode<wire::PairResult>(std::span(done.payload).subspan(16)).geometric, 0) << "with itself";
    if (level == v1::functional) functional = done.payload;
    EXPECT_EQ(done.payload, functional);
    EXPECT_EQ(board.counter("dsp.pair_rays"), 64u);
  }
}

TEST(PairsCommand, CountsPhysicalLengths) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 0);
  for (const std::uint32_t axis : {reg::kSpacingX, reg::kSpacingY, reg::kSpacingZ})
    board.write_register(axis, 2 * wire::kSpacingOne);
  const auto payload = pairs_payload({.elements = 2, .pairs = 1, .rays = 32}, {kFloor, kCeiling}, {{0, 1, 7}});
  const Completion done = carry_out(board, payload);
  const auto pair = wire::decode<wire::PairResult>(std::span(done.payload));
  EXPECT_NEAR(pair.geometric, 1 / (400 * 3.14159265), 0.01e-3);
  EXPECT_NEAR(pair.transported, pair.geometric, 1e-6);
}

// The board's samples are those of the wire's definition, from `first` on; in clear air nothing is lost.
TEST(PairsCommand, TakesItsSamplesFromTheFirstOnBySeedAndId) {
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    load_fog(board, 0);
    const wire::PairsHeader header{.elements = 2, .pairs = 1, .rays = 16, .first = 5, .seed = 1003};
    const Completion done = carry_out(board, pairs_payload(header, {kFloor, kCeiling}, {{0, 1, 7}}));
    const auto pair = wire::decode<wire::PairResult>(std::span(done.payload));
    wire::PairSum expected(16);
    for (std::uint32_t i = 0; i < 16; ++i) {
      const auto sample = wire::pair_sample(kFloor, kCeiling, {{{0, 0, 1}, {0, 0, -1}}}, {1, 1, 1}, 7, 1003, 5 + i);
      expected.add(i, sample.weight, 1);
    }
    EXPECT_EQ(pair, expected.result());
  }
}

// However many there are, threads take whole batches of them (2,048 rays) and what is left.
TEST(PairsCommand, GivesEachOfManyPairsItsOwnResult) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 0);
  for (const std::uint32_t count : {1u, 63u, 64u, 65u, 129u}) {
    std::vector<wire::Pair> pairs;
    for (std::uint32_t id = 0; id < count; ++id) pairs.push_back({0, 1, id});
    const wire::PairsHeader header{.elements = 2, .pairs = count, .rays = 32};
    const Completion done = carry_out(board, pairs_payload(header, {kFloor, kCeiling}, pairs));
    ASSERT_EQ(done.error, wire::ErrorCode::kNone) << count;
    ASSERT_EQ(done.payload.size(), count * wire::kPairResultBytes);
    for (const std::uint32_t id : {0u, count - 1}) {
      wire::PairSum expected(32);
      for (std::uint32_t i = 0; i < 32; ++i) {
        const auto sample = wire::pair_sample(kFloor, kCeiling, {{{0, 0, 1}, {0, 0, -1}}}, {1, 1, 1}, id, 0, i);
        expected.add(i, sample.weight, 1);
      }
      const auto got = std::span(done.payload).subspan(id * wire::kPairResultBytes);
      EXPECT_EQ(wire::decode<wire::PairResult>(got), expected.result()) << id << " of " << count;
    }
  }
}

// The DSP holds 65,536 rays, 2,048 pairs of 32. All but the last of 2,050 pairs look away from each other and send
// none.
TEST(PairsCommand, OfMoreRaysThanTheDspHoldsGiveEachPairItsOwnResult) {
  BareBoard board(blocks_of_eight(v1::cycle));
  load_fog(board, 0);
  std::vector<wire::Pair> pairs(2049, {0, 2, 1});
  pairs.push_back({0, 1, 7});
  wire::Element away = kCeiling;
  std::swap(away.u, away.v);
  const wire::PairsHeader header{.elements = 3, .pairs = 2050, .rays = 32};
  const Completion done = carry_out(board, pairs_payload(header, {kFloor, kCeiling, away}, pairs));
  ASSERT_EQ(done.payload.size(), 2050 * wire::kPairResultBytes);
  for (std::size_t pair = 0; pair < 2049; ++pair) {
    const auto result = wire::decode<wire::PairResult>(std::span(done.payload).subspan(pair * wire::kPairResultBytes));
    ASSERT_EQ(result.transported, 0) << pair;
  }
  const auto last = wire::decode<wire::PairResult>(std::span(done.payload).subspan(2049 * wire::kPairResultBytes));
  EXPECT_NEAR(last.transported, 1 / (100 * 3.14159265), 0.03e-3);
}

TEST(PairsCommand, RefusesWhatIsBeyondItsFields) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 0);
  const auto refused = [&board](wire::PairsHeader header, const wire::Element& element = kCeiling,
                                wire::Pair pair = {0, 1, 7}) {
    header.elements = 2;
    header.pairs = 1;
    return refusal(board, pairs_payload(header, {kFloor, element}, {pair}));
  };
  EXPECT_EQ(refused({.rays = 1}), "accepted");
  EXPECT_EQ(refused({.rays = 0}), "rays: expected 1..65536, got 0");
  EXPECT_EQ(refused({.rays = 65537}), "rays: expected 1..65536, got 65537");
  EXPECT_EQ(refused({.rays = 4, .first = 0xFFFF'FFFF - 4}), "accepted");
  EXPECT_EQ(refused({.rays = 4, .first = 0xFFFF'FFFF - 3}), "first: expected below 2^32 - rays, got 4294967292");
  EXPECT_EQ(refused({.rays = 4, .opacity = 0}), "opacity: expected 1..2^24 - 1, got 0");
  EXPECT_EQ(refused({.rays = 4, .opacity = 1}), "accepted");
  EXPECT_EQ(refused({.rays = 4, .opacity = 1 << 24}), "opacity: expected 1..2^24 - 1, got 16777216");
  wire::Element outside = kCeiling;
  outside.origin[2] = 16.5F;
  EXPECT_EQ(refused({.rays = 4}, outside), "element 1: origin, u, v, w: expected an element in the volume");
  outside.origin[2] = 16;
  EXPECT_EQ(refused({.rays = 4}, outside), "accepted");
  EXPECT_EQ(refused({.rays = 4}, kCeiling, {0, 2, 7}), "pair 0: a, b: expected elements below 2, got 2");
  EXPECT_EQ(refusal(board, {6, 0, 0, 0}), "payload: expected at least 32 bytes, got 4");
}

}  // namespace
}  // namespace gicube::emu
