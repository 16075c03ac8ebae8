// Files that store one object in different orders of axes become one volume.
#include <nifti2_io.h>

#include "gicube/scene/scene.h"
#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

// StoredObject axis i runs along the world's axis |order[i]|, backwards if negative; all eight signs and all orders of
// axes.
std::vector<std::array<int, 3>> all_orders() {
  std::vector<std::array<int, 3>> all;
  for (const auto& order : {std::array{1, 2, 3}, {2, 3, 1}, {3, 1, 2}, {2, 1, 3}, {1, 3, 2}, {3, 2, 1}}) {
    for (int signs = 0; signs < 8; ++signs) {
      std::array<int, 3> axes = order;
      for (std::size_t i = 0; i < 3; ++i) axes[i] *= (signs >> i & 1) != 0 ? -1 : 1;
      all.push_back(axes);
    }
  }
  return all;
}

// The object in the world, to the left, to the back and up: 2 x 3 x 4 voxels of edges 1, 2, 3 from (10, 20, 30).
constexpr std::array<double, 3> kEdges{1, 2, 3}, kOrigin{10, 20, 30};

struct StoredObject {
  std::array<int, 3> dims{};
  std::array<std::array<double, 3>, 3> directions{};  // with the edges' lengths, of the stored axes
  std::array<double, 3> origin = kOrigin;
  std::vector<std::int16_t> samples;
};

StoredObject stored_as(const std::array<int, 3>& axes) {
  StoredObject out;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto world = static_cast<std::size_t>(std::abs(axes[i]) - 1);
    out.dims[i] = kRampDims[world];
    out.directions[i][world] = axes[i] > 0 ? kEdges[world] : -kEdges[world];
    if (axes[i] < 0) out.origin[world] += (kRampDims[world] - 1) * kEdges[world];
  }
  const std::vector<std::int16_t> object = ramp<std::int16_t>();
  std::array<int, 3> at{};
  for (at[2] = 0; at[2] < out.dims[2]; ++at[2]) {
    for (at[1] = 0; at[1] < out.dims[1]; ++at[1]) {
      for (at[0] = 0; at[0] < out.dims[0]; ++at[0]) {
        std::array<int, 3> world{};
        for (std::size_t i = 0; i < 3; ++i) {
          const auto axis = static_cast<std::size_t>(std::abs(axes[i]) - 1);
          world[axis] = axes[i] > 0 ? at[i] : out.dims[i] - 1 - at[i];
        }
        out.samples.push_back(object[static_cast<std::size_t>(world[0] + 2 * (world[1] + 3 * world[2]))]);
      }
    }
  }
  return out;
}

std::string nrrd_of(const StoredObject& file, const char* space = "left-posterior-superior", double left = 1,
                    double back = 1) {
  const auto vector = [&](const std::array<double, 3>& v) {
    return fmt::format("({},{},{})", left * v[0], back * v[1], v[2]);
  };
  return fmt::format(
             "NRRD0004\ntype: short\ndimension: 3\nspace: {}\nsizes: {}\nspace directions: {} {} {}\n"
             "space origin: {}\nendian: little\nencoding: raw\n\n",
             space, fmt::join(file.dims, " "), vector(file.directions[0]), vector(file.directions[1]),
             vector(file.directions[2]), vector(file.origin)) +
         stored(file.samples);
}

std::string meta_image_of(const StoredObject& file) {
  std::array<double, 3> spacing{};
  std::vector<double> matrix;
  for (std::size_t i = 0; i < 3; ++i) {
    for (const double part : file.directions[i]) spacing[i] += std::abs(part);
    for (const double part : file.directions[i]) matrix.push_back(part / spacing[i]);
  }
  return fmt::format(
             "ObjectType = Image\nNDims = 3\nTransformMatrix = {}\nOffset = {}\nElementSpacing = {}\nDimSize = {}\n"
             "ElementType = MET_SHORT\nElementDataFile = LOCAL\n",
             fmt::join(matrix, " "), fmt::join(file.origin, " "), fmt::join(spacing, " "), fmt::join(file.dims, " ")) +
         stored(file.samples);
}

