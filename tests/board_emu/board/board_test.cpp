// The board behind its connector: closed forms of value and time, what must not change a bit, and misuse.
#include "board/board.h"

#include "bare_board.h"
#include "firmware/framebuffer.h"
#include "firmware/viewing_rays.h"
#include "test.h"

namespace gicube::emu {
namespace {

using wire::ErrorCode;
namespace reg = wire::reg;

v1::BoardConfig small_blocks(unsigned n = 8, unsigned threads = 1) {
  v1::BoardConfig config;
  config.mutable_asic()->set_block_voxels(n);
  config.set_threads(threads);
  return config;
}

wire::SegmentationEntry grey(std::uint16_t opacity) { return {{2048, 2048, 2048}, opacity}; }

// A uniform slab of opacity `alpha` a voxel.
void load_slab(BareBoard& board, std::uint16_t alpha) {
  board.load_volume({33, 17, 17}, [](int, int, int) { return wire::Voxel{1000, 0, 0, 0}; });
  board.write_segmentation([alpha](unsigned, unsigned) { return grey(alpha); });
}

double opacity(const wire::Ray& ray) { return ray.opacity / double{wire::kOpacityOne}; }

// Blobs in air with random materials; many blocks are empty.
wire::Voxel blobs(int x, int y, int z) {
  const double r = std::hypot(x - 12, y - 20, z - 9), s = std::hypot(x - 40, y - 30, z - 35);
  const double density = std::max({0.0, 1500 - 200 * r, 3000 - 350 * s});
  return {static_cast<std::uint16_t>(density),
          static_cast<std::uint16_t>(density > 0 ? (x * 31 + y * 17 + z) % 2000 : 0),
          static_cast<std::uint8_t>(x > 30 ? 1 : 0), 0};
}

// Loads the blobs with tables of some variety and truthful empty flags.
void load_blobs(BareBoard& board, int n) {
  constexpr std::array<int, 3> kSize{50, 45, 41};
  board.load_volume(kSize, blobs);
  board.write_segmentation([](unsigned tag, unsigned density) {
    return wire::SegmentationEntry{{static_cast<std::uint16_t>(density), 3000, static_cast<std::uint16_t>(1000 * tag)},
                                   static_cast<std::uint16_t>(density > 200 ? density * 4 : 0),
                                   40,
                                   128,
                                   120};
  });
  std::vector<std::uint8_t> gradients(wire::kGradientLut.bytes), map(wire::kReflectanceBytes);
  for (std::size_t i = 1; i < wire::kGradientCodes; ++i) {
    const wire::GradientEntry g{static_cast<std::int16_t>(static_cast<int>(i * 37 % 800) - 400),
                                static_cast<std::int16_t>(static_cast<int>(i * 53 % 800) - 400), 100};
    wire::store(std::span(gradients), 4 * i, wire::to_word(g));
  }
  for (std::size_t i = 0; i < map.size(); ++i) map[i] = static_cast<std::uint8_t>(i / 97);
  board.write_memory(wire::kGradientLut.base, gradients);
  board.write_memory(wire::kReflectanceMap.base, map);

  std::vector<std::uint8_t> flags(wire::kEmptyFlags.bytes);
  std::size_t block = 0;
  for (int z = 0; z < kSize[2]; z += n) {
    for (int y = 0; y < kSize[1]; y += n) {
      for (int x = 0; x < kSize[0]; x += n, ++block) {
        bool empty = true;
        for (int i = 0; i < (n + 1) * (n + 1) * (n + 1); ++i) {
          empty = empty && blobs(x + i % (n + 1), y + i / (n + 1) % (n + 1), z + i / (n + 1) / (n + 1)).density <= 200;
        }
        if (empty) flags[block / 8] = static_cast<std::uint8_t>(flags[block / 8] | 1u << block % 8);
      }
    }
  }
  board.write_memory(wire::kEmptyFlags.base, flags);
  board.write_register(reg::kStep, wire::kStepOne / 2);
}

TEST(Board, AttenuatesAlongASlabByTheClosedForm) {
  BareBoard board(small_blocks());
  load_slab(board, 3000);
  const auto rays = board.trace({host_ray(7, {0, 8, 8}, {1, 0, 0})});
  // 33 samples at x = 0..32, each of one voxel length.
  EXPECT_NEAR(opacity(rays[0]), 1 - std::pow(1 - 3000 / 65535.0, 33), 1e-6);
  EXPECT_EQ(rays[0].host_id(), 7u);
  EXPECT_EQ(rays[0].position, (std::array<std::uint32_t, 3>{32u << 14, 8u << 14, 8u << 14}));
}

TEST(Board, AttenuatesTheSameInSmallerSteps) {
  BareBoard board(small_blocks());
  load_slab(board, 3000);
  board.write_register(reg::kStep, wire::kStepOne / 4);
  const auto rays = board.trace({host_ray(0, {0, 8, 8}, {1, 0, 0})});
  EXPECT_NEAR(opacity(rays[0]), 1 - std::pow(1 - 3000 / 65535.0, 129 / 4.0), 3e-6);
}

TEST(Board, CountsOpacityByPhysicalLengthUnderAnisotropicSpacing) {
  BareBoard board(small_blocks());
  load_slab(board, 3000);
  board.write_register(reg::kSpacingX, 2 * wire::kSpacingOne);
  const auto rays = board.trace({host_ray(0, {0, 8, 8}, {1, 0, 0}), host_ray(1, {16, 0, 8}, {0, 1, 0})});
  EXPECT_NEAR(opacity(rays[0]), 1 - std::pow(1 - 3000 / 65535.0, 2 * 33), 1e-6);
  EXPECT_NEAR(opacity(rays[1]), 1 - std::pow(1 - 3000 / 65535.0, 17), 1e-6);
}

TEST(Board, KeepsTheMeanOpacityOfASlabUnderJitter) {
  BareBoard board(small_blocks());
  load_slab(board, 2000);
  board.write_register(reg::kPipeline, wire::kPipelineJitter);
  std::vector<wire::Ray> rays;
  for (std::uint32_t i = 0; i < 500; ++i) rays.push_back(host_ray(i, {0, 1 + i * 0.029, 8}, {1, 0, 0}));
  double mean = 0;
  for (const wire::Ray& ray : board.trace(rays)) mean += std::log(1 - opacity(ray)) / 500;
  // The samples of a ray stand for all of its 32 voxels and for up to one step beyond.
  EXPECT_NEAR(mean / std::log(1 - 2000 / 65535.0), 32.4, 0.3);
}

TEST(Board, EndsRaysAtTheOpacityThreshold) {
  BareBoard board(small_blocks());
  load_slab(board, 32768);
  board.write_register(reg::kOpacityThreshold, wire::kOpacityOne / 10 * 9);
  const auto rays = board.trace({host_ray(0, {0, 8, 8}, {1, 0, 0})});
  EXPECT_NEAR(opacity(rays[0]), 1 - std::pow(0.5, 4), 1e-4);  // 0.9375 after four samples
  EXPECT_EQ(board.counter("pipeline.samples"), 4u);
  EXPECT_EQ(board.counter("pipeline.terminated"), 1u);
}

TEST(Board, RendersBlobsThatAreNeitherBlackNorFull) {
  BareBoard board(small_blocks());
  load_blobs(board, 8);
  const auto image = board.render(corner_view({50, 45, 41}, 64));
  const auto lit =
      std::count_if(image.begin(), image.end(), [](const wire::Pixel& pixel) { return pixel.alpha > 1000; });
  EXPECT_GT(lit, 64 * 64 / 50);
  EXPECT_LT(lit, 64 * 64 / 2);
}

TEST(Board, RendersTheSameBitsWithAndWithoutLeaping) {
  BareBoard board(small_blocks());
  load_blobs(board, 8);
  board.write_register(reg::kPipeline, wire::kPipelineShade | wire::kPipelineLeap);
  const auto leaping = board.render(corner_view({50, 45, 41}, 64));
  const std::uint64_t samples = board.counter("pipeline.samples");
  EXPECT_GT(board.counter("pipeline.leaps"), 0u);
  board.write_register(reg::kPipeline, wire::kPipelineShade);
  EXPECT_EQ(board.render(corner_view({50, 45, 41}, 64)), leaping);
  EXPECT_GT(board.counter("pipeline.samples") - samples, samples);
}

TEST(Board, RendersTheSameBitsForEveryBlockSizeThreadCountBusAndProcessorCount) {
  BareBoard first(small_blocks(8, 1));
  load_blobs(first, 8);
  const auto expected = first.render(corner_view({50, 45, 41}, 64));
  for (const unsigned n : {8u, 16u, 32u, 64u}) {
    v1::BoardConfig config = small_blocks(n, n == 8 ? 3 : 2);
    config.mutable_bus()->set_model(n == 16 ? v1::agp4x : v1::pci33);
    config.mutable_asic()->set_processors(n / 8);
    BareBoard board(config);
    load_blobs(board, static_cast<int>(n));
    EXPECT_EQ(board.render(corner_view({50, 45, 41}, 64)), expected) << n;
  }
}

TEST(Board, TellsWatchersWhatTheCycleLevelHasCountedWhileItRunsAndRendersTheSameBits) {
  v1::BoardConfig config = small_blocks();
  config.set_fidelity(v1::cycle);
  BareBoard alone(config);
  load_blobs(alone, 8);
  const auto expected = alone.render(corner_view({50, 45, 41}, 128));
  BareBoard watched(config);
  load_blobs(watched, 8);
  std::atomic<bool> ends = false;
  std::vector<std::uint64_t> seen;
  std::thread watcher([&] {
    while (!ends) {
      for (const wire::Counter& counter : watched.counters()) {
        if (counter.name == "asic.cycles" && (seen.empty() || seen.back() != counter.value))
          seen.push_back(counter.value);
      }
    }
  });
  const auto image = watched.render(corner_view({50, 45, 41}, 128));
  ends = true;
  watcher.join();
  EXPECT_EQ(image, expected);
  EXPECT_EQ(watched.counter("asic.cycles"), alone.counter("asic.cycles"));
  EXPECT_TRUE(std::ranges::is_sorted(seen));
  const std::uint64_t all = alone.counter("asic.cycles");
  EXPECT_TRUE(std::ranges::any_of(seen, [all](std::uint64_t cycles) { return cycles > 0 && cycles < all; }));
}

TEST(Board, RendersTheSameBitsUnderJitterForEveryBlockSizeWhileNothingLeaps) {
  std::vector<wire::Pixel> expected;
  for (const unsigned n : {8u, 32u}) {
    BareBoard board(small_blocks(n));
    load_blobs(board, static_cast<int>(n));
    board.write_register(reg::kPipeline, wire::kPipelineJitter | wire::kPipelineShade);
    const auto image = board.render(corner_view({50, 45, 41}, 64));
    if (n == 8) expected = image;
    EXPECT_EQ(image, expected);
  }
}

TEST(Board, KeepsOnlyTheHalfOfASlabThatACutPlaneKeeps) {
  BareBoard board(small_blocks());
  load_slab(board, 3000);
  board.write_register(reg::kCutPlane0, 16384);          // x >= 16.5
  board.write_register(reg::kCutPlane0 + 12, 33u << 9);  // 16.5 with 10 fraction bits
  board.write_register(reg::kCutPlanes, 1);
  const auto rays = board.trace(
      {host_ray(0, {0, 8, 8}, {1, 0, 0}), host_ray(1, {32, 8, 8}, {-1, 0, 0}), host_ray(2, {3, 0, 8}, {0, 1, 0})});
  EXPECT_NEAR(opacity(rays[0]), 1 - std::pow(1 - 3000 / 65535.0, 16), 1e-6);  // 16.5 .. 31.5
  EXPECT_NEAR(opacity(rays[1]), 1 - std::pow(1 - 3000 / 65535.0, 16), 1e-6);  // 32 .. 17
  EXPECT_EQ(rays[2].opacity, 0u);
}

TEST(Board, TerminatesEveryRayWithinItsBoundOnBoundariesAndWithTinyComponents) {
  BareBoard board(small_blocks());
  load_slab(board, 1);
  board.write_register(reg::kStep, wire::kStepMin);
  std::vector<wire::Ray> rays;
  for (const double x : {0.0, 8.0, 32.0}) {
    for (const double y : {0.0, 8.0, 16.0}) {
      for (const double tiny : {0.0, 1e-4, -1e-4}) {
        rays.push_back(host_ray(0, {x, y, 8}, {tiny, tiny, 1}));
        rays.push_back(host_ray(0, {x, y, 16}, {1, tiny, -1}));
        rays.push_back(host_ray(0, {x, y, 0}, {-1, tiny, tiny}));
      }
    }
  }
  board.trace(rays);
  // N sqrt(3) / dr + blocks (docs/studies/stability.md), for the longest edge.
  EXPECT_LE(board.counter("pipeline.samples"), rays.size() * static_cast<std::uint64_t>(33 * 1.74 * 64 + 50));
}

TEST(BoardTime, RendersInDspTimeAndSendsTheImageInBusTime) {
  BareBoard board(small_blocks());
  load_slab(board, 3000);
  wire::RenderCommand view = corner_view({33, 17, 17}, 32);
  board.read_register(reg::kId);
  const std::uint64_t begin = board.now_ps, viewing = board.counter("dsp.viewing_rays"),
                      rays = board.counter("pipeline.rays");
  const auto payload = wire::encoded(view);
  board.wait(board.command(payload));
  const std::uint64_t made = board.counter("dsp.viewing_rays") - viewing,
                      returned = board.counter("pipeline.rays") - rays;
  EXPECT_EQ(made, 32u * 32u);
  EXPECT_GT(returned, 50u);
  // Ten cycles a ray and four a pixel; 48 a row; each loop is begun once.
  const std::uint64_t dsp = 10 * made + 4 * returned + 48 * 32 + kMakeViewingRay.setup() + kStorePixel.setup();
  EXPECT_EQ(board.now_ps - begin, (28 + 3) * 30'000 + dsp * 5'000 + (1 + 3) * 30'000);
  const std::uint64_t before_read = board.now_ps;
  board.read_memory(wire::kFramebuffer.base, 32 * 32 * 9 / 2);
  EXPECT_EQ(board.now_ps - before_read, (4 + 3) * 30'000 + (4 * 259 + 128 + 3) * 30'000);
}

TEST(BoardTime, PushesCompletionsInSimulatedOrderBeforeTheReply) {
  BareBoard board(small_blocks());
  load_slab(board, 3000);
  const std::vector<wire::Ray> rays(10, host_ray(5, {0, 8, 8}, {1, 0, 0}));
  const auto first = board.command(BareBoard::trace_payload(rays));
  const auto second = board.command(BareBoard::trace_payload(rays));
  const auto third = board.command(BareBoard::trace_payload(rays));
  const TransactionResult outcome = board.wait(second);
  ASSERT_EQ(outcome.completions.size(), 2u);
  EXPECT_EQ(outcome.completions[0].ticket, first);
  EXPECT_EQ(outcome.completions[1].ticket, second);
  EXPECT_EQ(outcome.completions[1].time_ps, outcome.reply->time_ps);
  EXPECT_LT(outcome.completions[0].time_ps, outcome.completions[1].time_ps);
  EXPECT_EQ(board.wait(third).completions.size(), 1u);
  EXPECT_EQ(board.wait(third).reply->error, ErrorCode::kBadValue);  // taken already
}

TEST(BoardTime, PollsOnlyWhatHasArrivedByNow) {
  BareBoard board(small_blocks());
  load_slab(board, 3000);
  board.read_register(reg::kId);
  board.command(BareBoard::trace_payload({host_ray(5, {0, 8, 8}, {1, 0, 0})}));
  EXPECT_TRUE(board.send(wire::FrameType::kPoll, {}).completions.empty());
  board.now_ps += 1'000'000'000;
  EXPECT_EQ(board.send(wire::FrameType::kPoll, {}).completions.size(), 1u);
}

TEST(BoardMisuse, RefusesCommandsByFieldAndKeepsServing) {
  BareBoard board(small_blocks());
  const auto refusal = [&board](const std::vector<std::uint8_t>& payload) {
    const TransactionResult outcome = board.wait(board.command(payload));
    const Completion& completion = outcome.completions.at(0);
    EXPECT_EQ(completion.error, ErrorCode::kBadValue);
    return std::string(completion.payload.begin(), completion.payload.end());
  };
  const auto render_refusal = [&refusal](const wire::RenderCommand& view) {
    const auto payload = wire::encoded(view);
    return refusal(payload);
  };
  wire::RenderCommand view = corner_view({33, 17, 17}, 32);
  EXPECT_NE(render_refusal(view).find("no volume"), std::string::npos);
  load_slab(board, 3000);
  EXPECT_NE(refusal({}).find("opcode"), std::string::npos);
  EXPECT_NE(refusal({1, 0, 0, 0, 1}).find("112 bytes, got 5"), std::string::npos);
  EXPECT_NE(refusal({2, 0, 0, 0, 255, 255, 255, 255}).find("payload"), std::string::npos);
  view.width = 0;
  EXPECT_EQ(render_refusal(view), "width: expected 1..4095, got 0");
  view.width = view.height = 4095;
  EXPECT_NE(render_refusal(view).find("dsp.framebuffer_mb"), std::string::npos);
  view = corner_view({33, 17, 17}, 32);
  view.samples_per_axis = 3;
  EXPECT_EQ(render_refusal(view), "samples_per_axis: expected 1, 2 or 4, got 3");
  wire::Ray carrier = host_ray(0, {0, 8, 8}, {1, 0, 0});
  carrier.flags |= wire::kLightingRay | wire::kIrradianceCarrier;
  EXPECT_EQ(refusal(BareBoard::trace_payload({carrier})), "ray 0: flags: expected 32, got 37");
  view.samples_per_axis = 1;
  view.du[1] = std::nan("");
  EXPECT_NE(render_refusal(view).find("finite"), std::string::npos);
  wire::Ray outside = host_ray(1, {33, 8, 8}, {1, 0, 0}), still = host_ray(2, {3, 8, 8}, {1, 0, 0});
  still.direction = {1, 0, 0};
  EXPECT_NE(refusal(BareBoard::trace_payload({host_ray(0, {1, 1, 1}, {0, 0, 1}), outside})).find("ray 1: position"),
            std::string::npos);
  EXPECT_NE(refusal(BareBoard::trace_payload({still})).find("ray 0: direction"), std::string::npos);
  EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusBadCommand);
  EXPECT_NO_THROW(board.render(corner_view({33, 17, 17}, 8)));
}

TEST(BoardTime, CountsWhatEachKindOfTransferTook) {
  BareBoard board(small_blocks());
  load_slab(board, 3000);
  board.render(corner_view({33, 17, 17}, 32));
  EXPECT_EQ(board.counter("bus.image.bytes"), 32u * 32 * 9 / 2);
  EXPECT_EQ(board.counter("bus.image.time_ps"), (4 * 259 + 128 + 3) * 30'000u);
  EXPECT_EQ(board.counter("bus.volume.transfers"), 5u * 3 * 3);
  EXPECT_EQ(board.counter("bus.command.bytes"), wire::kRenderCommandBytes);
  EXPECT_EQ(board.counter("bus.rays.bytes"), 0u);
  board.trace({host_ray(0, {0, 8, 8}, {1, 0, 0})});
  EXPECT_EQ(board.counter("bus.rays.bytes"), 16u + 32 + 32);
}

TEST(BoardMisuse, RefusesStampsFromWhichTimeCouldRunOver) {
  BareBoard board(small_blocks());
  load_slab(board, 3000);
  for (const std::uint64_t stamp : {~std::uint64_t{0}, (std::uint64_t{1} << 62) + 1}) {
    const std::uint64_t now = std::exchange(board.now_ps, stamp);
    const TransactionResult outcome = board.send(wire::FrameType::kPoll, {});
    EXPECT_EQ(outcome.reply->error, ErrorCode::kBadValue);
    board.command(BareBoard::trace_payload({host_ray(0, {0, 8, 8}, {1, 0, 0})}));
    board.now_ps = now;
  }
  EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusBadCommand);
  EXPECT_EQ(board.trace({host_ray(0, {0, 8, 8}, {1, 0, 0})}).size(), 1u);
}

TEST(BoardMisuse, AnswersBadAddressesAsHardwareDoes) {
  BareBoard board(small_blocks());
  EXPECT_EQ(board.read_register(0xFFC), wire::kUnmappedRead);
  EXPECT_EQ(board.read_memory(wire::kVolume.base, 1).error, ErrorCode::kBadAddress);  // no volume yet
  EXPECT_EQ(board.read_memory(0, ~std::uint64_t{0}).error, ErrorCode::kBadAddress);
  board.write_memory(0x0F00'0000, std::vector<std::uint8_t>(4));
  EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusBadAddress);
  EXPECT_EQ(board.read_register(reg::kErrorAddress), 0x0F00'0000u);
  board.write_register(reg::kStatusClear, ~0u);
  board.write_register(reg::kStep, 1);
  EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusBadValue);
  EXPECT_EQ(board.read_register(reg::kStep), wire::kStepOne);
  EXPECT_EQ(board.send(wire::FrameType::kRegisterRead, {1, 2, 3}).reply->error, ErrorCode::kBadValue);
}

TEST(BoardMisuse, ReadsAVolumeBackAndForgetsItOnReset) {
  BareBoard board(small_blocks());
  load_blobs(board, 8);
  // Block (1, 2, 1) of 7 x 6 x 6: 8..15, 16..23, 8..15; the first blob's centre is (12, 20, 9).
  const std::uint64_t block = 1 + 7 * (2 + 6 * 1), voxel = 4 + 8 * (4 + 8 * 1);
  const auto before = board.read_memory(wire::kVolume.base + block * 2304, 2304).payload;
  EXPECT_EQ(wire::to_voxel(wire::load36(before, voxel)), blobs(12, 20, 9));
  board.write_register(reg::kControl, wire::kControlReset);
  EXPECT_EQ(board.read_memory(wire::kVolume.base, 2304).error, ErrorCode::kBadAddress);
  EXPECT_EQ(board.read_register(reg::kVolumeX), 0u);
}

}  // namespace
}  // namespace gicube::emu
