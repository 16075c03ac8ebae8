#include "observe/vcd_file.h"

#include <fmt/format.h>

#include <array>
#include <iterator>

namespace gicube::emu {

namespace {

// Short codes of printable characters, as the standard has them.
std::string identifier(std::size_t number) {
  constexpr char kFirst = '!';
  constexpr std::size_t kCount = '~' - '!' + 1;
  std::string id;
  for (;;) {
    id += static_cast<char>(kFirst + static_cast<char>(number % kCount));
    if (number < kCount) return id;
    number = number / kCount - 1;
  }
}

}  // namespace

void VcdFile::comment(std::string_view text) {
  fmt::format_to(std::back_inserter(file_.text()), "$comment {} $end\n", text);
}

void VcdFile::timescale(int exponent) {
  constexpr std::array<const char*, 5> kUnits{"ps", "ns", "us", "ms", "s"};
  constexpr std::array<int, 3> kPowers{1, 10, 100};
  fmt::format_to(std::back_inserter(file_.text()), "$timescale {} {} $end\n",
                 kPowers[static_cast<std::size_t>(exponent % 3)], kUnits[static_cast<std::size_t>(exponent / 3)]);
}

void VcdFile::open_scope(std::string_view name) {
  fmt::format_to(std::back_inserter(file_.text()), "$scope module {} $end\n", name);
}

VcdFile::Signal VcdFile::declare(std::string_view name, unsigned bits) {
  states_.push_back({identifier(states_.size()), bits, false, std::nullopt});
  const std::string range = bits > 1 ? fmt::format(" [{}:0]", bits - 1) : "";
  fmt::format_to(std::back_inserter(file_.text()), "$var wire {} {} {}{} $end\n", bits, states_.back().id, name, range);
  return states_.size() - 1;
}

void VcdFile::close_scope() { file_.text() += "$upscope $end\n"; }

void VcdFile::begin(std::uint64_t time) {
  time_ = written_time_ = time;
  initial_ = true;
  fmt::format_to(std::back_inserter(file_.text()), "$enddefinitions $end\n#{}\n$dumpvars\n", time);
}

void VcdFile::end_initial() {
  if (initial_) file_.text() += "$end\n";
  initial_ = false;
}

void VcdFile::write_time() {
  if (time_ == written_time_) return;
  end_initial();
  fmt::format_to(std::back_inserter(file_.text()), "#{}\n", time_);
  written_time_ = time_;
}

void VcdFile::change(State& state, std::optional<std::uint64_t> value) {
  write_time();
  state.known = true;
  state.value = value;
  const auto out = std::back_inserter(file_.text());
  if (state.bits == 1) {
    fmt::format_to(out, "{}{}\n", !value ? 'z' : *value != 0 ? '1' : '0', state.id);
  } else if (value) {
    fmt::format_to(out, "b{:b} {}\n", *value, state.id);
  } else {
    fmt::format_to(out, "bz {}\n", state.id);
  }
  file_.end_record();
}

void VcdFile::end(std::uint64_t time) {
  time_ = time;
  write_time();
  end_initial();
  file_.flush();
}

}  // namespace gicube::emu
