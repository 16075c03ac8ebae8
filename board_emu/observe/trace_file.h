// A trace in the JSON array form of the Trace Event Format, which Perfetto (ui.perfetto.dev) and chrome://tracing read.
//
// Times are passed in picoseconds and written in microseconds, rounded down to nanoseconds. Slices of a track must be
// added in order and must not overlap.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "observe/text_file.h"
#include "words/clock.h"

namespace gicube::emu {

// A track, which Perfetto shows as a thread of a process. Numbers start at 1; a thread's number is unique in the file.
struct Track {
  int process = 1;
  int thread = 1;
};

class TraceFile {
 public:
  // Throws std::runtime_error, which names the file.
  explicit TraceFile(const std::string& path, Creation creation = Creation::kReplaces) : file_(path, creation) {
    file_.add("[");
  }
  ~TraceFile() { complete(); }

  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;

  // Processes are shown in the order of their numbers.
  void name_process(int process, std::string_view name) {
    event(0, R"("ph":"M","name":"process_name","pid":{},"args":{{"name":"{}"}})", process, name);
    event(0, R"("ph":"M","name":"process_sort_index","pid":{0},"args":{{"sort_index":{0}}})", process);
  }
  void name_track(Track track, std::string_view name) {
    event(0, R"("ph":"M","name":"thread_name","pid":{},"tid":{},"args":{{"name":"{}"}})", track.process, track.thread,
          name);
  }
  // `args`: members of a JSON object, for example "\"bytes\":4".
  void slice(Track track, std::string_view name, Picoseconds begin, Picoseconds end, std::string_view args) {
    const std::uint64_t from = begin / 1000, to = end / 1000;  // ns
    event(end, R"("ph":"X","pid":{},"tid":{},"ts":{},"dur":{},"name":"{}","args":{{{}}})", track.process, track.thread,
          thousandths(from), thousandths(to - from), name, args);
  }
  void instant(Track track, std::string_view name, Picoseconds at) {
    event(at, R"("ph":"i","s":"g","pid":{},"tid":{},"ts":{},"name":"{}")", track.process, track.thread,
          thousandths(at / 1000), name);
  }
  // Sets the counter's value, a number or its text, from `at` on.
  template <typename Value>
  void counter(int process, std::string_view name, Picoseconds at, const Value& value) {
    event(at, R"("ph":"C","pid":{},"ts":{},"name":"{}","args":{{"value":{}}})", process, thousandths(at / 1000), name,
          value);
  }
  // Milliwatts, to the microwatt.
  void power(int process, std::string_view name, Picoseconds at, std::uint64_t microwatts) {
    counter(process, name, at, thousandths(microwatts));
  }

  // Completes the JSON array. More events may follow.
  void complete() { file_.flush_with("\n]\n"); }

  // The latest end of a slice or time of another event.
  Picoseconds latest() const { return latest_; }
  const TextFile& file() const { return file_; }

 private:
  static std::string thousandths(std::uint64_t value) { return fmt::format("{}.{:03}", value / 1000, value % 1000); }

  template <typename... Args>
  void event(Picoseconds end, fmt::format_string<Args...> members, Args&&... args) {
    file_.add("{}\n{{", first_ ? "" : ",");
    first_ = false;
    file_.add(members, std::forward<Args>(args)...);
    file_.add("}}");
    file_.end_record();
    latest_ = std::max(latest_, end);
  }

  TextFile file_;
  bool first_ = true;
  Picoseconds latest_ = 0;
};

}  // namespace gicube::emu
