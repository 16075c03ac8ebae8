// A view's settings as gicube-render's options, as its command line and as Python.
#include "view/settings.h"

#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples::view {
namespace {

constexpr const char* kFunction = "values absolute\ncolour 0 1 0 0\nopacity 0 0\nopacity 99 1\n";

class ViewSettings : public testing::Test {
 protected:
  ViewSettings() {
    shelf.folder = folder.path();
    shelf.inputs = {
        {"ball", "builtin:buckyball"}, {"own.nrrd", folder.path() + "/own.nrrd"}, {"a b.nrrd", "/data/a b.nrrd"}};
  }
  RenderOptions options(Settings settings, const BoardOptions& board = {}) const {
    settings.emplace("input", "ball");
    return options_of(settings, shelf, board);
  }
  std::string command(Settings settings, const BoardOptions& board = {}) const {
    settings.emplace("input", "ball");
    return command_of(settings, shelf, board);
  }
  std::string fault(const Settings& settings) const {
    return message_of<std::exception>([&] { options(settings); });
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder.path()), {}));
  }

  reference::TemporaryDirectory folder;
  Shelf shelf;
};

TEST_F(ViewSettings, AreGicubeRendersOptions) {
  const RenderOptions made =
      options({{"eye", "1,2,3"}, {"step", "0.25"}, {"jitter", "on"}, {"no-shade", "off"}, {"size", "64x32"}});
  EXPECT_EQ(made.input, "builtin:buckyball");
  EXPECT_EQ(made.camera.eye->y, 2);
  EXPECT_EQ(made.step, 0.25);
  EXPECT_TRUE(made.jitter);
  EXPECT_FALSE(made.no_shade);
  EXPECT_EQ(made.size, (std::array{64, 32}));
}

TEST_F(ViewSettings, HaveSeveralCutPlanesWithSemicolonsBetween) {
  const RenderOptions made = options({{"cut", "1,0,0,4;0,0,-1,-2"}});
  ASSERT_EQ(made.cut_planes.size(), 2u);
  EXPECT_EQ(made.cut_planes[1].offset, -2);
}

TEST_F(ViewSettings, ChangeTheBoardsFieldsAndLevelBesidesThoseOfTheCommandLine) {
  BoardOptions board;
  board.fidelity = "cycle";
  board.settings = {"bus.model=agp2x"};
  board.threads = 2;
  const RenderOptions made = options({{"asic.processors", "8"}, {"fidelity", "cycle"}, {"seed", "5"}}, board);
  EXPECT_EQ(made.board.fidelity, "cycle");
  EXPECT_EQ(made.board.settings, (std::vector<std::string>{"bus.model=agp2x", "asic.processors=8"}));
  EXPECT_EQ(made.board.threads, 2);
  EXPECT_EQ(made.board.seed, 5u);
  EXPECT_EQ(options({}, board).board.fidelity, "cycle");
}

TEST_F(ViewSettings, NameNoFileOfTheirOwn) {
  EXPECT_EQ(fault({{"input", "/etc/passwd"}}),
            "--input: expected one of a b.nrrd, ball, own.nrrd, got \"/etc/passwd\"");
  for (const char* name :
       {"output", "board", "config", "stats", "irradiance", "set", "allow-outside", "crop", "quiet"}) {
    EXPECT_TRUE(fault({{name, "on"}}).starts_with("--" + std::string(name) + ": expected a setting of a view")) << name;
  }
  EXPECT_NE(fault({{"transfer-function", "/etc/passwd"}}), "none");
  EXPECT_EQ(files(), 0u);
}

TEST_F(ViewSettings, AreRefusedByTheOptionAtFault) {
  EXPECT_EQ(field_of(fault({{"step", "99"}})), "step");
  EXPECT_EQ(field_of(fault({{"jitter", "maybe"}})), "jitter");
  EXPECT_EQ(field_of(fault({{"eye", "1,2"}})), "eye");
  EXPECT_EQ(field_of("the board was lost"), "");
}

