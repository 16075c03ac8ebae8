#include "scene/geometry/mesh_file.h"

#include "test.h"
#include "test_meshes.h"

namespace gicube::scene {
namespace {

constexpr const char* kHeaderEnd =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
    "element edge 1\nproperty int vertex1\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";

template <typename Value>
void append(std::string& bytes, Value value, bool big) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  if (big) std::reverse(raw, raw + sizeof value);
  bytes.append(raw, sizeof value);
}

std::string binary_ply(bool big) {
  std::string bytes = std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
                      " 1.0\ncomment made by hand\n" + kHeaderEnd;
  for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 1, 0.5}}) {
    append(bytes, static_cast<float>(p.x), big);
    append(bytes, static_cast<float>(p.y), big);
    append(bytes, static_cast<float>(p.z), big);
    bytes.push_back('\7');
  }
  append(bytes, std::int32_t{9}, big);
  bytes.push_back('\3');
  for (const std::int32_t corner : {0, 1, 2}) append(bytes, corner, big);
  bytes.push_back('\4');
  for (const std::int32_t corner : {3, 2, 1, 0}) append(bytes, corner, big);
  return bytes;
}

const std::string kAsciiPly = std::string("ply\r\nformat ascii 1.0\n") + kHeaderEnd +
                              "0 0 0 7\n1 0 0 7\n1 1 0 7\n0 1 0.5 7\n9\n3 0 1 2\n4 3 2 1 0\n";

void expect_the_plys_mesh(const Mesh& mesh) {
  ASSERT_EQ(mesh.points.size(), 4u);
  EXPECT_EQ(mesh.points[3], (Vec3{0, 1, 0.5}));
  const std::vector<std::array<std::uint32_t, 3>> expected{{0, 1, 2}, {3, 2, 1}, {3, 1, 0}};
  EXPECT_EQ(mesh.triangles, expected);
}

std::string ply_fault(const std::string& bytes) {
  return message_of<std::runtime_error>([&] { parse_ply(bytes, "a.ply"); });
}
std::string obj_fault(const std::string& text) {
  return message_of<std::runtime_error>([&] { parse_obj(text, "a.obj"); });
}

TEST(PlyFile, IsReadFromTextAndFromBytesOfEitherOrder) {
  expect_the_plys_mesh(parse_ply(kAsciiPly, "a.ply"));
  expect_the_plys_mesh(parse_ply(binary_ply(false), "a.ply"));
  expect_the_plys_mesh(parse_ply(binary_ply(true), "a.ply"));
}

TEST(PlyFile, IsRefusedWhereverItIsCut) {
  for (const std::string& whole : {binary_ply(false), binary_ply(true)}) {
    for (std::size_t length = 0; length < whole.size(); ++length) {
      EXPECT_NE(ply_fault(whole.substr(0, length)), "none") << length;
    }
  }
  for (std::size_t length = 0; length + 2 < kAsciiPly.size(); ++length) {
    EXPECT_NE(ply_fault(kAsciiPly.substr(0, length)), "none") << length;
  }
}

TEST(PlyFile, ThatClaimsMoreThanItHoldsIsRefusedBeforeMemoryIsTaken) {
  const std::string header = "ply\nformat binary_little_endian 1.0\n",
                    xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_THAT(ply_fault(header + "element vertex 999999999999\n" + xyz + "end_header\n1234"),
              HasSubstr("a.ply: element vertex: expected at most"));
  EXPECT_THAT(ply_fault(header + "element spring 18446744073709551615\nend_header\n"), HasSubstr("properties"));
  std::string list = header + "element face 1\nproperty list uint int vertex_index\nend_header\n";
  append(list, std::uint32_t{900'000'000}, false);
  EXPECT_THAT(ply_fault(list + "12345678"), HasSubstr("the end of the file"));
}

