// The program itself, with a private emulated board.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "gicube/scene/volume_file.h"
#include "program_test.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kSmallScan =
    " --detector 48x40 --pitch 5 --views 24 --radius 50 --size 32,32,32 --spacing 4 --value 0.02 ";

class ConeBeamProgram : public ProgramTest {
 protected:
  ConeBeamProgram() : ProgramTest("gicube-cone-beam") {}

  void expect_done(const std::string& arguments) const {
    const ProgramResult result = run(arguments);
    ASSERT_EQ(result.code, 0) << arguments << "\n" << result.err;
    EXPECT_THAT(result.err, IsEmpty()) << arguments;
  }
  std::vector<float> values_in(const std::string& name) const { return values_of(read_volume(path(name))); }
};

double greatest_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double most = a.size() == b.size() ? 0 : 1e9;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    most = std::max(most, std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
  }
  return most;
}

TEST_F(ConeBeamProgram, PlansForAnErrorAndExplainsItself) {
  expect_done("project builtin:sphere" + std::string(kSmallScan) + "-o " + path("p.nrrd"));
  const ProgramResult result = run("reconstruct " + path("p.textproto") + " -o " + path("v.nrrd") +
                                   " --max-error 30% --explain --stats " + path("v.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, testing::AllOf(HasSubstr("plan for an error of at most 30%"), HasSubstr("views: "),
                                         HasSubstr("error: "), HasSubstr("cost: "), HasSubstr("the plan itself")));
  const auto json = nlohmann::json::parse(text_of(path("v.json")));
  const auto &plan = json.at("plan"), &chosen = plan.at("chosen");
  EXPECT_TRUE(plan.at("kept").get<bool>());
  EXPECT_LE(chosen.at("error_bound").get<double>(), 0.3);
  const int rays = chosen.at("rays").get<int>();
  EXPECT_EQ(json.at("settings").at("rays").get<std::vector<int>>(), (std::vector{rays, rays}));
  EXPECT_EQ(json.at("settings").at("step"), chosen.at("step"));
  EXPECT_NEAR(json.at("deposits").get<double>(), chosen.at("deposits").get<double>(),
              0.1 * chosen.at("deposits").get<double>());
  EXPECT_GT(plan.at("finest").at("deposits").get<double>(), 3 * chosen.at("deposits").get<double>());
}

