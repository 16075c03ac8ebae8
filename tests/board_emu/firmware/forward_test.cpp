// Rays that are taken off a card and given to one: what is refused, and that they go on as if they had stayed.
#include "commands_rig.h"
#include "gicube/wire/forwarded_ray.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"
#include "test.h"

namespace gicube::emu {
namespace {

namespace reg = wire::reg;

constexpr wire::RenderCommand kPicture{.width = 16,
                                       .height = 16,
                                       .projection = wire::Projection::kOrthographic,
                                       .origin = {0.5, 0.5, -4},
                                       .forward = {0, 0, 1},
                                       .du = {1, 0, 0},
                                       .dv = {0, 1, 0}};

struct Taken {
  wire::TakenHeader header;
  std::vector<std::uint8_t> records;
};
Taken take(BareBoard& board, wire::TakeRaysHeader header, const std::vector<std::uint32_t>& blocks) {
  header.blocks = static_cast<std::uint32_t>(blocks.size());
  std::vector<std::uint8_t> payload = wire::encoded(header);
  for (const std::uint32_t block : blocks) {
    payload.resize(payload.size() + 4);
    wire::store(std::span(payload), payload.size() - 4, block);
  }
  const Completion done = carry_out(board, payload);
  EXPECT_EQ(done.error, wire::ErrorCode::kNone) << std::string(done.payload.begin(), done.payload.end());
  return {wire::decode<wire::TakenHeader>(done.payload),
          {done.payload.begin() + wire::kTakenHeaderBytes, done.payload.end()}};
}

std::vector<std::uint8_t> give(wire::GiveRaysHeader header, const std::vector<std::uint8_t>& records) {
  std::vector<std::uint8_t> payload = wire::encoded(header);
  payload.insert(payload.end(), records.begin(), records.end());
  return payload;
}

// 17^3 voxels in 27 blocks, of which the second layer along z begins with block 9.
class ForwardedRays : public testing::Test {
 protected:
  ForwardedRays() {
    for (BareBoard* const board : {&first_, &second_}) {
      load_fog(*board, 300);
      board->write_register(reg::kBricks, 1);
    }
    expected_ = picture(second_);
    board_absent(first_);
  }
  static void board_absent(BareBoard& board) {
    std::vector<std::uint8_t> flags(4);
    for (std::size_t block = 9; block < 18; ++block) flags[block / 8] |= static_cast<std::uint8_t>(1u << block % 8);
    board.write_memory(wire::kAbsentFlags.base, flags);
  }
  static std::vector<std::uint8_t> picture(BareBoard& board) {
    EXPECT_EQ(refusal(board, wire::encoded(kPicture)), "accepted");
    return pixels(board);
  }
  static std::vector<std::uint8_t> pixels(BareBoard& board) {
    return board.read_memory(wire::kFramebuffer.base, wire::packed36_bytes(16 * 16)).payload;
  }

