// Damage anywhere in a file ends in a FileError or in a volume, never in a crash or another exception.
#include "../damage.h"
#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

constexpr int kRounds = 500;                                   // chosen: some seconds for all formats with sanitizers
constexpr std::string_view kLikely = "0123456789-. \n:=%,()";  // in headers

// Returns how many of the rounds were refused.
int damage(const std::string& name, const std::string& whole) {
  const TemporaryFolder folder;
  EXPECT_EQ(read_volume(folder.write(name, whole)).dims, kRampDims) << name;
  std::mt19937 random(7);
  int refused = 0;
  for (int round = 0; round < kRounds; ++round) {
    refused += read_error(folder.write(name, damaged(whole, kLikely, random))) != "none" ? 1 : 0;
  }
  return refused;
}

TEST(DamagedFiles, NrrdIsReadOrRefused) {
  const std::string start = "NRRD0005\n# words\ntype: short\ndimension: 3\nsizes: 2 3 4\nendian: little\nkey:=value\n";
  const std::string space = "space: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\n";
  const std::string samples = stored(ramp<std::int16_t>());
  EXPECT_GT(damage("v.nrrd", start + space + "byte skip: 0\nencoding: raw\n\n" + samples), kRounds / 4);
  EXPECT_GT(damage("z.nrrd", start + "kinds: domain domain domain\nencoding: gzip\n\n" + gzip(samples)), kRounds / 4);
}

TEST(DamagedFiles, MetaImageIsReadOrRefused) {
  const std::string start = "ObjectType = Image\nNDims = 3\nDimSize = 2 3 4\nElementType = MET_SHORT\n";
  const std::string samples = stored(ramp<std::int16_t>());
  EXPECT_GT(damage("v.mha", start + "ElementSpacing = 1 1 2\nElementDataFile = LOCAL\n" + samples), kRounds / 4);
  EXPECT_GT(damage("z.mha", start + "CompressedData = True\nElementDataFile = LOCAL\n" + zlib(samples)), kRounds / 4);
}

TEST(DamagedFiles, NiftiIsReadOrRefused) {
  // A header as numbers: sizes at byte 40, type at 70, spacing at 80, data offset at 108, "n+1" at 344.
  std::string header(352, '\0');
  const auto put = [&](std::size_t at, const std::string& bytes) { header.replace(at, bytes.size(), bytes); };
  put(0, stored<std::int32_t>({348}));
  put(40, stored<std::int16_t>({3, 2, 3, 4, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 4}));
  put(80, stored<float>({1, 1, 1}));
  put(108, stored<float>({352}));
  put(344, "n+1");
  const std::string samples = stored(ramp<std::int16_t>());
  EXPECT_GT(damage("v.nii", header + samples), kRounds / 8);
  EXPECT_GT(damage("v.nii.gz", gzip(header + samples)), kRounds / 4);
}

}  // namespace
}  // namespace gicube::scene