TEST_F(ConeBeamProgram, KeepsATimeBudgetOnABoardThatKeepsTime) {
  expect_done(
      "project builtin:sphere --detector 24x20 --pitch 10 --views 16 --radius 50 --size 16,16,16 --spacing 8 -o " +
      path("p.nrrd"));
  const ProgramResult result = run("reconstruct " + path("p.textproto") + " -o " + path("v.nrrd") +
                                   " --time-budget 25ms --stats " + path("v.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  const auto json = nlohmann::json::parse(text_of(path("v.json")));
  EXPECT_EQ(json.at("board").at("fidelity"), "cycle");
  EXPECT_TRUE(json.at("plan").at("kept").get<bool>());
  EXPECT_LE(json.at("board_ms").get<double>(), 25);
  // The plan has made this very volume to see what it takes.
  const double taken = json.at("rays_ms").get<double>();
  EXPECT_NEAR(json.at("plan").at("chosen").at("board_ms").get<double>(), taken, 0.01 * taken);
  EXPECT_EQ(json.at("plan").at("chosen").at("deposits").get<double>(), json.at("deposits").get<double>());
  EXPECT_GT(json.at("plan").at("finest").at("board_ms").get<double>(), 25);
}

TEST_F(ConeBeamProgram, RefusesPlansThatContradictOtherOptions) {
  const std::string begin = "reconstruct x.textproto -o " + path("v.nrrd");
  for (const char* wrong :
       {" --max-error 1% --time-budget 5ms", " --explain", " --max-error 1% --step 1", " --max-error 1% --rays 2",
        " --time-budget 5ms --rays 1", " --max-error 1% --method sart"}) {
    EXPECT_EQ(run(begin + wrong).code, 2) << wrong;
  }
}

TEST_F(ConeBeamProgram, ReconstructsWhatItProjected) {
  expect_done("project builtin:sphere" + std::string(kSmallScan) + "-o " + path("p.nrrd") + " --voxels " +
              path("t.nrrd"));
  const ProgramResult result = run("reconstruct " + path("p.textproto") + " -o " + path("v.nrrd") + " --slices " +
                                   path("s") + " --stats " + path("v.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("32 x 32 x 32 voxels from 24 views by fdk"));
  const Volume volume = read_volume(path("v.nrrd"));
  EXPECT_EQ(volume.dims, (Dims{32, 32, 32}));
  EXPECT_EQ(volume.spacing.z, 4);
  EXPECT_THAT(text_of(path("v.nrrd")), HasSubstr("space origin: (-62,-62,-62)"));
  EXPECT_NEAR(values_of(volume)[16 * 32 * 32 + 16 * 32 + 16], 0.02, 0.002);
  for (const char* picture : {"s_x.png", "s_y.png", "s_z.png"}) EXPECT_TRUE(std::filesystem::exists(path(picture)));
  const auto json = nlohmann::json::parse(text_of(path("v.json")));
  EXPECT_EQ(json.at("method"), "fdk");
  EXPECT_EQ(json.at("scan").at("views"), 24);
  EXPECT_EQ(json.at("overflowed"), 0);
  EXPECT_GT(json.at("deposits").get<double>(), 1e5);
  EXPECT_GT(json.at("rays_ms").get<double>(), 0);
  EXPECT_LT(json.at("rays_ms").get<double>(), json.at("board_ms").get<double>());  // which has the empty volume too
  EXPECT_GT(json.at("board_ms").get<double>(), 0);
  EXPECT_GT(json.at("bus_down_bytes").get<double>(), 0);
  EXPECT_EQ(json.at("settings").at("window"), "ram-lak");

  expect_done("compare " + path("v.nrrd") + " " + path("t.nrrd") + " --stats " + path("c.json") + " --profiles " +
              path("c.csv") + " --difference " + path("d.mha") + " --slices " + path("d") + " --field-height 30");
  const auto found = nlohmann::json::parse(text_of(path("c.json")));
  EXPECT_LT(found.at("relative_l2").get<double>(), 0.4);
  EXPECT_LT(std::abs(found.at("bias").get<double>()), 0.001);
  EXPECT_GT(found.at("ssim").get<double>(), 0.3);
  EXPECT_THAT(text_of(path("c.csv")), HasSubstr("axis,position,value,truth\nx,-62,"));
  const auto truth = values_in("t.nrrd"), difference = values_in("d.mha");
  EXPECT_FLOAT_EQ(difference[500], values_of(volume)[500] - truth[500]);
  // The closed form says the same as its voxels.
  expect_done("compare " + path("t.nrrd") + " builtin:sphere --radius 50 --value 0.02 --stats " + path("e.json"));
  EXPECT_EQ(nlohmann::json::parse(text_of(path("e.json"))).at("rmse"), 0);
}

TEST_F(ConeBeamProgram, SeesTheSameVolumeWhateverTheFormat) {
  const std::string object = "project builtin:shepp-logan-high-contrast" + std::string(kSmallScan) + "-o ";
  std::filesystem::create_directory(path("pfm"));
  for (const char* name : {"a.nrrd", "b.mhd", "c.mha", "d.raw", "e.tif", "pfm/f.pfm"}) expect_done(object + path(name));
  expect_done("reconstruct " + path("a.textproto") + " -o " + path("a_v.nrrd"));
  const std::vector<float> wanted = values_in("a_v.nrrd");
  EXPECT_GT(*std::ranges::max_element(wanted), 0.01F);
  for (const char* name : {"b", "c", "d", "e", "pfm/f"}) {
    const std::string ending = name == std::string("b")   ? "_v.mhd"
                               : name == std::string("c") ? "_v.mha"
                               : name == std::string("d") ? "_v.nii"
                                                          : "_v.nii.gz";
    expect_done("reconstruct " + path(std::string(name) + ".textproto") + " -o " + path(name + ending));
    EXPECT_EQ(values_in(name + ending), wanted) << name;
  }
  // And with the projection matrices beside the images in place of the scan file: digits of the text apart.
  expect_done("reconstruct " + path("pfm") + " -o " + path("g.nrrd") + " --size 32,32,32 --spacing 4");
  EXPECT_LT(greatest_difference(values_in("g.nrrd"), wanted), 2e-6);
  expect_done("reconstruct " + path("pfm") + " --projections " + path("a.nrrd") + " -o " + path("h.nrrd") +
              " --size 32,32,32 --spacing 4");
  EXPECT_GT(greatest_difference(values_in("h.nrrd"), wanted), 0.001);  // that stack's rows run the other way
}

TEST_F(ConeBeamProgram, SendsSoManyRaysThatNoVoxelIsLeftOut) {
  expect_done("project builtin:sphere" + std::string(kSmallScan) + "-o " + path("p.nrrd"));
  const auto rays = [&](const std::string& volume) {
    const ProgramResult result =
        run("reconstruct " + path("p.textproto") + volume + " -o " + path("v.nrrd") + " --stats " + path("v.json"));
    EXPECT_EQ(result.code, 0) << result.err;
    const bool few = volume.find("0.4") != std::string::npos;
    EXPECT_THAT(result.err, few ? testing::Matcher<std::string>(
                                      HasSubstr("volume: pixels at the axis are 6.2 times as large as voxels"))
                                : testing::Matcher<std::string>(IsEmpty()));
    return nlohmann::json::parse(text_of(path("v.json"))).at("settings").at("rays").get<std::vector<int>>();
  };
  // Pixels are 2.5 at the axis.
  EXPECT_EQ(rays(" --size 24,24,24 --spacing 4"), (std::vector{1, 1}));
  EXPECT_EQ(rays(" --size 24,24,24 --spacing 3"), (std::vector{1, 2}));
  EXPECT_EQ(rays(" --size 24,24,24 --spacing 1.5"), (std::vector{2, 2}));
  EXPECT_EQ(rays(" --size 24,24,24 --spacing 0.4"), (std::vector{4, 4}));
  EXPECT_EQ(rays(" --size 24,24,24 --spacing 1.5 --rays 1"), (std::vector{1, 1}));
}

TEST_F(ConeBeamProgram, ImportsAScanAsAScanFile) {
  std::filesystem::create_directory(path("pfm"));
  expect_done("project builtin:sphere" + std::string(kSmallScan) + "-o " + path("pfm/f.pfm"));
  expect_done("import " + path("pfm") + " -o " + path("pfm/g.textproto"));
  EXPECT_THAT(text_of(path("pfm/g.textproto")), HasSubstr("rows_reversed: true"));
  EXPECT_THAT(text_of(path("pfm/g.textproto")), HasSubstr("file: \"f_0000.pfm\""));
  expect_done("reconstruct " + path("pfm") + " -o " + path("a.nrrd"));
  expect_done("reconstruct " + path("pfm/g.textproto") + " -o " + path("b.nrrd"));
  EXPECT_LT(greatest_difference(values_in("a.nrrd"), values_in("b.nrrd")), 1e-7);
}

TEST_F(ConeBeamProgram, ProjectsAVolumeByTheBoardAsTheClosedFormDoes) {
  expect_done("project builtin:sphere" + std::string(kSmallScan) + "-o " + path("a.nrrd") + " --voxels " +
              path("t.mha"));
  expect_done("project " + path("t.mha") + std::string(kSmallScan) + "-o " + path("b.nrrd") + " --stats " +
              path("b.json"));
  const std::vector<float> closed = values_in("a.nrrd"), board = values_in("b.nrrd");
  ASSERT_EQ(closed.size(), board.size());
  double error = 0, sum = 0;
  for (std::size_t i = 0; i < closed.size(); ++i) {
    error += std::pow(static_cast<double>(closed[i] - board[i]), 2);
    sum += std::pow(static_cast<double>(closed[i]), 2);
  }
  EXPECT_LT(std::sqrt(error / sum), 0.06);
  EXPECT_GT(nlohmann::json::parse(text_of(path("b.json"))).at("board_ms").get<double>(), 0);
}

TEST_F(ConeBeamProgram, MultipliesAHeadsValues) {
  const std::string scan = " --detector 24x20 --pitch 10 --views 12 --radius 50 ";
  expect_done("project builtin:shepp-logan" + scan + "-o " + path("one.nrrd"));
  expect_done("project builtin:shepp-logan" + scan + "--value 0.02 -o " + path("water.nrrd"));
  std::vector<float> expected = values_in("one.nrrd");
  ASSERT_GT(*std::max_element(expected.begin(), expected.end()), 1);
  for (float& value : expected) value *= 0.02F;
  EXPECT_LT(greatest_difference(values_in("water.nrrd"), expected), 1e-5);
}

TEST_F(ConeBeamProgram, MakesTheSameNoiseForTheSameSeed) {
  const std::string noisy = "project builtin:sphere" + std::string(kSmallScan) + "--photons 1000 --seed ";
  expect_done(noisy + "1 -o " + path("a.nrrd"));
  expect_done(noisy + "1 -o " + path("b.nrrd"));
  expect_done(noisy + "2 -o " + path("c.nrrd"));
  EXPECT_EQ(values_in("a.nrrd"), values_in("b.nrrd"));
  EXPECT_NE(values_in("a.nrrd"), values_in("c.nrrd"));
}

TEST_F(ConeBeamProgram, ReconstructsAlgebraicallyAndSaysWhenItDiverges) {
  expect_done("project builtin:sphere" + std::string(kSmallScan) + "-o " + path("p.nrrd"));
  for (const char* method : {"sart", "os-sart --subsets 6", "sirt"}) {
    const ProgramResult result = run("reconstruct " + path("p.textproto") + " --iterations 3 -o " + path("v.nrrd") +
                                     " --stats " + path("v.json") + " --method " + method);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("3 iterations, residual"));
    const auto json = nlohmann::json::parse(text_of(path("v.json")));
    EXPECT_EQ(json.at("residuals").size(), 3u);
    EXPECT_FALSE(json.at("diverged"));
  }
  const ProgramResult wild =
      run("reconstruct " + path("p.textproto") + " --method sart --relaxation 6 --allow-negative -o " + path("w.nrrd") +
          " --stats " + path("w.json"));
  ASSERT_EQ(wild.code, 0) << wild.err;
  EXPECT_THAT(wild.err, HasSubstr("warning: --relaxation 6: diverged"));
  EXPECT_TRUE(nlohmann::json::parse(text_of(path("w.json"))).at("diverged"));
}

// A sphere of 0.02 in counts of at most 60,000, and what a column without light, or a forgotten flag, makes of it.
TEST_F(ConeBeamProgram, FillsADeadColumnAndNamesAForgottenFlag) {
  expect_done("project builtin:sphere" + std::string(kSmallScan) + "-o " + path("p.nrrd"));
  const std::vector<float> integrals = values_in("p.nrrd");
  std::ofstream counts(path("counts.raw"), std::ios::binary);
  for (std::size_t i = 0; i < integrals.size(); ++i) {
    const double count = i % 48 == 24 ? 0 : std::round(60'000 * std::exp(-static_cast<double>(integrals[i])));
    const auto word = static_cast<std::uint16_t>(count);
    counts.put(static_cast<char>(word & 255)).put(static_cast<char>(word >> 8));
  }
  counts.close();
  const std::string scan =
      "source_to_axis: 500 source_to_detector: 1000 detector { columns: 48 rows: 40 pitch_u: 5 }\n"
      "even_angles { count: 24 } volume { size: 32 size: 32 size: 32 spacing: 4 }\n"
      "projections { file: \"counts.raw\" type: \"uint16\" }\n";
  std::ofstream(path("good.textproto")) << scan + "intensities: true full_intensity: 60000";
  std::ofstream(path("bad.textproto")) << scan;
  const ProgramResult good =
      run("reconstruct " + path("good.textproto") + " -o " + path("v.nrrd") + " --stats " + path("v.json"));
  ASSERT_EQ(good.code, 0) << good.err;
  EXPECT_THAT(good.err, HasSubstr("warning: projections: 40 pixels have no light in any view"));
  EXPECT_EQ(nlohmann::json::parse(text_of(path("v.json"))).at("scan").at("unlit"), 40);
  const std::vector<float> values = values_in("v.nrrd");
  double sum = 0;
  for (std::size_t y = 14; y < 18; ++y) {
    for (std::size_t x = 14; x < 18; ++x) sum += static_cast<double>(values[(16 * 32 + y) * 32 + x]);
  }
  EXPECT_NEAR(sum / 16, 0.02, 0.0006);
  const ProgramResult bad = run("reconstruct " + path("bad.textproto") + " -o " + path("v.nrrd"));
  EXPECT_THAT(bad.err, testing::AllOf(HasSubstr("like intensities"), testing::Not(HasSubstr("reaches beyond"))));
}

// A helix of vectors as ASTRA has them, through the program and its formats.
TEST_F(ConeBeamProgram, TakesAnyOrbit) {
  std::ofstream vectors(path("helix.txt"));
  for (int i = 0; i < 24; ++i) {
    const double angle = i * 0.7, c = std::cos(angle), s = std::sin(angle), z = 3.0 * i - 34.5;
    vectors << 500 * c << ' ' << 500 * s << ' ' << z << ' ' << -500 * c << ' ' << -500 * s << ' ' << z << ' ' << -5 * s
            << ' ' << 5 * c << " 0 0 0 5\n";
  }
  vectors.close();
  expect_done("project builtin:sphere --radius 40 --scan " + path("helix.txt") +
              " --detector 48x40 --size 24,24,24 --spacing 4 -o " + path("p.nrrd"));
  EXPECT_THAT(text_of(path("p.textproto")), HasSubstr("view {"));
  const std::string scan = path("p.textproto");
  for (const char* method :
       {"cgls --iterations 4", "osem --subsets 4 --iterations 2", "tv --subsets 4 --iterations 3"}) {
    expect_done("reconstruct " + scan + " --method " + method + " -o " + path("v.nrrd") + " --stats " + path("v.json") +
                " --quiet");
    const std::vector<float> values = values_in("v.nrrd");
    EXPECT_NEAR(values[(12 * 24 + 12) * 24 + 12], 1, 0.25) << method;
    const auto json = nlohmann::json::parse(text_of(path("v.json")));
    EXPECT_FALSE(json.at("scan").at("circular").get<bool>());
    EXPECT_GE(json.at("residuals").size(), 2u);
  }
  const ProgramResult fdk = run("reconstruct " + scan + " -o " + path("w.nrrd"));
  EXPECT_EQ(fdk.code, 1);
  EXPECT_THAT(fdk.err, HasSubstr("poses[0].source: expected a place on the circle"));
  // As RTK and ASTRA have it, it is the same scan.
  for (const char* name : {"h.xml", "h.txt"}) {
    expect_done("import " + scan + " -o " + path(name));
    expect_done("project builtin:sphere --radius 40 --scan " + path(name) +
                " --detector 48x40 --pitch 5 --size 24,24,24" + " --spacing 4 -o " + path("q.nrrd"));
    EXPECT_LT(greatest_difference(values_in("q.nrrd"), values_in("p.nrrd")), 0.01) << name;  // of 80
  }
  EXPECT_EQ(run("project builtin:sphere --scan " + scan + " -o " + path("m.pfm")).code, 2);
}

TEST_F(ConeBeamProgram, FindsTheAxisAndKeepsToAMask) {
  expect_done(
      "project builtin:shepp-logan --detector 48x40 --pitch 5 --views 90 --radius 50 --size 32,32,32 --spacing 4 -o " +
      path("p.nrrd") + " --voxels " + path("t.nrrd"));
  std::string text = text_of(path("p.textproto"));
  text.replace(text.find("pitch_v: 5"), 10, "pitch_v: 5 offset_u: 6");
  std::ofstream(path("off.textproto")) << text;
  const ProgramResult found =
      run("reconstruct " + path("off.textproto") + " --find-centre --method sirt --iterations 2" + " --mask " +
          path("t.nrrd") + " -o " + path("v.nrrd") + " --stats " + path("v.json"));
  ASSERT_EQ(found.code, 0) << found.err;
  EXPECT_THAT(found.out, HasSubstr("pixels from the detector's middle"));
  const auto json = nlohmann::json::parse(text_of(path("v.json")));
  EXPECT_NEAR(json.at("scan").at("detector").at("offset_u").get<double>(), 0, 0.5);
  EXPECT_TRUE(json.at("settings").at("masked").get<bool>());
  const std::vector<float> values = values_in("v.nrrd"), mask = values_in("t.nrrd");
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) {
      ASSERT_EQ(values[i], 0);
    }
  }
}

// Names that are derived from --output are held against all that the scan is read from.
TEST_F(ConeBeamProgram, ReplacesNoFileOfTheUsersByANameThatItDerives) {
  const auto expect_kept = [&](const std::string& arguments, const std::string& file) {
    const std::string before = text_of(path(file));
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_THAT(result.err, HasSubstr("expected a name whose files are not read, got one that would replace")) << file;
    EXPECT_EQ(text_of(path(file)), before) << arguments;
  };
  std::ofstream(path("scan.textproto")) << "# my notes\nsource_to_axis: 500 source_to_detector: 1000\n"
                                           "detector { columns: 16 rows: 4 pitch_u: 8 } even_angles { count: 4 }\n"
                                           "projections { file: \"views.raw\" type: \"float32\" }\n";
  std::ofstream(path("views.raw")) << std::string(16 * 4 * 4 * 4, '\0');
  const std::string project = "project builtin:sphere --scan " + path("scan.textproto") + " -o ";
  expect_kept(project + path("scan.nrrd"), "scan.textproto");
  expect_kept(project + path("views.mhd"), "views.raw");
  expect_kept("reconstruct " + path("scan.textproto") + " -o " + path("views.mhd"), "views.raw");
  std::filesystem::create_directory(path("matrices"));
  expect_done("project builtin:sphere --radius 3 --views 4 --detector 16x4 -o " + path("matrices/m.pfm"));
  expect_kept("project builtin:sphere --scan " + path("matrices") + " -o " + path("matrices/m.pfm"),
              "matrices/m_0000.txt");
  expect_done(project + path("other.nrrd"));
  expect_done("reconstruct " + path("matrices") + " -o " + path("matrices/v.nrrd") + " --size 4,4,4");
  expect_done("reconstruct " + path("matrices") + " -o " + path("matrices/v.nrrd") + " --size 4,4,4");
}

TEST_F(ConeBeamProgram, FailsWithOneLineThatNamesWhatIsWrong) {
  const auto expect = [&](const std::string& arguments, int code, const std::string& text) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, code) << arguments;
    EXPECT_THAT(result.err, HasSubstr(text)) << arguments;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  };
  expect("reconstruct /nowhere/a.textproto -o " + path("a.nrrd"), 1, "/nowhere/a.textproto: expected a scan file");
  expect("reconstruct /nowhere/a.json -o " + path("a.nrrd"), 1, "/nowhere/a.json");
  expect("reconstruct a.json -o /nowhere/a.nrrd", 1, "/nowhere/a.nrrd: expected a folder that is there");
  expect("reconstruct a.json -o a.xyz", 2, "--output: expected a name that ends in .nrrd");
  expect("project builtin:sphere -o a.xyz", 2, "--output: expected a name that ends in .nrrd");
  expect("project builtin:ball -o " + path("a.nrrd"), 1, "phantom: expected builtin:shepp-logan");
  expect("project builtin:sphere --source-to-axis 20 --size 64,64,64 --spacing 4 -o " + path("a.nrrd"), 1,
         "source_to_axis: expected");
  expect("reconstruct a.json --method art -o a.nrrd", 2, "--method");
  expect("reconstruct a.json --slice w=1 -o a.nrrd", 2, "--slice: expected x, y or z");
  expect("reconstruct a.json --type uint8 -o a.nrrd", 2, "--type: only with --projections");
  expect("compare /nowhere/a.nrrd builtin:sphere", 1, "/nowhere/a.nrrd");
  expect("", 2, "subcommand");
  expect_done("project builtin:sphere" + std::string(kSmallScan) + "-o " + path("p.nrrd"));
  expect("reconstruct " + path("p.textproto") + " --size 4096,64,64 --spacing 0.05 -o " + path("a.nrrd"), 1,
         "--size: expected at most");
  expect("reconstruct " + path("p.textproto") + " --board unix:/nowhere/socket -o " + path("a.nrrd"), 1,
         "/nowhere/socket");
  expect("reconstruct " + path("p.textproto") + " --slices " + path("s") + " --slice z=99 -o " + path("a.nrrd"), 1,
         "--slice z: expected 0 to 31, got 99");
}

}  // namespace
}  // namespace gicube::samples