TEST(PlyFile, NamesWhatIsWrong) {
  const std::string ascii = "ply\nformat ascii 1.0\n", xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string vertices = "element vertex 3\n" + xyz;
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  const std::pair<std::string, const char*> cases[] = {
      {"obj\n", "ply in the first line"},
      {"ply\nformat text 1.0\nend_header\n", "got \"text\""},
      {"ply\nend_header\n", "a format"},
      {ascii + "element vertex many\nend_header\n", "got \"many\""},
      {ascii + "element vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n", "property z"},
      {ascii + "property float x\nend_header\n", "an element before it"},
      {ascii + "element vertex 1\nproperty half x\nend_header\n", "char to double"},
      {ascii + "element face 1\nproperty list float int vertex_index\nend_header\n", "whole number"},
      {ascii + vertices + "element face 1\nproperty int a\nend_header\n" + points + "1\n", "vertex_index"},
      {ascii + vertices + faces + "end_header\n" + points + "3 0 1 3\n", "a vertex from 0 to 2, got 3"},
      {ascii + vertices + faces + "end_header\n" + points + "2 0 1\n", "at least 3 corners"},
      {ascii + vertices + faces + "end_header\n" + points + "3 0 1 -2\n", "the number of a vertex"},
      {ascii + vertices + faces + "end_header\n0 nan 0\n1 0 0\n0 1 0\n3 0 1 2\n", "finite"},
      {ascii + vertices + faces + "end_header\n0 x 0\n1 0 0\n0 1 0\n3 0 1 2\n", "got \"x\""},
  };
  for (const auto& [text, fault] : cases) EXPECT_THAT(ply_fault(text), HasSubstr(fault));
}

TEST(ObjFile, IsReadWithEveryFormOfACorner) {
  const Mesh mesh = parse_obj(
      "# a comment\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\r\nv 1 1 0\nvt 0 0\nvn 0 0 1\nv 0 1 .5e0\n"
      "s off\nf 1/1/1 2//1 3/1\nf -1 -2 -3 -4 # back\n",
      "a.obj");
  expect_the_plys_mesh(mesh);
  EXPECT_TRUE(mesh.texture.empty());  // not all corners have coordinates
  EXPECT_TRUE(mesh.texture_triangles.empty());
}

TEST(ObjFile, HasTextureCoordinatesIfAllCornersHave) {
  const Mesh mesh = parse_obj(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0.5\nvt 0.25 1\nf 1/1 2/2/7 3/3 4/-2\nf -1/3 -2/2 -3/1\n",
      "a.obj");
  EXPECT_EQ(mesh.texture, (std::vector<std::array<double, 2>>{{0, 0}, {1, 0}, {0.25, 1}}));
  EXPECT_EQ(mesh.texture_triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 1}, {2, 1, 0}}));
  EXPECT_EQ(mesh.triangles.size(), 3u);
}

TEST(ObjFile, GoesOnBehindABackslash) {
  const Mesh mesh =
      parse_obj("v 0 0\\\n 0\nv 1 0 0\nv 1 \\\r\n1\\\n0\nv 0 1 .5e0 # \\\nf 1 2 \\\n  3 \\\n  4\n", "a.obj");
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}}));
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_THAT(obj_fault("v 0 0 0\nf 1 1 1\nv 0 \\"), HasSubstr("line 3: statement: expected a line after"));
}

TEST(ObjFile, NamesLineAndWhatIsWrong) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const std::pair<std::string, const char*> cases[] = {
      {"v 0 0\n", "line 1: v: expected three finite numbers"},
      {"v 0 0 inf\n", "got \"inf\""},
      {points + "f 1 2\n", "line 4: f: expected at least 3 corners"},
      {points + "f 1 2 4\n", "a point from 1 to 3, got \"4\""},
      {points + "f 1 2 0\n", "got \"0\""},
      {points + "f 1 2 -4\n", "got \"-4\""},
      {points + "f 1 2 x\n", "got \"x\""},
      {"vt 1\n", "line 1: vt: expected two finite numbers, got \"\""},
      {points + "vt 0 0\nf 1/1 2/2 3/1\n", "a texture coordinate from 1 to 1, got \"2/2\""},
      {points + "f 1 2 99999999999999999999\n", "got \"9999"}};
  for (const auto& [text, fault] : cases) EXPECT_THAT(obj_fault(text), HasSubstr(fault));
}

TEST(MeshFile, IsChosenByItsExtensionAndNeedsTriangles) {
  const std::filesystem::path folder = testing::TempDir();
  std::ofstream(folder / "a.PLY", std::ios::binary) << binary_ply(true);
  expect_the_plys_mesh(read_mesh(folder / "a.PLY"));
  std::ofstream(folder / "empty.obj") << "v 0 0 0\n";
  EXPECT_THAT(message_of<std::runtime_error>([&] { read_mesh(folder / "empty.obj"); }), HasSubstr("faces"));
  EXPECT_THAT(message_of<std::runtime_error>([&] { read_mesh(folder / "a.stl"); }), HasSubstr(".obj or .ply"));
  EXPECT_THAT(message_of<std::runtime_error>([&] { read_mesh(folder / "none.obj"); }), HasSubstr("no such file"));
}

}  // namespace
}  // namespace gicube::scene
