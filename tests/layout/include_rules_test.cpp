// The tree's includes run one way; and the checker that says so can say otherwise.
#include "include_rules.h"

#include "test.h"

namespace gicube::layout {
namespace {

const Files kTree{"proto/gicube/wire/ray.h",
                  "driver/include/gicube/board.h",
                  "driver/src/transport/link.h",
                  "board_emu/words/words.h",
                  "board_emu/words/clock.h",
                  "board_emu/config/config.h",
                  "board_emu/memory/volume_memory.h",
                  "board_emu/datapath/frame.h",
                  "board_emu/asic/sim/fifo.h",
                  "board_emu/asic/link/ring.h",
                  "board_emu/asic/sorter/sorter.h",
                  "board_emu/levels/level.h",
                  "board_emu/functional/functional_level.h",
                  "board_emu/cycle/machine.h",
                  "board_emu/firmware/framebuffer.h",
                  "board_emu/board/board.h",
                  "board_emu/board/timeline.h",
                  "board_emu/board/bus/host_bus.h",
                  "board_emu/observe/observation.h",
                  "board_emu/server/bus/session.h",
                  "driver/scene/include/gicube/scene/scene.h",
                  "driver/scene/common/faults.h",
                  "driver/scene/graph/graph_reader.h",
                  "samples/apps/scene/names.h",
                  "tests/support/scenes.h"};

Files files_of(const std::filesystem::path& root, const std::string& folder) {
  Files files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
    const auto extension = entry.path().extension();
    if (extension != ".h" && extension != ".cpp" && extension != ".c" && extension != ".inc") continue;
    files.insert(entry.path().lexically_relative(root).generic_string());
  }
  return files;
}

TEST(IncludeRules, HoldForEverySourceFileOfTheTree) {
  const std::filesystem::path root = GICUBE_SOURCE_DIR;
  Files all;
  for (const std::string folder : {"proto", "driver", "board_emu", "samples", "tests"})
    all.merge(files_of(root, folder));
  int checked = 0;
  for (const std::string& file : all) {
    if (file.starts_with("tests/")) continue;  // tests may include anything
    ++checked;
    for (const std::string& fault : faults(all, file, text_of(root / file))) ADD_FAILURE() << fault;
  }
  EXPECT_GT(checked, 20) << "the source tree was not found at " << root;
}

TEST(IncludeRules, AllowWhatTheArchitectureNeeds) {
  EXPECT_THAT(
      faults(kTree, "driver/src/board/board.cpp", "#include \"gicube/wire/ray.h\"\n#include <boost/asio.hpp>\n"),
      IsEmpty());
  EXPECT_THAT(faults(kTree, "board_emu/firmware/framebuffer.cpp",
                     "#include \"firmware/framebuffer.h\"\n#include \"words/words.h\"\n"),
              IsEmpty());
  EXPECT_THAT(faults(kTree, "board_emu/board/board.cpp",
                     "#include \"board/bus/host_bus.h\"\n#include \"firmware/framebuffer.h\"\n"),
              IsEmpty());
  EXPECT_THAT(faults(kTree, "board_emu/asic/link/ring.cpp", "#include \"asic/sim/fifo.h\"\n#include \"ring.h\"\n"),
              IsEmpty());
  EXPECT_THAT(faults(kTree, "board_emu/firmware/make_level.cpp", "#include \"cycle/machine.h\"\n"), IsEmpty());
  EXPECT_THAT(faults(kTree, "board_emu/server/main.cpp", "#include \"board/board.h\"\n#include \"bus/session.h\"\n"),
              IsEmpty());
  EXPECT_THAT(
      faults(kTree, "samples/apps/render/main.cpp", "#include \"gicube/board.h\"\n#include \"gicube/scene/scene.h\"\n"),
      IsEmpty());
  EXPECT_THAT(faults(kTree, "driver/scene/graph/graph_reader.h", "#include \"gicube/v1/scene.pb.h\"\n"), IsEmpty());
}

TEST(IncludeRules, CatchASiblingThatNamesItsSibling) {
  EXPECT_THAT(
      faults(kTree, "board_emu/asic/link/ring.cpp", "#include <array>\n#include \"asic/sorter/sorter.h\"\n"),
      ElementsAre(
          "board_emu/asic/link/ring.cpp:2: board_emu/asic/link may not include board_emu/asic/sorter/sorter.h"));
  EXPECT_THAT(faults(kTree, "board_emu/words/words.h", "#include \"firmware/framebuffer.h\""), SizeIs(1));
  EXPECT_THAT(faults(kTree, "board_emu/firmware/framebuffer.h", "#include \"board/timeline.h\""), SizeIs(1));
}

// words, config <- memory <- datapath <- asic <- levels <- functional, cycle <- firmware <- board <- observe,
// server
TEST(IncludeRules, CatchEveryRoomOfTheBoardThatNamesARoomAboveIt) {
  struct Case {
    std::string file, include;
  };
  const std::vector<Case> forbidden{
      {"board_emu/words/words.h", "memory/volume_memory.h"},
      {"board_emu/config/config.h", "memory/volume_memory.h"},
      {"board_emu/memory/volume_memory.h", "datapath/frame.h"},
      {"board_emu/datapath/frame.h", "asic/sim/fifo.h"},
      {"board_emu/asic/sorter/sorter.h", "levels/level.h"},
      {"board_emu/levels/level.h", "functional/functional_level.h"},
      {"board_emu/levels/level.h", "cycle/machine.h"},
      {"board_emu/functional/functional_level.h", "firmware/framebuffer.h"},
      {"board_emu/functional/functional_level.h", "cycle/machine.h"},
      {"board_emu/cycle/machine.h", "firmware/framebuffer.h"},
      {"board_emu/cycle/machine.h", "board/board.h"},
      {"board_emu/firmware/commands/commands.cpp", "board/board.h"},
      {"board_emu/firmware/commands/commands.cpp", "functional/functional_level.h"},  // commands name no level
      {"board_emu/firmware/commands/commands.cpp", "cycle/machine.h"},
      {"board_emu/board/board.cpp", "observe/observation.h"},
      {"board_emu/board/board.cpp", "server/bus/session.h"},
      {"board_emu/observe/observation.h", "server/bus/session.h"},
      {"board_emu/server/main.cpp", "cycle/machine.h"},
  };
  for (const Case& c : forbidden) {
    EXPECT_THAT(faults(kTree, c.file, "#include \"" + c.include + "\"\n"), SizeIs(1)) << c.file << " " << c.include;
  }
}

TEST(IncludeRules, CatchEveryWayBetweenLayersThatRunsBackwards) {
  struct Case {
    std::string file, include;
  };
  const std::vector<Case> forbidden{
      {"proto/gicube/wire/ray.h", "\"gicube/board.h\""},                     // protocol -> driver
      {"driver/src/transport/link.cpp", "\"words/words.h\""},                // driver -> board
      {"driver/src/transport/link.cpp", "\"gicube/v1/board_config.pb.h\""},  // driver -> a message, not the wire
      {"driver/include/gicube/board.h", "\"gicube/wire/ray.h\""},            // public header -> wire
      {"driver/include/gicube/board.h", "<gicube/wire/ray.h>"},              // the same in angle brackets
      {"driver/include/gicube/board.h", "\"link.h\""},                       // public header -> private header
      {"board_emu/board/board.cpp", "\"gicube/board.h\""},                   // board -> driver
      {"board_emu/board/board.cpp", "\"server/bus/session.h\""},             // core -> server
      {"board_emu/server/main.cpp", "\"board/timeline.h\""},                 // server -> inside of the board
      {"samples/apps/render/main.cpp", "\"gicube/wire/ray.h\""},             // sample -> wire
      {"samples/apps/render/main.cpp", "\"../../../driver/src/link.h\""},    // sample -> private header by a path
      {"driver/scene/common/faults.h", "\"gicube/v1/management.pb.h\""},
      {"driver/scene/include/gicube/scene/scene.h",
       "\"scene/graph/graph_reader.h\""},  // public header -> private header
      {"driver/scene/include/gicube/scene/scene.h", "\"gicube/v1/scene.pb.h\""},
      {"driver/scene/common/faults.h", "\"scene/names.h\""},               // library -> sample
      {"samples/apps/render/main.cpp", "\"scene/graph/graph_reader.h\""},  // sample -> private header
      {"board_emu/firmware/framebuffer.h", "\"tests/support/scenes.h\""},
  };
  for (const Case& c : forbidden) {
    EXPECT_THAT(faults(kTree, c.file, "#include " + c.include + "\n"), SizeIs(1)) << c.file << " " << c.include;
  }
}

TEST(IncludeRules, CatchThirdPartyHeadersWhereOnlyTheStandardLibraryIsAllowed) {
  EXPECT_THAT(faults(kTree, "driver/include/gicube/board.h", "  #  include <boost/asio.hpp>\n"), SizeIs(1));
  EXPECT_THAT(faults(kTree, "board_emu/board/board.cpp", "#include <sys/socket.h>\n"), SizeIs(1));
}

TEST(IncludeRules, CatchNamesThatNoFileHasAndFoldersThatNoRuleFits) {
  EXPECT_THAT(faults(kTree, "samples/apps/render/main.cpp", "#include \"gone.h\"\n"),
              ElementsAre("samples/apps/render/main.cpp:1: no file of ours is called gone.h"));
  EXPECT_THAT(faults(kTree, "board_emu/novelty/part.h", ""), SizeIs(1));
}

}  // namespace
}  // namespace gicube::layout