// By sform, or by libnifti's own quaternion for the same.
std::string nifti_of(const StoredObject& file, bool sform) {
  nifti_1_header header{};
  header.sizeof_hdr = 348;
  header.dim[0] = 3;
  header.datatype = NIFTI_TYPE_INT16;
  header.vox_offset = 352;
  std::memcpy(header.magic, "n+1", 4);
  nifti_dmat44 matrix{};
  const std::array signs{-1.0, -1.0, 1.0};  // of the scanner's axes
  for (std::size_t i = 0; i < 3; ++i) {
    header.dim[i + 1] = static_cast<short>(file.dims[i]);
    for (std::size_t row = 0; row < 3; ++row) matrix.m[row][i] = signs[row] * file.directions[i][row];
    matrix.m[i][3] = signs[i] * file.origin[i];
  }
  double b = 0, c = 0, d = 0, x = 0, y = 0, z = 0, dx = 0, dy = 0, dz = 0, qfac = 0;
  nifti_dmat44_to_quatern(matrix, &b, &c, &d, &x, &y, &z, &dx, &dy, &dz, &qfac);
  header.pixdim[0] = static_cast<float>(qfac);
  header.pixdim[1] = static_cast<float>(dx);
  header.pixdim[2] = static_cast<float>(dy);
  header.pixdim[3] = static_cast<float>(dz);
  if (sform) {
    header.sform_code = 1;
    for (std::size_t i = 0; i < 4; ++i) {
      header.srow_x[i] = static_cast<float>(matrix.m[0][i]);
      header.srow_y[i] = static_cast<float>(matrix.m[1][i]);
      header.srow_z[i] = static_cast<float>(matrix.m[2][i]);
    }
  } else {
    header.qform_code = 1;
    header.quatern_b = static_cast<float>(b);
    header.quatern_c = static_cast<float>(c);
    header.quatern_d = static_cast<float>(d);
    header.qoffset_x = static_cast<float>(x);
    header.qoffset_y = static_cast<float>(y);
    header.qoffset_z = static_cast<float>(z);
  }
  return std::string(reinterpret_cast<const char*>(&header), sizeof header) + std::string(4, '\0') +
         stored(file.samples);
}

void expect_object(const std::filesystem::path& file) {
  VolumeSource source;
  source.file = file;
  const Volume volume = read_volume(source), opened = open_volume(source);
  EXPECT_EQ(volume.dims, kRampDims);
  EXPECT_EQ(samples_of<std::int16_t>(volume), ramp<std::int16_t>());
  EXPECT_EQ(opened.planes ? bytes_in_planes(opened, 3) : opened.samples, volume.samples);
  const std::array near{volume.spacing - Vec3{1, 2, 3}, volume.placement.origin - Vec3{10, 20, 30},
                        volume.placement.directions[0] - Vec3{1, 0, 0}, volume.placement.directions[1] - Vec3{0, 1, 0},
                        volume.placement.directions[2] - Vec3{0, 0, 1}};
  for (const Vec3& difference : near) EXPECT_LT(length(difference), 1e-5);
  EXPECT_EQ(volume.placement.axes, WorldAxes::kPatient);
  EXPECT_LT(oblique_degrees(volume.placement), 0.05);  // a float's cosine
}

TEST(Orientation, EveryStorageOrderOfEveryFormatIsOneVolume) {
  const TemporaryFolder folder;
  const Warnings warnings;
  for (const auto& axes : all_orders()) {
    SCOPED_TRACE(fmt::format("{}", fmt::join(axes, " ")));
    const StoredObject file = stored_as(axes);
    expect_object(folder.write("a.nrrd", nrrd_of(file)));
    expect_object(folder.write("b.nrrd", nrrd_of(file, "RAS", -1, -1)));
    expect_object(folder.write("c.nrrd", nrrd_of(file, "left-anterior-superior", 1, -1)));
    expect_object(folder.write("a.mha", meta_image_of(file)));
    expect_object(folder.write("a.nii", nifti_of(file, true)));
    expect_object(folder.write("b.nii", nifti_of(file, false)));
  }
  EXPECT_THAT(warnings.texts, IsEmpty());
}

