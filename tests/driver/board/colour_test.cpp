// Volumes whose voxels have colours of their own.
#include "test.h"
#include "test_board.h"

namespace gicube::reference {
namespace {

constexpr int kSize = 36;  // 125 blocks of 8^3
// That stores 64 blocks of 8^3 voxels.
const std::string kSmallCard = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32";

constexpr std::size_t kVoxels = std::size_t{kSize} * kSize * kSize;

std::string uri(const char* format, const char* more = "") {
  return std::string(kSmallBlocks) + "&set=asic.voxel_format=" + format + more;
}

// A soft ball of `peak` at its middle.
std::vector<std::byte> ball(double peak) {
  std::vector<std::byte> samples;
  for (std::size_t i = 0; i < kVoxels; ++i) {
    const double x = static_cast<double>(i % kSize) - 17.5, y = static_cast<double>(i / kSize % kSize) - 17.5,
                 z = static_cast<double>(i / kSize / kSize) - 17.5;
    samples.push_back(
        static_cast<std::byte>(std::clamp(peak * (1.3 - std::sqrt(x * x + y * y + z * z) / 14), 0.0, peak)));
  }
  return samples;
}

std::vector<std::uint8_t> painted(std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  std::vector<std::uint8_t> colours;
  for (std::size_t i = 0; i < kVoxels; ++i) colours.insert(colours.end(), {red, green, blue});
  return colours;
}

std::vector<std::uint8_t> varied() {
  std::vector<std::uint8_t> colours;
  for (std::size_t i = 0; i < 3 * kVoxels; ++i) colours.push_back(static_cast<std::uint8_t>(i * 37 % 251));
  return colours;
}

VolumeView view_of(const std::vector<std::byte>& samples, const std::vector<std::uint8_t>& colours = {}) {
  return {.samples = samples, .dims = {kSize, kSize, kSize}, .colours = colours};
}

// Opacity in proportion to the sample: `top` at 255.
TransferFunction ramp(double top, Colour colour = {1, 1, 1}) {
  return {{{0, colour}, {255, colour}}, {{0, 0}, {255, top}}};
}

View flat_view() {
  View view = front_view(kSize);
  view.shade = false;
  return view;
}

Image picture(const std::string& where, const VolumeView& volume, const TransferFunction& look,
              const View& view = front_view(kSize)) {
  Board board = Board::open(where);
  board.set_transfer_function(look);
  board.load_volume(volume);
  return board.render(view);
}

TEST(Colours, TheCardSaysItsFormat) {
  EXPECT_EQ(Board::open("emu:").info().voxel_format, VoxelFormat::kDensity);
  EXPECT_EQ(Board::open(uri("rgb")).info().voxel_format, VoxelFormat::kRgb);
  EXPECT_EQ(Board::open(uri("rgba")).info().voxel_format, VoxelFormat::kRgba);
}

TEST(Colours, AreRefusedByACardWithoutThemAndInAWrongNumber) {
  const auto samples = ball(200);
  const auto colours = painted(1, 2, 3);
  Board plain = Board::open(kSmallBlocks);
  EXPECT_THROWS(BadArgument, "colours: expected none, since the card's voxels have none",
                plain.load_volume(view_of(samples, colours)));
  Board board = Board::open(uri("rgb"));
  std::vector<std::uint8_t> few(colours.begin(), colours.end() - 1);
  EXPECT_THROWS(BadArgument, "colours: expected none or 139968 bytes, 3 per voxel, got 139967",
                board.load_volume(view_of(samples, few)));
}

TEST(Colours, NoneOrAllWhiteGiveTheBitsOfACardWithoutThem) {
  const auto samples = ball(255);
  const auto white = painted(255, 255, 255);
  const TransferFunction look = ramp(0.4, {0.9, 0.5, 0.2});
  const Image expected = picture(kSmallBlocks, view_of(samples), look);
  for (const char* format : {"rgb", "rgba"}) {
    EXPECT_EQ(picture(uri(format), view_of(samples), look), expected) << format;
    EXPECT_EQ(picture(uri(format), view_of(samples, white), look), expected) << format;
  }
}

TEST(Colours, OfOneKindAreTheTransferFunctionsColour) {
  const auto samples = ball(255);
  const auto colours = painted(51, 102, 204);  // 819, 1638, 3276 of 4095: exact in both
  const Image expected = picture(kSmallBlocks, view_of(samples), ramp(0.4, {0.2, 0.4, 0.8}));
  EXPECT_EQ(picture(uri("rgb"), view_of(samples, colours), ramp(0.4)), expected);
  // Premultiplied words are rounded to 1/8 of 1/4095 and divided again, which differs where alpha is small.
  const Image divided = picture(uri("rgba"), view_of(samples, colours), ramp(0.4));
  for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
    ASSERT_NEAR(divided.pixels[i].red, expected.pixels[i].red, 1) << i;
    ASSERT_NEAR(divided.pixels[i].blue, expected.pixels[i].blue, 1) << i;
    ASSERT_EQ(divided.pixels[i].alpha, expected.pixels[i].alpha) << i;
  }
}

// A volume classified by the host and one by the card: the same where the table is a straight line and the colour is
// one, up to the eight bits of alpha that the host has rounded to.
TEST(Colours, APreClassifiedVolumeLooksAsTheOneThatItWasMadeOf) {
  const auto samples = ball(255);
  constexpr double kTop = 0.6;
  std::vector<std::byte> alpha;
  for (const std::byte sample : samples) {
    alpha.push_back(static_cast<std::byte>(std::lround(std::to_integer<int>(sample) * kTop)));
  }
  const Image expected = picture(kSmallBlocks, view_of(samples), ramp(kTop, {1, 0.4, 0.2}), flat_view());
  const Image classified = picture(uri("rgba"), view_of(alpha, painted(255, 102, 51)), ramp(1), flat_view());
  // Each of some 16 samples of a ray is off by half of 1/255 of its opacity at most, mostly by chance: 4 of 255, and of
  // 4095 the same part.
  for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
    ASSERT_NEAR(classified.pixels[i].red, expected.pixels[i].red, 4) << i;
    ASSERT_NEAR(classified.pixels[i].green, expected.pixels[i].green, 4) << i;
    ASSERT_NEAR(classified.pixels[i].alpha, expected.pixels[i].alpha, 64) << i;
  }
}

