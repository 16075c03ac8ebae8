// Files of VTK and NumPy written by hand, in text or with a short header.
#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

std::string numbers() {
  std::string text;
  for (const std::int16_t sample : ramp<std::int16_t>()) text += std::to_string(sample) + " ";
  return text;
}

void expect_placed_ramp(const Volume& volume) {
  EXPECT_EQ(samples_of<std::int16_t>(volume), ramp<std::int16_t>());
  EXPECT_EQ(volume.dims, kRampDims);
  EXPECT_EQ(volume.spacing, (Vec3{1, 2, 3}));
  EXPECT_EQ(volume.placement.origin, (Vec3{10, 20, 30}));
}

TEST(VtkFile, LegacyTextHasItsSamplesAndItsPlace) {
  const TemporaryFolder folder;
  const std::string head =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 3 4\nORIGIN 10 20 30\n"
      "SPACING 1 2 3\nPOINT_DATA 24\n";
  expect_placed_ramp(read_volume(folder.write("a.vtk", head + "SCALARS v short\nLOOKUP_TABLE default\n" + numbers())));
  expect_placed_ramp(read_volume(folder.write("b.vtk", head + "FIELD all 1\nv 1 24 short\n" + numbers())));
  EXPECT_THAT(read_error(folder.write("c.vtk", head + "SCALARS v short\nLOOKUP_TABLE default\n0.5 " + numbers())),
              HasSubstr("0.5"));
}

TEST(VtkFile, XmlTextHasItsSamplesAndItsPlace) {
  const TemporaryFolder folder;
  expect_placed_ramp(read_volume(folder.write(
      "a.vti",
      "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\">"
      "<ImageData WholeExtent=\"0 1 0 2 0 3\" Origin=\"10 20 30\" Spacing=\"1 2 3\"><Piece Extent=\"0 1 0 2 0 3\">"
      "<PointData Scalars=\"v\"><DataArray type=\"Int16\" Name=\"v\" format=\"ascii\">" +
          numbers() + "</DataArray></PointData></Piece></ImageData></VTKFile>")));
}

TEST(NumpyFile, TheLastIndexRunsFastestUnlessItIsFortrans) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& order, const std::string& shape) {
    std::string head = "{'descr': '<i2', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
    head.resize(117, ' ');
    return read_volume(folder.write(
        "a.npy", std::string("\x93NUMPY\x01\x00\x76\x00", 10) + head + '\n' + stored(ramp<std::int16_t>())));
  };
  for (const Volume& volume : {read("False", "(4, 3, 2)"), read("True", "(2, 3, 4)")}) {
    EXPECT_EQ(samples_of<std::int16_t>(volume), ramp<std::int16_t>());
    EXPECT_EQ(volume.dims, kRampDims);
  }
}

TEST(HeaderLines, OfAMegabyteAndNoEndAreRefused) {
  const TemporaryFolder folder;
  std::string lines = "ObjectType = Image\n";
  while (lines.size() < 3u << 20) lines += "Comment = none\n";
  EXPECT_THAT(read_error(folder.write("a.mha", lines)), HasSubstr("expected its end within"));
}

}  // namespace
}  // namespace gicube::scene