TEST_F(ViewSettings, KeepAWrittenTransferFunctionOnceByItsContent) {
  const RenderOptions first = options({{"transfer-function", kFunction}});
  EXPECT_EQ(options({{"transfer-function", kFunction}}).transfer_function, first.transfer_function);
  EXPECT_EQ(files(), 1u);
  EXPECT_NE(options({{"transfer-function", std::string(kFunction) + "opacity 100 0\n"}}).transfer_function,
            first.transfer_function);
  EXPECT_EQ(options({{"transfer-function", "ct-bone"}}).transfer_function, "ct-bone");
  EXPECT_THROW(options({{"transfer-function", "colour\n"}}), Error);
  EXPECT_EQ(files(), 2u);
}

TEST_F(ViewSettings, AreACommandLineForTheShell) {
  EXPECT_EQ(command({{"step", "0.25"},
                     {"no-leap", "on"},
                     {"jitter", "off"},
                     {"cut", "1,0,0,4;0,0,-1,-2"},
                     {"asic.processors", "8"}}),
            "gicube-render builtin:buckyball --set=asic.processors=8 --cut=1,0,0,4 --cut=0,0,-1,-2 --no-leap "
            "--step=0.25 -o picture.png");
  EXPECT_EQ(command({{"input", "a b.nrrd"}, {"transfer-function", kFunction}}),
            "gicube-render '/data/a b.nrrd' --transfer-function=view.tf -o picture.png");
  // A file that came from a page has no path that anyone else knows.
  EXPECT_EQ(command({{"input", "own.nrrd"}}), "gicube-render own.nrrd -o picture.png");
  // Names that would be something else.
  shelf.inputs.insert(
      {{"-h.nrrd", folder.path() + "/-h.nrrd"}, {"builtin:x", folder.path() + "/builtin:x"}, {"-a", "-a"}});
  EXPECT_EQ(command({{"input", "-h.nrrd"}}), "gicube-render ./-h.nrrd -o picture.png");
  EXPECT_EQ(command({{"input", "builtin:x"}}), "gicube-render ./builtin:x -o picture.png");
  EXPECT_EQ(options({{"input", "-a"}}).input, "./-a");
}

TEST_F(ViewSettings, SayInTheCommandWhatTheProgramWasStartedWith) {
  BoardOptions board;
  board.board = "unix:/tmp/board";
  board.seed = 3;
  EXPECT_EQ(command({}, board), "gicube-render builtin:buckyball --board=unix:/tmp/board --seed=3 -o picture.png");
}

TEST_F(ViewSettings, HavePythonLinesUnlessThePackageHasNoCallForOne) {
  const auto lines = [this](Settings settings) {
    settings.emplace("input", "ball");
    return python_of(settings, shelf, options(settings), SceneSetup(), {});
  };
  const std::string text = lines({{"volume-size", "32"}, {"transfer-function", kFunction}, {"asic.processors", "8"}});
  EXPECT_NE(text.find(R"(parse_scene("volume { builtin: \"buckyball\" size: 32 }"))"), std::string::npos) << text;
  EXPECT_NE(text.find(R"(gicube.open("emu:?set=asic.processors=8"))"), std::string::npos) << text;
  EXPECT_NE(text.find(R"(transfer_function("view.tf")"), std::string::npos) << text;
  EXPECT_EQ(lines({{"illumination", "low"}}), "");
  EXPECT_NE(lines({{"input", "a b.nrrd"}}).find(R"(parse_scene("volume { file: \"a b.nrrd\" }", folder="/data"))"),
            std::string::npos);
  EXPECT_NE(lines({{"input", "own.nrrd"}}).find(R"(parse_scene("volume { file: \"own.nrrd\" }"))"), std::string::npos);
}

}  // namespace
}  // namespace gicube::samples::view
