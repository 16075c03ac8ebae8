// A link whose board does not answer for long.
#include "fake_board.h"
#include "gicube/error.h"
#include "test.h"
#include "transport/link.h"

namespace gicube {
namespace {

using reference::bytes_of;
using reference::FakeBoard;
using reference::Frame;
using wire::FrameType;

TEST(Link, WithoutAnAnswerTheWatchdogClosesTheLink) {
  bool closed = false;
  {
    FakeBoard board([&closed](FakeBoard& self) {
      self.shake_hands();
      self.drain();
      closed = true;
    });
    Link link(board.take_socket(), {.watchdog = std::chrono::milliseconds(50)});
    EXPECT_THROW(link.request(FrameType::kCounters, 0, {}), TimedOut);
    EXPECT_THROW(link.request(FrameType::kCounters, 0, {}), DeviceLost);
  }
  EXPECT_TRUE(closed);
}

TEST(Link, ProgressKeepsTheWatchdogQuiet) {
  FakeBoard board(in_session([](FakeBoard& self) {
    const Frame command = *self.receive();
    const Frame wait = *self.receive();
    for (std::uint32_t i = 0; i < 10; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      self.progress(command.header.id, i, 10);
    }
    self.complete(command.header.id, 5);
    self.respond(wait, 5);
  }));
  Link link(board.take_socket(), {.watchdog = std::chrono::milliseconds(800)});
  const auto ticket = link.command(0, wire::share(bytes_of("draw")));
  EXPECT_NO_THROW(link.wait(ticket, 0, kNoDeadline, {}));
}

}  // namespace
}  // namespace gicube