  BareBoard first_{blocks_of_eight()}, second_{blocks_of_eight()};
  std::vector<std::uint8_t> expected_;
};

constexpr std::uint32_t kRays = 16 * 16;
const std::vector<std::uint32_t> kLayer{9, 10, 11, 12, 13, 14, 15, 16, 17};

TEST_F(ForwardedRays, GoOnOnAnotherCardAndComeHome) {
  EXPECT_EQ(refusal(first_, wire::encoded(kPicture)), "accepted");
  const Taken some = take(first_, {.max_rays = 100}, kLayer);
  EXPECT_EQ(some.header.rays, 100u);
  EXPECT_EQ(some.header.left, kRays - 100);
  const Taken rest = take(first_, {.max_rays = 65536}, kLayer);
  EXPECT_EQ(rest.header.rays, kRays - 100);
  EXPECT_EQ(rest.header.left, 0u);
  EXPECT_EQ(take(first_, {.max_rays = 1}, kLayer).header.rays, 0u);

  // Half of them to the second card, which calls the first one 7; half stay the first one's own.
  std::vector<std::uint8_t> away = some.records;
  for (std::size_t at = 0; at < away.size(); at += wire::kForwardedRayBytes) {
    const auto bytes = std::span(away).subspan(at, wire::kForwardedRayBytes);
    auto ray = wire::decode<wire::ForwardedRay>(bytes);
    EXPECT_EQ(ray.home, 0);
    ray.home = 7;
    wire::encode(ray, bytes);
  }
  EXPECT_EQ(refusal(second_, give({.rays = 100}, away)), "accepted");
  EXPECT_EQ(refusal(second_, wire::encoded(wire::ContinueCommand{})), "accepted");
  EXPECT_EQ(pixels(second_), expected_) << "rays of the first card are in the second one's picture";
  EXPECT_EQ(refusal(first_, give({.rays = kRays - 100}, rest.records)), "accepted");
  first_.write_memory(wire::kAbsentFlags.base, std::vector<std::uint8_t>(4));
  EXPECT_EQ(refusal(first_, wire::encoded(wire::ContinueCommand{})), "accepted");
  EXPECT_NE(pixels(first_), expected_) << "a hundred rays are still missing";

  Taken ended = take(second_, {.max_rays = 65536, .ended = 1}, {});
  EXPECT_EQ(ended.header.rays, 100u);
  for (std::size_t at = 0; at < ended.records.size(); at += wire::kEndedRayBytes) {
    const auto bytes = std::span(ended.records).subspan(at, wire::kEndedRayBytes);
    auto ray = wire::decode<wire::EndedRay>(bytes);
    EXPECT_EQ(ray.home, 7);
    ray.home = 0;
    wire::encode(ray, bytes);
  }
  EXPECT_EQ(refusal(first_, give({.ended = 100}, ended.records)), "accepted");
  EXPECT_EQ(pixels(first_), expected_);
}

TEST_F(ForwardedRays, AreTakenByCommandsThatMakeSense) {
  const auto taken = [&](const std::vector<std::uint8_t>& payload) { return refusal(first_, payload); };
  EXPECT_EQ(taken({8, 0, 0, 0}), "payload: expected at least 16 bytes, got 4");
  EXPECT_EQ(taken(wire::encoded(wire::TakeRaysHeader{.max_rays = 1, .blocks = 1})),
            "payload: expected 16 bytes and 4 for each of its 1 blocks, got 16");
  EXPECT_EQ(taken(wire::encoded(wire::TakeRaysHeader{})), "max_rays: expected 1..65536, got 0");
  EXPECT_EQ(taken(wire::encoded(wire::TakeRaysHeader{.max_rays = 1, .ended = 2})), "ended: expected 0 or 1, got 2");
  std::vector<std::uint8_t> twice = wire::encoded(wire::TakeRaysHeader{.max_rays = 1, .blocks = 2});
  twice.resize(24);
  EXPECT_EQ(taken(twice), "blocks: expected ascending numbers");
}

TEST_F(ForwardedRays, AreGivenOnlyIfTheyCanGoOn) {
  EXPECT_EQ(refusal(first_, wire::encoded(kPicture)), "accepted");
  const Taken one = take(first_, {.max_rays = 1}, kLayer);
  const auto good = wire::decode<wire::ForwardedRay>(one.records);
  const auto given = [&](const std::function<void(wire::ForwardedRay&)>& change) {
    wire::ForwardedRay ray = good;
    change(ray);
    return refusal(first_, give({.rays = 1}, wire::encoded(ray)));
  };
  EXPECT_EQ(given([](auto& ray) { ray.position[1] = -1; }), "ray 0: position: expected a point of the volume");
  EXPECT_EQ(given([](auto& ray) { ray.block = 27; }), "ray 0: block: expected one of the volume, got 27");
  EXPECT_EQ(given([](auto& ray) { ray.step = {}; }), "ray 0: step: expected a vector other than 0, got 0");
  EXPECT_EQ(given([](auto& ray) { ray.opacity = 1 << 24; }), "ray 0: opacity: expected at most 2^24 - 1, got 16777216");
  EXPECT_EQ(given([](auto& ray) { ray.generation = 16; }), "ray 0: generation: expected 0..15, got 16");
  EXPECT_EQ(given([](auto& ray) { ray.under_way = 2; }), "ray 0: under_way: expected 0 or 1, got 2");
  EXPECT_EQ(given([](auto& ray) { ray.trapped = 2; }), "ray 0: trapped: expected 0 or 1, got 2");
  EXPECT_EQ(given([](auto& ray) { ray.colour[2] = 4096; }), "ray 0: colour: expected at most 4095, got 4096");
  EXPECT_EQ(given([](auto& ray) { ray.wide[0] = 0x7FC0'0000; }), "ray 0: wide: expected an opacity of 0..1");
  EXPECT_EQ(given([](auto& ray) { ray.flags = wire::kLightingRay; }),
            "ray 0: flags: expected those of a rendering ray, got 1");
  EXPECT_EQ(refusal(first_, give({.rays = 2}, one.records)),
            "payload: expected 32 bytes, 128 for each of its rays and 64 for each that has ended, got 160");
  EXPECT_EQ(refusal(first_, give({.rays = 1, .of = wire::RaysOf::kTrace}, one.records)),
            "of, trace: expected those of the rays that wait, got others");
  EXPECT_EQ(take(first_, {.max_rays = 65536}, kLayer).header.rays, kRays - 1) << "nothing was taken in";
  EXPECT_EQ(refusal(first_, give({.rays = 1, .of = wire::RaysOf::kTrace}, one.records)),
            "ray 0: number: expected one of the host rays in the DSP's memory, got " + std::to_string(good.number));
  EXPECT_EQ(refusal(first_, give({.rays = 1}, one.records)), "of: expected 1 or 2, since no picture was begun, got 0");
  first_.write_register(reg::kBricks, 0);
  EXPECT_EQ(refusal(first_, give({.rays = 1}, one.records)),
            "BRICKS: expected 1, or a volume with more blocks than the card stores");
}

}  // namespace
}  // namespace gicube::emu
