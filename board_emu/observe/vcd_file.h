// A value change dump, IEEE 1364-2005 clause 18, four-state: signals in scopes, and their changes in the order of time.
#pragma once

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

  // Throws std::runtime_error that names the file.
  explicit VcdFile(const std::string& path) : file_(path) {}

  // The header: comment, unit of time, then scopes with their signals, then begin().
  void comment(std::string_view text);
  // A unit of 10^`exponent` ps, up to a second.
  void timescale(int exponent);
  void open_scope(std::string_view name);
  Signal declare(std::string_view name, unsigned bits);
  void close_scope();
  // Ends the header. The values set before the next time() are the initial ones.
  void begin(std::uint64_t time);

  // Values set from now on hold from `time` on; times never decrease.
  void time(std::uint64_t time) { time_ = time; }
  // Writes a change, and nothing if the value is the old one. Nothing = high impedance, z.
  void set(Signal signal, std::optional<std::uint64_t> value) {
    State& state = states_[signal];
    if (state.known && state.value == value) [[likely]]
      return;
    change(state, value);
  }
  // The last values hold until `time`. Nothing may follow.
  void end(std::uint64_t time);
  void flush() { file_.flush(); }

  const TextFile& file() const { return file_; }

 private:
  struct State {
    std::string id;
    unsigned bits = 1;
    bool known = false;
    std::optional<std::uint64_t> value;
  };

  void change(State& state, std::optional<std::uint64_t> value);
  void write_time();
  void end_initial();

  TextFile file_;
  std::vector<State> states_;
  std::uint64_t time_ = 0;
  std::uint64_t written_time_ = 0;
  bool initial_ = false;
};

}  // namespace gicube::emu
