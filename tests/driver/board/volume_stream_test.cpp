// Volumes that are read in planes while they are loaded are the same as those that are in memory.
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <new>

#include "gicube/testing.h"
#include "test.h"
#include "test_board.h"
#include "voxels.h"

namespace gicube::reference {
namespace {

using Planes = std::pair<int, int>;  // first, count

// Stores 8 blocks of 16^3.
constexpr const char* kSmall = "emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=32";

template <typename T>
struct Ramp {
  Dims dims;
  std::vector<T> values;

  Ramp(SampleType of, Dims size) : dims(size), type_(of) {
    for_each_voxel(dims, [&](int x, int y, int z) {
      values.push_back(static_cast<T>(70 + 60 * std::sin(0.2 * x) * std::sin(0.3 * y) + 0.5 * z * (y % 3)));
    });
  }
  VolumeView view() const {
    return {.samples = std::as_bytes(std::span(values)), .type = type_, .dims = dims, .spacing = {1, 1.5, 1}};
  }
  // Notes what it is asked for.
  VolumeStream stream(std::vector<Planes>& asked) const {
    const auto read = [this, &asked](int first, int planes, std::span<std::byte> out) {
      asked.emplace_back(first, planes);
      const std::size_t plane = static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) * sizeof(T);
      ASSERT_EQ(out.size(), plane * static_cast<std::size_t>(planes));
      std::memcpy(out.data(), std::as_bytes(std::span(values)).data() + plane * static_cast<std::size_t>(first),
                  out.size());
    };
    return {.read = read, .type = type_, .dims = dims, .spacing = {1, 1.5, 1}};
  }

 private:
  SampleType type_;
};

View picture() {
  View view;
  view.eye = {-40, -60, -90};
  view.look_at = {20, 25, 30};
  view.width = view.height = 40;
  return view;
}

TransferFunction look() { return {.colours = {{0, {1, 0.5, 0.2}}}, .opacities = {{10, 0}, {40, 0.03}, {120, 0.4}}}; }

template <typename T>
void expect_same(const char* uri, SampleType type, Dims dims) {
  const Ramp<T> ramp(type, dims);
  Board memory = Board::open(uri), stream = Board::open(uri);
  std::vector<Planes> asked;
  memory.load_volume(ramp.view());
  stream.load_volume(ramp.stream(asked));
  EXPECT_EQ(stream.value_range(), memory.value_range());
  EXPECT_EQ(stream.empty_flags(), memory.empty_flags());
  for (Board* board : {&memory, &stream}) board->set_transfer_function(look());
  EXPECT_EQ(stream.render(picture()).pixels, memory.render(picture()).pixels);
  EXPECT_EQ(stream.now(), memory.now());
  int next = 0, times = 0;
  for (const auto& [first, count] : asked) {
    times += first == 0 ? 1 : 0;
    EXPECT_EQ(first, first == 0 ? 0 : next) << "in order, each once";
    next = first + count;
  }
  EXPECT_EQ(next, dims[2]);
  EXPECT_EQ(times, type == SampleType::kUint8 || type == SampleType::kUint12 ? 1 : 2);
}

TEST(VolumeStream, GivesTheBitsOfOneInMemoryOnACardThatStoresIt) {
  expect_same<std::uint8_t>("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=128", SampleType::kUint8,
                            {40, 50, 67});
  expect_same<float>("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=128", SampleType::kFloat32,
                     {40, 50, 67});
}

TEST(VolumeStream, GivesTheBitsOfOneInMemoryOnACardThatDoesNot) {
  expect_same<std::uint8_t>(kSmall, SampleType::kUint8, {40, 50, 67});
  expect_same<std::uint16_t>(kSmall, SampleType::kUint12, {40, 50, 65});
  expect_same<std::int16_t>(kSmall, SampleType::kInt16, {33, 50, 64});
  expect_same<float>(kSmall, SampleType::kFloat32, {40, 34, 66});
}

TEST(VolumeStream, IsAskedForFewPlanesAtATime) {
  const Ramp<std::uint8_t> ramp(SampleType::kUint8, {40, 50, 67});
  Board board = Board::open(kSmall);
  std::vector<Planes> asked;
  std::vector<std::uint32_t> done;
  board.load_volume(ramp.stream(asked), [&](std::uint32_t so_far, std::uint32_t all) {
    EXPECT_EQ(all, 3u * 4 * 5);
    done.push_back(so_far);
  });
  // A layer of 16, a plane for its faces and one for the gradients there.
  EXPECT_THAT(asked, ElementsAre(Planes{0, 18}, Planes{18, 16}, Planes{34, 16}, Planes{50, 16}, Planes{66, 1}));
  std::vector<std::uint32_t> each(61);  // block, and the end
  std::iota(each.begin(), each.end(), 0u);
  EXPECT_EQ(done, each);
}

// Somebody else has cut the driver's file of blocks off.
TEST(VolumeStream, NamesTheFolderIfABlockCannotBeReadAndTheBoardLivesOn) {
  const Ramp<std::uint8_t> ramp(SampleType::kUint8, {40, 50, 67});
  Board board = Board::open(kSmall);
  board.set_transfer_function(look());
  std::vector<Planes> asked;
  board.load_volume(ramp.stream(asked));
  const Image before = board.render(picture());
  for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    const std::string name = std::filesystem::read_symlink(file, gone).string();
    if (name.find("gicube-volume") != std::string::npos) std::ofstream(file.path(), std::ios::trunc);
  }
  View other = picture();
  other.eye = {90, 110, 160};  // blocks in another order
  const auto both = [&] {
    board.render(other);
    board.render(picture());
  };
  EXPECT_THAT(both, ThrowsMessage<Error>(
                        HasSubstr("gives back a volume larger than the card (TMPDIR), got the end of the file")));
  board.load_volume(ramp.stream(asked));
  EXPECT_EQ(board.render(picture()).pixels, before.pixels);
}

