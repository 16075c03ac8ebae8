// Long times without packets, for tests of channels: refreshes are left out, and nothing may show it.
#pragma once

#include "asic/dram/memory.h"
#include "gicube/archive.h"
#include "test.h"

namespace gicube::emu {

class StateInText final : public Archive {
 public:
  StateInText() : Archive(false) {}
  std::string text() const { return text_.str(); }

 private:
  void exchange(Field& field) override {
    text_ << field.name << ':';
    for (const std::uint64_t number : field.numbers) text_ << ' ' << number;
    text_ << '\n';
  }

  std::ostringstream text_;
};

template <class Channel>
std::string state_of(Channel& channel) {
  StateInText state;
  channel.state(state);
  return state.text();
}

// `make()`: a channel of so many devices that are refreshed every `interval` clocks. `draw(random)`: the place of a
// packet.
template <class Make, class Draw>
void expect_long_times_to_be_short_ones(const Make& make, unsigned devices, std::uint64_t interval, const Draw& draw) {
  SCOPED_TRACE(testing::Message() << devices << " devices, every " << interval);
  std::mt19937 random(devices + static_cast<unsigned>(interval));
  const auto channel = make(), in_pieces = make();
  std::uint64_t now = 0;
  for (int pause = 0; pause < 12; ++pause) {
    for (int i = 0; i < 5; ++i) {
      const dram::Location at = draw(random);
      const bool write = random() % 3 == 0;
      now += random() % 40;
      const dram::Access one = write ? channel->write(at, now) : channel->read(at, now);
      const dram::Access other = write ? in_pieces->write(at, now) : in_pieces->read(at, now);
      ASSERT_EQ(one.data_begin, other.data_begin) << "pause " << pause;
      ASSERT_EQ(one.cause, other.cause) << "pause " << pause;
    }
    const std::uint64_t end = now + random() % (1000 * interval + 100'000);
    for (; now < end; now = std::min(end, now + 5 * interval + 1)) in_pieces->advance(now);
    in_pieces->advance(end);
    channel->advance(end);
    ASSERT_EQ(state_of(*channel), state_of(*in_pieces)) << "pause " << pause;
  }
  constexpr std::uint64_t kHours = std::uint64_t{1} << 46;  // of a clock of 400 MHz: two days
  channel->advance(now + kHours);
  EXPECT_EQ(channel->counters().refreshes, ((now + kHours + 1) * devices - 1) / interval);
}

}  // namespace gicube::emu
