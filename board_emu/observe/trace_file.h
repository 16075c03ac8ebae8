// A trace in the JSON array form of the Trace Event Format, which Perfetto (ui.perfetto.dev) and chrome://tracing open.
//
// Times come in picoseconds and are written in microseconds to the whole nanosecond below, so slices that touch still
// touch. Slices of a track must not overlap and must come in order.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "observe/text_file.h"
#include "words/clock.h"

namespace gicube::emu {

// What Perfetto shows as a thread of a process. Both from 1; a thread's number is unique in the file.
struct Track {
  int process = 1;
  int thread = 1;
};

class TraceFile {
 public:
  // Throws std::runtime_error that names the file.
  explicit TraceFile(const std::string& path) : file_(path) { file_.text() += "["; }
  ~TraceFile() { complete(); }

  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;

  // Processes are shown in the order of their numbers.
  void name_process(int process, std::string_view name);
  void name_track(Track track, std::string_view name);
  // `args`: members of a JSON object, as "\"bytes\":4".
  void slice(Track track, std::string_view name, Picoseconds begin, Picoseconds end, std::string_view args);
  void instant(Track track, std::string_view name, Picoseconds at);
  // The value from `at` on.
  void counter(int process, std::string_view name, Picoseconds at, std::uint64_t value);

  // Makes the file a whole one as it stands; more may follow.
  void complete() { file_.flush_with("\n]\n"); }

  // The end of the latest slice, or the latest of the other events.
  Picoseconds latest() const { return latest_; }
  const TextFile& file() const { return file_; }

 private:
  void begin_event();
  void saw(Picoseconds time) { latest_ = time > latest_ ? time : latest_; }

  TextFile file_;
  bool first_ = true;
  Picoseconds latest_ = 0;
};

}  // namespace gicube::emu
