#include "gicube/scene/error.h"

#include "gicube/scene/scene.h"
#include "gicube/scene/volume_file.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::scene {
namespace {

// What `call` throws; a FileError is an InputError too.
template <typename Call>
InputError thrown_by(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {"", "", ""};
}

void write(const std::filesystem::path& path, const std::string& text) { std::ofstream(path) << text; }

TEST(SceneErrors, AFaultOfATextHasItsLine) {
  const InputError error = thrown_by([] { parse_scene("world {\n  size: 96\n  sise: 3\n}\n", "a.scene", "."); });
  EXPECT_EQ(error.file(), "a.scene");
  EXPECT_EQ(error.line(), 3);
  EXPECT_NE(error.got().find("sise"), std::string::npos) << error.got();
  EXPECT_TRUE(std::string(error.what()).starts_with("a.scene:3:")) << error.what();
}

TEST(SceneErrors, AllFaultsOfASceneComeAtOnceWithTheirFields) {
  const InputError error = thrown_by(
      [] { parse_scene("volume { builtin: \"buckyball\" } step: 20\ncamera { fov_degrees: 200 }\n", "b.scene", "."); });
  ASSERT_EQ(error.faults().size(), 2u) << error.what();
  const Fault& camera = error.faults()[0];
  EXPECT_EQ(camera.file, "b.scene");
  EXPECT_EQ(camera.field, "camera.fov_degrees");
  EXPECT_EQ(camera.expected, "more than 0 and less than 180");
  EXPECT_EQ(camera.got, "200");
  EXPECT_EQ(camera.text, "b.scene: camera.fov_degrees: expected more than 0 and less than 180, got 200");
  EXPECT_EQ(error.faults()[1].field, "step");
  EXPECT_EQ(error.what(), camera.text + "\n" + error.faults()[1].text);
}

TEST(SceneErrors, APartOfANodeIsNamedByItsWholePath) {
  const InputError error = thrown_by([] {
    parse_scene("world { node { name: \"ring\" material: \"m\" torus { tube: -1 } } } material { name: \"m\" }", "c",
                ".");
  });
  EXPECT_EQ(error.field(), "node[ring].torus.tube");
  EXPECT_EQ(error.got(), "-1");
}

TEST(SceneErrors, AFaultInAFileThatTheSceneNamesHasThatFileAndLine) {
  const reference::TemporaryDirectory folder;
  write(folder.file("haze.tf"), "colour 0 1 1 1\nopacity 0 2\n");
  const InputError error = thrown_by([&] {
    parse_scene("volume { builtin: \"buckyball\" } transfer_function { file: \"haze.tf\" }", "d.scene",
                std::filesystem::path(folder.file("")).parent_path());
  });
  EXPECT_EQ(error.file(), folder.file("haze.tf"));
  EXPECT_EQ(error.line(), 2);
  EXPECT_EQ(error.expected(), "a number from 0 to 1");
  EXPECT_EQ(error.got(), "\"2\"");
  EXPECT_TRUE(std::string(error.what()).starts_with("d.scene: transfer_function.file: ")) << error.what();
}

TEST(SceneErrors, PointsWithinASceneBelongToItsFile) {
  const InputError error = thrown_by([] {
    parse_scene(
        "volume { builtin: \"buckyball\" } transfer_function { colour { value: 0 colour {} } opacity { value: 1 "
        "opacity: 3 } }",
        "e.scene", ".");
  });
  EXPECT_EQ(error.file(), "e.scene");
  EXPECT_EQ(error.line(), 0);
}

TEST(SceneErrors, AMissingFileIsAFaultOfTheFile) {
  const InputError scene = thrown_by([] { read_scene("no/such.scene"); });
  EXPECT_EQ(scene.file(), "no/such.scene");
  EXPECT_EQ(scene.field(), "file");
  EXPECT_EQ(scene.got(), "no such file");
}

TEST(SceneErrors, ADamagedVolumeIsAFileErrorAndADriversError) {
  const reference::TemporaryDirectory folder;
  write(folder.file("short.nrrd"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\nabc");
  EXPECT_THROW(read_volume(folder.file("short.nrrd")), FileError);
  EXPECT_THROW(read_volume(folder.file("short.nrrd")), gicube::Error);
  const InputError error = thrown_by([&] { read_volume(folder.file("short.nrrd")); });
  EXPECT_EQ(error.file(), folder.file("short.nrrd"));
  EXPECT_NE(error.expected().find("64"), std::string::npos) << error.what();
}

}  // namespace
}  // namespace gicube::scene
