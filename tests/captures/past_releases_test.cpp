// Drivers and boards of released versions with today's (docs/reference/protocol.md, Versions): what one side of theirs
// sent in a captured session is sent to the other side of ours.
#include "fake_board.h"
#include "past_board.h"
#include "run_program.h"
#include "session.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::captures {
namespace {

constexpr const char* kFolder = GICUBE_SOURCE_DIR "/tests/captures/";

struct Past {
  std::uint16_t minor;
  Session session;

  std::string file(const char* ending) const {
    return kFolder + std::string("2.") + std::to_string(minor) + '/' + session.name + ending;
  }
};

// Of each version the sessions that it has.
std::vector<Past> all_past() {
  std::vector<Past> list;
  for (std::uint16_t minor = 0; minor <= wire::kMinorVersion; ++minor) {
    for (const Session& session : sessions()) {
      const Past past{minor, session};
      if (std::filesystem::exists(past.file(".cap.gz"))) list.push_back(past);
    }
  }
  return list;
}

class PastRelease : public testing::TestWithParam<Past> {};

TEST_P(PastRelease, ItsDriversBytesGetTheSameAnswersOfThisBoard) {
  // Another bus than that of the captured board: times and counters are each release's own.
  const std::string board = std::string("emu:") + kOptions + "&bus=agp2x";
  const auto run = tools_test::run_program("gicube-replay", {GetParam().file(".cap.gz"), "--board", board});
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("no difference"), ContainsRegex("compared [1-9][0-9]+ answers")));
}

TEST_P(PastRelease, ItsBoardsAnswersGiveThisDriverTheSameValues) {
  const reference::TemporaryDirectory folder;
  PastBoard past(GetParam().file(".cap.gz"), GetParam().minor);
  std::string values;
  {
    reference::FakeBoard fake(folder.file("bus"), [&past](reference::FakeBoard& board) { past.serve(board); });
    Board board = Board::open("unix:" + folder.file("bus"));
    EXPECT_EQ(board.info().protocol_minor, GetParam().minor);
    values = GetParam().session.use(board);
  }
  EXPECT_THAT(past.refused(), IsEmpty());
  EXPECT_EQ(values, text_of(GetParam().file(".txt")));
}

TEST(LampsOfAView, NeedABoardThatKnowsThem) {
  constexpr std::uint16_t kMinor = 2;
  const Past picture{kMinor, sessions().front()};
  const reference::TemporaryDirectory folder;
  PastBoard past(picture.file(".cap.gz"), kMinor);
  reference::FakeBoard fake(folder.file("bus"), [&past](reference::FakeBoard& board) { past.serve(board); });
  Board board = Board::open("unix:" + folder.file("bus"));
  picture.session.use(board);
  View view;
  view.eye = {5, 6, -90};
  view.scatter = true;
  view.lamps = {{SphereLight{{0, 0, 90}, 5}, {1, 1, 1}}};
  EXPECT_THROWS(Rejected, "View::lamps needs a board of protocol 2.3, this one has 2.2", board.render(view));
  EXPECT_THAT(past.refused(), IsEmpty()) << "nothing was sent";
}

INSTANTIATE_TEST_SUITE_P(, PastRelease, testing::ValuesIn(all_past()), [](const auto& test) {
  return "Of2_" + std::to_string(test.param.minor) + '_' + test.param.session.name;
});

}  // namespace
}  // namespace gicube::captures