// What premultiplication is for: a voxel of no alpha lends no colour to its neighbours.
TEST(Colours, OfVoxelsWithoutAlphaDoNotBleedIntoTheirNeighbours) {
  std::vector<std::byte> alpha(kVoxels);
  auto colours = painted(0, 255, 0);  // of the empty voxels
  for (std::size_t i = 0; i < kVoxels; ++i) {
    if (i / kSize % kSize < 18) continue;
    alpha[i] = std::byte{200};
    colours[3 * i] = 255;
    colours[3 * i + 1] = 0;
  }
  Board board = Board::open(uri("rgba"));
  board.set_transfer_function(ramp(0.5));
  board.load_volume(view_of(alpha, colours));
  View view = flat_view();
  view.width = view.height = 4 * kSize;
  for (const Pixel& pixel : board.render(view).pixels) EXPECT_EQ(pixel.green, 0);

  Board straight = Board::open(uri("rgb"));
  straight.set_transfer_function(ramp(0.5));
  straight.load_volume(view_of(alpha, colours));
  int green = 0;
  for (const Pixel& pixel : straight.render(view).pixels) green = std::max<int>(green, pixel.green);
  EXPECT_GT(green, 10) << "the plain format does";
}

TEST(Colours, AreTheSameOnEveryLevelAndInBricks) {
  const auto samples = ball(255);
  const auto colours = varied();
  for (const char* format : {"rgb", "rgba"}) {
    const Image expected = picture(uri(format), view_of(samples, colours), ramp(0.3));
    EXPECT_EQ(picture(uri(format, "&fidelity=cycle"), view_of(samples, colours), ramp(0.3)), expected) << format;
    const std::string small = kSmallCard + "&set=asic.voxel_format=" + format;
    EXPECT_EQ(picture(small, view_of(samples, colours), ramp(0.3)), expected) << format;
  }
}

