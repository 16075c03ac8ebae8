// gicube-smi show: where a file came from, of files that the programs wrote.
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "run_program.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::tools_test {
namespace {

using reference::TemporaryDirectory;

nlohmann::json shown(const std::string& file) {
  const Finished run = run_program("gicube-smi", {"show", "--json", file}, {});
  EXPECT_EQ(run.code, 0) << file << ": " << run.err;
  return nlohmann::json::parse(run.out, nullptr, false);
}

TEST(Show, ReadsPicturesAndStatisticsOfARender) {
  const TemporaryDirectory folder;
  for (const char* name : {"a.png", "a.exr"}) {
    const std::string picture = folder.file(name), statistics = folder.file("a.json");
    const Finished run = run_program("gicube-render",
                                     {"builtin:buckyball", "--volume-size", "24", "--size", "16x16", "--quiet",
                                      "--fidelity", "cycle", "-o", picture, "--stats", statistics},
                                     {});
    ASSERT_EQ(run.code, 0) << run.err;
    const auto from = shown(picture);
    EXPECT_EQ(from.at("program"), "gicube-render");
    EXPECT_EQ(from.at("fidelity"), "cycle");
    EXPECT_EQ(from.at("command"),
              "gicube-render builtin:buckyball --volume-size 24 --size 16x16 --quiet --fidelity cycle -o " + picture +
                  " --stats " + statistics);
    EXPECT_EQ(from.at("config_hash").get<std::string>().size(), 16u);
    EXPECT_EQ(from, shown(statistics));
  }
}

TEST(Show, ReadsVolumesOfAReconstruction) {
  const TemporaryDirectory folder;
  for (const char* name : {"a.nrrd", "a.nii", "a.nii.gz"}) {
    const Finished run = run_program("gicube-cone-beam",
                                     {"project", "builtin:sphere", "--detector", "8x8", "--views", "4", "--size",
                                      "8,8,8", "--quiet", "-o", folder.file("p.nrrd"), "--voxels", folder.file(name)},
                                     {});
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(shown(folder.file(name)).at("program"), "gicube-cone-beam") << name;
    EXPECT_THAT(shown(folder.file(name)).at("command").get<std::string>(), HasSubstr("project builtin:sphere"));
  }
}

TEST(Show, SaysWhenAFileDoesNotTell) {
  const TemporaryDirectory folder;
  std::ofstream(folder.file("other.nrrd")) << "NRRD0004\ntype: uint8\n\n";
  const Finished silent = run_program("gicube-smi", {"show", folder.file("other.nrrd")}, {});
  EXPECT_EQ(silent.code, 1);
  EXPECT_THAT(silent.err, HasSubstr("has no provenance"));
  std::ofstream(folder.file("text")) << "nothing";
  ASSERT_EQ(::mkfifo(folder.file("pipe").c_str(), 0600), 0);
  for (const std::string& name : {folder.file("pipe"), std::string("/dev/zero"), std::string("/tmp")}) {
    const Finished pipe = run_program("gicube-smi", {"show", name}, {});
    EXPECT_EQ(pipe.code, 2);
    EXPECT_THAT(pipe.err, HasSubstr("show: expected a file, got a folder, a pipe or a device, " + name));
  }
  const Finished unknown = run_program("gicube-smi", {"show", folder.file("text")}, {});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("expected a PNG, EXR, NRRD, NIfTI or JSON file"));
  EXPECT_EQ(run_program("gicube-smi", {"show", folder.file("none")}, {}).code, 2);
  // Cut anywhere, it is refused or says nothing, and never read beyond.
  const std::string png = "\x89PNG\r\n\x1a\n\xff\xff\xff\xfftEXtgicube.program";
  for (std::size_t length = 4; length <= png.size(); ++length) {
    std::ofstream(folder.file("cut.png"), std::ios::binary) << png.substr(0, length);
    EXPECT_EQ(run_program("gicube-smi", {"show", folder.file("cut.png")}, {}).code, 1) << length;
  }
}

}  // namespace
}  // namespace gicube::tools_test
