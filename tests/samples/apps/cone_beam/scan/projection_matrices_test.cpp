#include "cone_beam/scan/formats.h"

#include "cone_beam/scan/description.h"
#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr double kPi = std::numbers::pi;

// What plastimatch 1.9.4 writes for `drr -N 45 --sad 400 --sid 600 -r "40 60" -z "120 180"`, of its second view.
constexpr const char* kSecondView = R"(    1.95000000e+01     2.95000000e+01
    2.35702266e-01     2.35702255e-01     0.00000000e+00     0.00000000e+00
    0.00000000e+00     0.00000000e+00    -3.33333333e-01     0.00000000e+00
   -1.17851128e-03     1.17851133e-03     0.00000000e+00     6.66666667e-01
    4.00000000e+02
    6.00000000e+02
   -7.07106766e-01     7.07106797e-01    -0.00000000e+00
Extrinsic
    7.07106797e-01     7.07106766e-01    -0.00000000e+00     0.00000000e+00
)";

class Matrices : public testing::Test {
 protected:
  ConeGeometry geometry() const {
    ConeGeometry out;
    out.source_to_axis = 400;
    out.source_to_detector = 600;
    out.detector = {6, 4, 2, 3, 5, -1};
    out.angles = {0.25, 1, 3};
    return out;
  }
  // The geometry as plastimatch's files with images beside them.
  ScanDescription folder_of(const ConeGeometry& from) const {
    for (std::size_t i = 0; i < from.angles.size(); ++i) {
      const std::string name = fmt::format("v{}", i);
      write_projection_matrix(from, from.angles[i], folder_.file(name + ".txt"));
      const Stack view{from.detector.columns, from.detector.rows, std::vector<float>(24), false};
      write_stack(view, folder_.file(name + ".mha"));
    }
    return read_matrix_folder(folder_.file(""), {});
  }

  const reference::TemporaryDirectory folder_;
};

TEST_F(Matrices, OfPlastimatchAreTurnedIntoPlaces) {
  const auto file = folder_.write("a.txt", kSecondView);
  const ViewPose view = pose_of(read_projection_matrix(file), 40, 60, file);
  const double half = std::sqrt(0.5);
  EXPECT_NEAR(length(view.source - Vec3{400 * half, -400 * half, 0}), 0, 1e-4);
  EXPECT_NEAR(length(view.centre - Vec3{-200 * half, 200 * half, 0}), 0, 1e-4);
  EXPECT_NEAR(length(view.u - Vec3{3 * half, 3 * half, 0}), 0, 1e-6);
  EXPECT_NEAR(length(view.v - Vec3{0, 0, -3}), 0, 1e-6);
}

double difference(const ViewPose& a, const ViewPose& b) {
  return length(a.source - b.source) + length(a.centre - b.centre) + length(a.u - b.u) + length(a.v - b.v);
}

TEST_F(Matrices, SayTheSameWhateverTheirFactorAndTheirNormalsSide) {
  const auto file = folder_.write("a.txt", kSecondView);
  ProjectionMatrix matrix = read_projection_matrix(file);
  const ViewPose first = pose_of(matrix, 40, 60, file);
  for (double& value : matrix.matrix) value *= -3;
  matrix.normal = -1.0 * matrix.normal;
  EXPECT_NEAR(difference(first, pose_of(matrix, 40, 60, file)), 0, 1e-9);
}

TEST_F(Matrices, MayHoldTheDetectorsCentreThemselves) {
  const auto file = folder_.write("a.txt", kSecondView);
  ProjectionMatrix matrix = read_projection_matrix(file);
  const ViewPose first = pose_of(matrix, 40, 60, file);
  for (std::size_t i = 0; i < 4; ++i) {
    matrix.matrix[i] += matrix.centre[0] * matrix.matrix[8 + i];
    matrix.matrix[4 + i] += matrix.centre[1] * matrix.matrix[8 + i];
  }
  matrix.centre = {0, 0};
  EXPECT_NEAR(difference(first, pose_of(matrix, 40, 60, file)), 0, 1e-8);
}

// A matrix is what it says: a place's pixel by the matrix is where the pose sees it, however detector and pixels are
// turned.
TEST_F(Matrices, OfTiltedAndSkewedDetectorsSeePlacesWhereTheySay) {
  const auto file = folder_.write("a.txt", kSecondView);
  ProjectionMatrix matrix = read_projection_matrix(file);
  matrix.matrix[10] += 0.02 * matrix.matrix[8];  // tilted
  matrix.matrix[2] += 0.05 * matrix.matrix[0];   // rows that rise
  matrix.matrix[4] += 0.03 * matrix.matrix[6];   // columns that lean
  matrix.normal = {matrix.matrix[8], matrix.matrix[9], matrix.matrix[10]};
  const ViewPose view = pose_of(matrix, 40, 60, file);
  for (const Vec3 place : {Vec3{10, -20, 5}, Vec3{-30, 4, 25}, Vec3{0, 0, 0}}) {
    std::array<double, 3> out{};
    for (std::size_t row = 0; row < 3; ++row) {
      const double* const r = matrix.matrix.data() + 4 * row;
      out[row] = r[0] * place.x + r[1] * place.y + r[2] * place.z + r[3];
    }
    const SeenAt seen = seen_at(view, place);
    EXPECT_NEAR(seen.column + 19.5, matrix.centre[0] + out[0] / out[2], 1e-5);
    EXPECT_NEAR(seen.row + 29.5, matrix.centre[1] + out[1] / out[2], 1e-5);
  }
}