TEST(Orientation, StaysAsStoredWhereThatIsAskedFor) {
  const TemporaryFolder folder;
  const StoredObject file = stored_as({-3, 1, -2});
  VolumeSource source;
  source.file = folder.write("a.nrrd", nrrd_of(file));
  EXPECT_THAT(read_volume(source).placement.stored, ElementsAre(2, -3, -1));
  source.as_stored = true;
  const Volume volume = read_volume(source);
  EXPECT_EQ(volume.dims, file.dims);
  EXPECT_EQ(samples_of<std::int16_t>(volume), file.samples);
  EXPECT_EQ(volume.spacing, (Vec3{3, 1, 2}));
}

TEST(Orientation, SaysWhatIsObliqueAndRefusesAFlatSpace) {
  const TemporaryFolder folder;
  const Warnings warnings;
  StoredObject file = stored_as({1, 2, 3});
  file.directions = {{{std::cos(0.2), std::sin(0.2), 0}, {-2 * std::sin(0.2), 2 * std::cos(0.2), 0}, {0, 0, 3}}};
  const Volume volume = read_volume(folder.write("a.nrrd", nrrd_of(file)));
  EXPECT_NEAR(oblique_degrees(volume.placement), 0.2 * 180 / 3.14159265, 1e-6);
  EXPECT_THAT(warnings.texts,
              ElementsAre(HasSubstr("orientation: expected axes along the patient's, got 11.5 degrees off")));
  file.directions[1] = file.directions[0];
  EXPECT_THAT(read_error(folder.write("b.nrrd", nrrd_of(file))), HasSubstr("three directions that span space"));
}

TEST(Orientation, NamedViewsAreThoseOfThePatientOrOfTheFile) {
  const auto eye = [](const char* name, WorldAxes axes, Vec3& up) {
    CameraSettings camera;
    camera.from = name;
    View view;
    fit_camera(camera, {{0, 0, 0}, {10, 10, 10}}, {1, 1, 1}, view, axes);
    up = view.up;
    return normalise(view.eye - view.look_at);
  };
  Vec3 up;
  EXPECT_EQ(eye("front", WorldAxes::kPatient, up), (Vec3{0, -1, 0}));
  EXPECT_EQ(up, (Vec3{0, 0, 1}));
  EXPECT_EQ(eye("left", WorldAxes::kPatient, up), (Vec3{1, 0, 0}));
  EXPECT_EQ(eye("left", WorldAxes::kNone, up), (Vec3{-1, 0, 0}));
  EXPECT_EQ(eye("superior", WorldAxes::kPatient, up), (Vec3{0, 0, 1}));
  EXPECT_EQ(up, (Vec3{0, -1, 0}));
  EXPECT_EQ(eye("top", WorldAxes::kWorld, up), (Vec3{0, 0, 1}));
  EXPECT_EQ(up, (Vec3{0, 1, 0}));
  EXPECT_THROW(eye("superior", WorldAxes::kWorld, up), InputError);
  EXPECT_THROW(eye("nowhere", WorldAxes::kPatient, up), InputError);
}

TEST(Orientation, IsWrittenAndReadBack) {
  const TemporaryFolder folder;
  std::vector<float> values;
  for (int i = 0; i < 24; ++i) values.push_back(static_cast<float>(i));
  const double c = std::cos(0.3), s = std::sin(0.3);
  FloatVolume volume{{2, 3, 4}, {0.5, 0.25, 2}, {-1.5, 2, 7}, values};
  volume.axes = WorldAxes::kPatient;
  volume.directions = {{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}};
  for (const char* name : {"a.nrrd", "a.mhd", "a.nii"}) {
    const auto file = folder.write(name, "");
    write_volume(volume, file);
    const Volume back = read_volume(file);
    EXPECT_EQ(values_of(back), values) << name;
    EXPECT_LT(length(back.placement.origin - volume.origin), 1e-5) << name;
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LT(length(back.placement.directions[i] - volume.directions[i]), 1e-6) << name;
    EXPECT_EQ(back.placement.axes, WorldAxes::kPatient) << name;
  }
}

std::string short_nrrd(const std::string& fields, const std::string& data) {
  return "NRRD0004\ntype: uchar\nendian: little\n" + fields + "\n" + data;
}