TEST(Colours, OfAStreamAreThoseOfAVolumeInMemory) {
  const auto samples = ball(255);
  const auto colours = varied();
  const auto copy_planes = [](const auto& from, int first, std::span<std::byte> out) {
    const std::size_t of_plane = from.size() / kSize;
    const auto bytes = std::as_bytes(std::span(from)).subspan(static_cast<std::size_t>(first) * of_plane, out.size());
    std::copy(bytes.begin(), bytes.end(), out.begin());
  };
  VolumeStream stream;
  stream.dims = {kSize, kSize, kSize};
  stream.read = [&](int first, int, std::span<std::byte> out) { copy_planes(samples, first, out); };
  stream.read_colours = [&](int first, int, std::span<std::byte> out) { copy_planes(colours, first, out); };
  Board board = Board::open(kSmallCard + "&set=asic.voxel_format=rgb");
  board.set_transfer_function(ramp(0.3));
  board.load_volume(stream);
  EXPECT_EQ(board.render(front_view(kSize)), picture(uri("rgb"), view_of(samples, colours), ramp(0.3)));
}

TEST(Colours, StayWhenValuesAreOverwrittenAndAreVerified) {
  const auto samples = ball(255), thinner = ball(120);
  const auto colours = varied();
  Board board = Board::open(uri("rgb"));
  board.set_transfer_function(ramp(0.3));
  board.load_volume(view_of(samples, colours));
  EXPECT_TRUE(board.verify_volume().empty());
  std::vector<float> values;
  for (const std::byte sample : thinner) values.push_back(static_cast<float>(std::to_integer<int>(sample)));
  board.write_volume({{0, 0, 0}, {kSize, kSize, kSize}}, values);
  EXPECT_TRUE(board.verify_volume().empty());
  // Gradients are those of densities then, which the other board has found in the same way.
  Board other = Board::open(uri("rgb"));
  other.set_transfer_function(ramp(0.3));
  other.load_volume(view_of(thinner, colours));
  other.write_volume({{0, 0, 0}, {kSize, kSize, kSize}}, values);
  EXPECT_EQ(board.render(front_view(kSize)), other.render(front_view(kSize)));
}

TEST(Colours, GoToTheNextBoardWithTheVolumeAndIntoACheckpoint) {
  const auto samples = ball(255);
  const auto colours = varied();
  const Image expected = picture(uri("rgba"), view_of(samples, colours), ramp(0.3));
  Board board = Board::open(uri("rgba"));
  board.set_transfer_function(ramp(0.3));
  board.load_volume(view_of(samples, colours));
  const std::vector<std::byte> saved = board.save();
  Board other = Board::open(uri("rgba"));
  other.restore(saved);
  EXPECT_EQ(other.render(front_view(kSize)), expected);
  EXPECT_TRUE(other.verify_volume().empty());
}

TEST(Colours, CostABlockTheirPartOfTheBus) {
  const std::vector<std::byte> samples(kVoxels, std::byte{9});
  const auto bytes = [&](const char* where, const std::vector<std::uint8_t>& colours) {
    Board board = Board::open(where);
    board.load_volume(view_of(samples, colours));
    return board.counters().value("bus.volume.bytes");
  };
  const std::uint64_t plain = bytes(kSmallBlocks, {}), coloured = bytes(uri("rgb").c_str(), varied());
  EXPECT_EQ(coloured * 3, plain * 5);  // 60 bits for 36, of as many blocks
}

}  // namespace
}  // namespace gicube::reference
