// A four-state value change dump, IEEE 1364-2005 clause 18: signals in scopes, and their changes in the order of time.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "observe/text_file.h"
#include "words/clock.h"

namespace gicube::emu {

class VcdFile {
 public:
  using Signal = std::size_t;

  // Throws std::runtime_error, which names the file.
  explicit VcdFile(const std::string& path) : file_(path) {}

  // The header is written in this order: comment, unit of time, scopes with their signals, begin().
  void comment(std::string_view text) { file_.add("$comment {} $end\n", text); }
  // Sets the unit of time to 10^`exponent` ps, up to a second.
  void timescale(int exponent) {
    constexpr std::array<const char*, 5> kUnits{"ps", "ns", "us", "ms", "s"};
    constexpr std::array<int, 3> kPowers{1, 10, 100};
    file_.add("$timescale {} {} $end\n", kPowers[static_cast<std::size_t>(exponent % 3)],
              kUnits[static_cast<std::size_t>(exponent / 3)]);
  }
  void open_scope(std::string_view name) { file_.add("$scope module {} $end\n", name); }
  Signal declare(std::string_view name, unsigned bits) {
    states_.push_back({identifier(states_.size()), bits, false, std::nullopt});
    const std::string range = bits > 1 ? fmt::format(" [{}:0]", bits - 1) : "";
    file_.add("$var wire {} {} {}{} $end\n", bits, states_.back().id, name, range);
    return states_.size() - 1;
  }
  void close_scope() { file_.add("$upscope $end\n"); }
  // Ends the header. The values set before the next time() are the initial ones.
  void begin(std::uint64_t time) {
    time_ = written_time_ = time;
    initial_ = true;
    file_.add("$enddefinitions $end\n#{}\n$dumpvars\n", time);
  }

  // Values that are set after this call hold from `time` on. Times must not decrease.
  void time(std::uint64_t time) { time_ = time; }
  // Writes the value if it has changed. No value = high impedance, z.
  void set(Signal signal, std::optional<std::uint64_t> value) {
    State& state = states_[signal];
    if (state.known && state.value == value) [[likely]]
      return;
    change(state, value);
  }
  // Ends the dump: the last values hold until `time`. Nothing may follow.
  void end(std::uint64_t time) {
    time_ = time;
    write_time();
    end_initial();
    file_.flush();
  }
  void flush() { file_.flush(); }

  const TextFile& file() const { return file_; }

 private:
  struct State {
    std::string id;
    unsigned bits = 1;
    bool known = false;
    std::optional<std::uint64_t> value;
  };

  void change(State& state, std::optional<std::uint64_t> value) {
    write_time();
    state.known = true;
    state.value = value;
    if (state.bits == 1) {
      file_.add("{}{}\n", !value ? 'z' : *value != 0 ? '1' : '0', state.id);
    } else if (value) {
      file_.add("b{:b} {}\n", *value, state.id);
    } else {
      file_.add("bz {}\n", state.id);
    }
    file_.end_record();
  }
  void write_time() {
    if (time_ == written_time_) return;
    end_initial();
    file_.add("#{}\n", time_);
    written_time_ = time_;
  }
  void end_initial() {
    if (initial_) file_.add("$end\n");
    initial_ = false;
  }

  // Returns a short code of printable characters, as the standard requires.
  static std::string identifier(std::size_t number) {
    constexpr char kFirst = '!';
    constexpr std::size_t kCount = '~' - '!' + 1;
    std::string id;
    for (;;) {
      id += static_cast<char>(kFirst + static_cast<char>(number % kCount));
      if (number < kCount) return id;
      number = number / kCount - 1;
    }
  }

  TextFile file_;
  std::vector<State> states_;
  std::uint64_t time_ = 0;
  std::uint64_t written_time_ = 0;
  bool initial_ = false;
};

}  // namespace gicube::emu
