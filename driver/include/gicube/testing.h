// Tests of an application against a board with a given bus, configuration, fault plan and seed: on simulated time and
// on bytes, so that they hold on every machine. With or without a test framework; docs/guide/integration_tests.md.
//
//   gicube_add_test(NAME upload_test SOURCES upload_test.cpp BUS pci33 agp2x)        # CMake
//
//   gicube::Board board = gicube::test::BoardSetup::from_environment().open();
//   gicube::test::Window window(board);
//   upload_everything(board);                                                        // the application under test
//   const gicube::test::Measured upload = window.end();
//   EXPECT_TRUE(time_is(upload, 0.57e12, 0.01));                                     // GoogleTest prints the message
//   require(counter_is(upload, "bus.down.bytes", 75'497'472));                       // anywhere: throws Failed
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "gicube/board.h"

namespace gicube::test {

// The board of a test. The arguments of gicube_add_test() arrive in the environment, as GICUBE_TEST_BUS and so on.
struct BoardSetup {
  std::string board{};             // URI of an existing board; empty: a private emulated one with the fields below
  std::string bus{};               // pci33, agp1x, agp2x or agp4x; empty: the board's default, as all below
  std::string fidelity{};          // functional or cycle
  std::string config{};            // file name of a board configuration
  std::vector<std::string> set{};  // "field=value", fields of it
  std::string faults{};            // file name of a fault plan
  std::uint64_t seed = 1;          // of the test's own random choices

  // Throws BadArgument if GICUBE_TEST_SEED is no number.
  static BoardSetup from_environment();
  // The URI for Board::open().
  std::string uri() const;
  // Throws as Board::open().
  Board open(const OpenOptions& options = {}) const { return Board::open(uri(), options); }
};

// Changes between two points of simulated time.
struct Measured {
  Picoseconds time = 0;
  Counters counters;  // grown by so much

  // Simulated time that a counter in picoseconds has of the whole, as "bus.down.busy_ps"; 0..1.
  double share(std::string_view counter) const {
    return time == 0 ? 0 : static_cast<double>(counters.value(counter)) / static_cast<double>(time);
  }
  // A counter a simulated second, as bytes of "bus.up.bytes".
  double per_second(std::string_view counter) const {
    return time == 0 ? 0 : static_cast<double>(counters.value(counter)) / (static_cast<double>(time) * 1e-12);
  }
};

// The window starts at construction. Work under way at either end is counted by its progress until then.
class Window {
 public:
  explicit Window(Board& board) : board_(board), begin_(board.now()), counters_(board.counters()) {}

  // From the begin until now; may be called again later.
  Measured end() const { return {board_.now() - begin_, board_.counters() - counters_}; }

 private:
  Board& board_;
  Picoseconds begin_;
  Counters counters_;
};

// An assertion's outcome: it becomes a bool by itself, and GoogleTest's AssertionResult with the message.
struct Check {
  bool passed = false;
  std::string message;  // what was expected and what came

  explicit operator bool() const { return passed; }
  template <typename Result>
  requires requires(Result result, std::string text) {
    result << text;
    result.failure_message();
  }
  operator Result() const { return Result(passed) << message; }
  friend std::ostream& operator<<(std::ostream& out, const Check& check) { return out << check.message; }
};

struct Failed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws Failed with the message of a check that did not pass.
inline void require(const Check& check) {
  if (!check.passed) throw Failed(check.message);
}

namespace detail {

inline std::string text_of(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// 12 digits: counts are shown whole.
inline std::string number(double value) { return text_of("%.12g", value); }

inline std::string time(double picoseconds) {
  if (picoseconds >= 1e9) return text_of("%.6g ms", picoseconds * 1e-9);
  if (picoseconds >= 1e6) return text_of("%.6g us", picoseconds * 1e-6);
  return text_of("%.6g ps", picoseconds);
}

inline std::string within(double tolerance) {
  return tolerance == 0 ? std::string(" exactly") : text_of(" within %.3g%%", 100 * tolerance);
}

inline Check compare(std::string_view what, double got, double expected, double tolerance,
                     std::string (*text)(double)) {
  const double off = got - expected;
  Check check{std::abs(off) <= tolerance * std::abs(expected), std::string(what)};
  check.message += ": expected " + text(expected) + within(tolerance) + ", got " + text(got);
  if (expected != 0) check.message += text_of(" (%+.3f%%)", 100 * off / std::abs(expected));
  return check;
}

inline std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

// Everything but letters, digits and a path's usual signs as %XX.
inline std::string encoded(std::string_view text) {
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789/._-=";
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    if (kPlain.find(c) != std::string_view::npos) {
      out += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      out += {'%', kHex[byte / 16], kHex[byte % 16]};
    }
  }
  return out;
}

}  // namespace detail

// Checks with a relative tolerance: 0.01 is one per cent of what is expected, 0 is exactly.

// Any two numbers; `what` begins the message.
inline Check near(std::string_view what, double got, double expected, double tolerance) {
  return detail::compare(what, got, expected, tolerance, detail::number);
}

inline Check time_is(const Measured& measured, double picoseconds, double tolerance) {
  return detail::compare("simulated time", static_cast<double>(measured.time), picoseconds, tolerance, detail::time);
}

// Fails too if the board's fidelity level does not keep the counter.
inline Check counter_is(const Measured& measured, std::string_view name, double value, double tolerance = 0) {
  if (!measured.counters.has(name)) return {false, std::string(name) + ": this board has no such counter"};
  return near(name, static_cast<double>(measured.counters.value(name)), value, tolerance);
}

// The share of the time that a counter in picoseconds grew by, 0..1.
inline Check share_is(const Measured& measured, std::string_view name, double share, double tolerance) {
  if (!measured.counters.has(name)) return {false, std::string(name) + ": this board has no such counter"};
  return near(std::string(name) + " / time", measured.share(name), share, tolerance);
}

inline BoardSetup BoardSetup::from_environment() {
  BoardSetup setup;
  setup.board = detail::environment("GICUBE_TEST_BOARD");
  setup.bus = detail::environment("GICUBE_TEST_BUS");
  setup.fidelity = detail::environment("GICUBE_TEST_FIDELITY");
  setup.config = detail::environment("GICUBE_TEST_CONFIG");
  setup.faults = detail::environment("GICUBE_TEST_FAULTS");
  const std::string fields = detail::environment("GICUBE_TEST_SET");
  for (std::size_t at = 0; at < fields.size();) {
    const std::size_t end = std::min(fields.find(' ', at), fields.size());
    if (end > at) setup.set.push_back(fields.substr(at, end - at));
    at = end + 1;
  }
  const std::string seed = detail::environment("GICUBE_TEST_SEED");
  if (!seed.empty()) {
    const auto [end, error] = std::from_chars(seed.data(), seed.data() + seed.size(), setup.seed);
    if (error != std::errc() || end != seed.data() + seed.size()) {
      throw BadArgument("GICUBE_TEST_SEED", "a number from 0 to 2^64 - 1", "\"" + seed + "\"");
    }
  }
  return setup;
}

inline std::string BoardSetup::uri() const {
  if (!board.empty()) return board;
  std::string options;
  const auto add = [&options](const char* name, const std::string& value) {
    if (!value.empty()) options += std::string(options.empty() ? "?" : "&") + name + "=" + detail::encoded(value);
  };
  add("config", config);
  add("fidelity", fidelity);
  add("bus", bus);
  for (const std::string& field : set) add("set", field);
  add("faults", faults);
  return "emu:" + options;
}

}  // namespace gicube::test