TEST(VolumeStream, LeavesTheFormerVolumeIfItCannotBeRead) {
  const Ramp<float> ramp(SampleType::kFloat32, {40, 50, 67});
  Board board = Board::open(kSmall);
  board.set_transfer_function(look());
  board.load_volume(ramp.view());
  const Image before = board.render(picture());
  std::vector<Planes> asked;
  VolumeStream broken = ramp.stream(asked);
  broken.range = ValueRange{0, 100};
  broken.read = [](int first, int, std::span<std::byte> out) {
    if (first > 0) throw std::runtime_error("no more planes");
    std::ranges::fill(out, std::byte{0});
  };
  EXPECT_THROW(board.load_volume(broken), std::runtime_error);
  broken.read = [](int first, int, std::span<std::byte> out) {
    std::ranges::fill(out, std::byte{0});
    const float nan = std::numeric_limits<float>::quiet_NaN();
    if (first == 34) std::memcpy(out.data() + 4 * (40 * 50 + 3 * 40 + 7), &nan, 4);
  };
  EXPECT_THAT(
      [&] { board.load_volume(broken); },
      ThrowsMessage<BadArgument>(testing::StrEq("samples at voxel (7, 3, 35): expected a finite number, got nan")));
  broken.read = nullptr;
  EXPECT_THAT([&] { board.load_volume(broken); },
              ThrowsMessage<BadArgument>(testing::StrEq("read: expected a function, got null")));
  EXPECT_EQ(board.render(picture()).pixels, before.pixels);
}

// So much may the process have: as a system that has no more would.
class AddressSpace {
 public:
  explicit AddressSpace(std::size_t more) {
    ::malloc_trim(0);  // what other tests have freed
    ::getrlimit(RLIMIT_AS, &before_);
    std::ifstream status("/proc/self/statm");
    std::size_t pages = 0;
    status >> pages;
    const rlimit less{pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + more, before_.rlim_max};
    ::setrlimit(RLIMIT_AS, &less);
  }
  AddressSpace(const AddressSpace&) = delete;
  AddressSpace& operator=(const AddressSpace&) = delete;
  ~AddressSpace() { ::setrlimit(RLIMIT_AS, &before_); }

 private:
  rlimit before_{};
};

// 512 MiB in planes that are alike.
TEST(VolumeStream, NeedsLessThanAQuarterOfTheVolumesMemory) {
  Board board = Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64");
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 0}, {200, 1}}});
  VolumeStream stream;
  stream.dims = {1024, 1024, 512};
  stream.find_gradients = false;
  stream.read = [](int, int, std::span<std::byte> out) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::byte>(i / 1024 % 1024 < 16 ? 200 : 0);
  };
  const AddressSpace limit(std::size_t{128} << 20);
  EXPECT_THROW(std::vector<std::byte>(std::size_t{128} << 20), std::bad_alloc);
  board.load_volume(stream);
  View view = picture();
  view.eye = {512, 300, -300};
  view.look_at = {512, 8, 256};
  view.shade = false;
  const Image image = board.render(view);
  EXPECT_EQ(image.pixels[20 * 40 + 20].alpha, 4095);
}

TEST(VolumeStream, NamesTheFolderThatCannotKeepIt) {
  const Ramp<std::uint8_t> ramp(SampleType::kUint8, {40, 50, 67});
  Board board = Board::open(kSmall);
  std::vector<Planes> asked;
  ASSERT_EQ(::setenv("TMPDIR", "/there/is/none", 1), 0);
  EXPECT_THAT([&] { board.load_volume(ramp.stream(asked)); },
              ThrowsMessage<Error>(testing::StrEq("volume: expected a folder /there/is/none that can keep a "
                                                  "volume larger than the card (TMPDIR), got No such file or "
                                                  "directory")));
  ::unsetenv("TMPDIR");
  board.load_volume(ramp.stream(asked));
  EXPECT_EQ(board.dims(), ramp.dims);
}

}  // namespace
}  // namespace gicube::reference