TEST(Parts, AreChosenByNumber) {
  const TemporaryFolder folder;
  const std::string bytes = "abcdefghijklmnop";
  VolumeSource source;
  const auto read = [&](const char* part) {
    source.part = part;
    const Volume volume = read_volume(source);
    return std::string(reinterpret_cast<const char*>(volume.samples.data()), volume.samples.size());
  };
  const Warnings warnings;
  source.file = folder.write("time.nrrd", short_nrrd("dimension: 4\nsizes: 2 2 2 2\nencoding: raw\n", bytes));
  EXPECT_EQ(read(""), "abcdefgh");
  EXPECT_THAT(warnings.texts, ElementsAre(HasSubstr("volume: expected a part, 1..2, got none; 1 is taken")));
  EXPECT_EQ(read("2"), "ijklmnop");
  EXPECT_THROW(read("3"), FileError);
  source.file = folder.write(
      "vector.nrrd",
      short_nrrd("dimension: 4\nsizes: 2 2 2 2\nkinds: vector domain domain domain\nencoding: raw\n", bytes));
  EXPECT_EQ(read("2"), "bdfhjlnp");
  EXPECT_THROW(read(""), FileError);
  source.file = folder.write(
      "rgb.nrrd", short_nrrd("dimension: 4\nsizes: 3 2 2 1\nkinds: RGB-color domain domain domain\nencoding: raw\n",
                             bytes.substr(0, 12)));
  source.part.clear();
  const Volume rgb = read_volume(source);
  EXPECT_EQ(rgb.dims, (Dims{2, 2, 1}));
  EXPECT_THAT(rgb.colours, SizeIs(12));
  EXPECT_EQ(rgb.colours[5], 'f');
  source.file =
      folder.write("v.mha", "NDims = 4\nDimSize = 2 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + bytes);
  EXPECT_EQ(read("2"), "ijklmnop");
}

TEST(Parts, SlicesInFilesOfTheirOwn) {
  const TemporaryFolder folder;
  for (const char* name : {"s1.raw", "s2.raw", "s3.raw"}) folder.write(name, std::string(4, name[1]));
  const std::string fields = "dimension: 3\nsizes: 2 2 3\nencoding: raw\n";
  for (const auto& file :
       {folder.write("l.nhdr", "NRRD0004\ntype: uchar\n" + fields + "data file: LIST\ns1.raw\ns2.raw\ns3.raw\n"),
        folder.write("p.nhdr", "NRRD0004\ntype: uchar\n" + fields + "data file: s%d.raw 1 3 1\n"),
        folder.write(
            "l.mhd",
            "NDims = 3\nDimSize = 2 2 3\nElementType = MET_UCHAR\nElementDataFile = LIST\ns1.raw\ns2.raw\ns3.raw\n"),
        folder.write("p.mhd",
                     "NDims = 3\nDimSize = 2 2 3\nElementType = MET_UCHAR\nElementDataFile = s%01d.raw 1 3 1\n")}) {
    const auto samples = samples_of<char>(read_volume(file));
    EXPECT_EQ(std::string(samples.begin(), samples.end()), "111122223333") << file;
  }
  EXPECT_THAT(read_error(folder.write("g.nhdr", "NRRD0004\ntype: uchar\n" + fields + "data file: s%d.raw 1 4 1\n")),
              HasSubstr("s4.raw"));
  for (const char* bad :
       {"s%s.raw 1 3 1", "s%d%d.raw 1 3 1", "s%99999d.raw 1 3 1", "s%d.raw 1 3 0", "s%d.raw 1 99999 1"})
    EXPECT_THAT(read_error(folder.write("b.nhdr", "NRRD0004\ntype: uchar\n" + fields + "data file: " + bad + "\n")),
                HasSubstr("data file"))
        << bad;
}

TEST(Parts, NotANumberStandsForWhatIsAskedFor) {
  const TemporaryFolder folder;
  std::vector<float> values = ramp<float>();
  values[3] = std::nanf("");
  values[7] = INFINITY;
  VolumeSource source;
  source.file = folder.path() / "a.nrrd";
  write_volume({{2, 3, 4}, {1, 1, 1}, {}, values}, source.file);
  source.nan = -5;
  const std::vector<float> read = values_of(read_volume(source));
  EXPECT_EQ(read[3], -5);
  EXPECT_EQ(read[7], -5);
  EXPECT_EQ(read[8], values[8]);
}

}  // namespace
}  // namespace gicube::scene