TEST_F(Matrices, ComeBackAsTheGeometryThatTheyWereWrittenFrom) {
  const ScanDescription scan = folder_of(geometry());
  const ConeGeometry &read = scan.geometry, wanted = geometry();
  EXPECT_NEAR(read.source_to_axis, wanted.source_to_axis, 1e-4);
  EXPECT_NEAR(read.source_to_detector, wanted.source_to_detector, 1e-4);
  EXPECT_EQ(read.detector.columns, 6);
  EXPECT_EQ(read.detector.rows, 4);
  EXPECT_NEAR(read.detector.pitch_u, 2, 1e-6);
  EXPECT_NEAR(read.detector.pitch_v, 3, 1e-6);
  EXPECT_NEAR(read.detector.offset_u, 5, 1e-6);
  EXPECT_NEAR(read.detector.offset_v, -1, 1e-6);
  ASSERT_EQ(read.angles.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(read.angles[i], wanted.angles[i], 1e-7);
  EXPECT_EQ(scan.projections.files.size(), 3u);
}

TEST_F(Matrices, MayTurnAboutAnotherAxisThanTheOrigins) {
  folder_of(geometry());
  const Vec3 shift{10, -20, 5};
  for (const char* name : {"v0.txt", "v1.txt", "v2.txt"}) {
    const ProjectionMatrix matrix = read_projection_matrix(folder_.file(name));
    std::string text = fmt::format("{} {}\n", matrix.centre[0], matrix.centre[1]);
    for (std::size_t row = 0; row < 3; ++row) {
      const double* const r = matrix.matrix.data() + 4 * row;
      text += fmt::format("{} {} {} {}\n", r[0], r[1], r[2], r[3] - (r[0] * shift.x + r[1] * shift.y + r[2] * shift.z));
    }
    const Vec3 n = matrix.normal;
    folder_.write(name, text + fmt::format("400\n600\n{} {} {}\n", n.x, n.y, n.z));
  }
  const ScanDescription scan = read_matrix_folder(folder_.file(""), {});
  EXPECT_TRUE(scan.geometry.circular());
  EXPECT_NEAR(length(scan.centre - shift), 0, 1e-4);
  EXPECT_NEAR(scan.geometry.detector.offset_u, 5, 1e-5);
}

TEST_F(Matrices, ThatLieOnNoCircleKeepTheirPoses) {
  folder_of(geometry());
  ConeGeometry other = geometry();
  other.detector.offset_u = 7;
  write_projection_matrix(other, 1, folder_.file("v1.txt"));
  const ScanDescription scan = read_matrix_folder(folder_.file(""), {});
  ASSERT_FALSE(scan.geometry.circular());
  EXPECT_EQ(scan.geometry.angles.size(), 3u);
  const ConeGeometry shifted = other, wanted = geometry();
  EXPECT_NEAR(difference(scan.geometry.poses[0], pose(wanted, 0)), 0, 1e-6);
  EXPECT_NEAR(difference(scan.geometry.poses[1], pose(shifted, 1)), 0, 1e-6);
}

TEST_F(Matrices, AreRefusedWithTheNumberThatIsWrong) {
  const auto expect = [&](const std::string& text, const std::string& part) {
    const auto file = folder_.write("a.txt", text);
    EXPECT_THAT(message_of<FileError>([&] { pose_of(read_projection_matrix(file), 4, 4, file); }), HasSubstr(part));
  };
  expect("1 2 3", "a.txt: matrix 2: expected a number, got the end");
  expect("1 x", "a.txt: centre 2: expected a number, got \"x\"");
  expect("0 0  1 0 0 0  0 1 0 0  0 0 1 5  400 inf", "source to detector 1: expected a number, got \"inf\"");
  expect("0 0  1 0 0 0  1 0 0 0  0 0 1 5  400 600  0 0 1", "matrix: expected three independent rows");
  expect("0 0  1 0 0 0  0 1 0 0  0 0 1 5  400 600  1 0 0", "normal: expected along (0, 0, 1)");
  expect("0 0  1 0 0 0  0 1 0 0  0 0 1 5  400 600  0 0 1  7", "behind the normal: expected \"Extrinsic\"");
}

TEST_F(Matrices, NeedAnImageBesideEachUnlessAStackIsNamed) {
  folder_of(geometry());
  std::filesystem::remove(folder_.file("v2.mha"));
  EXPECT_THAT(message_of<FileError>([&] { read_matrix_folder(folder_.file(""), {}); }),
              HasSubstr("v2.txt: image: expected one"));
  const Stack all{6, 4, std::vector<float>(72), false};
  const StackFiles stack{write_stack(all, folder_.file("all.nrrd")), {}};
  EXPECT_EQ(read_matrix_folder(folder_.file(""), stack).geometry.angles.size(), 3u);
}

}  // namespace
}  // namespace gicube::samples
