#include "observe/trace_file.h"

#include <fmt/format.h>

#include <iterator>

namespace gicube::emu {

namespace {

constexpr Picoseconds kNanosecond = 1000;

// A time in microseconds, from whole nanoseconds.
struct Microseconds {
  std::uint64_t whole;
  std::uint64_t thousandths;
  explicit Microseconds(std::uint64_t ns) : whole(ns / 1000), thousandths(ns % 1000) {}
};

}  // namespace

void TraceFile::begin_event() {
  file_.text() += first_ ? "\n" : ",\n";
  first_ = false;
}

void TraceFile::name_process(int process, std::string_view name) {
  begin_event();
  fmt::format_to(std::back_inserter(file_.text()),
                 R"({{"ph":"M","name":"process_name","pid":{0},"args":{{"name":"{1}"}}}},)"
                 "\n"
                 R"({{"ph":"M","name":"process_sort_index","pid":{0},"args":{{"sort_index":{0}}}}})",
                 process, name);
  file_.end_record();
}

void TraceFile::name_track(Track track, std::string_view name) {
  begin_event();
  fmt::format_to(std::back_inserter(file_.text()),
                 R"({{"ph":"M","name":"thread_name","pid":{},"tid":{},"args":{{"name":"{}"}}}})", track.process,
                 track.thread, name);
  file_.end_record();
}

void TraceFile::slice(Track track, std::string_view name, Picoseconds begin, Picoseconds end, std::string_view args) {
  begin_event();
  const Microseconds from(begin / kNanosecond), length(end / kNanosecond - begin / kNanosecond);
  fmt::format_to(std::back_inserter(file_.text()),
                 R"({{"ph":"X","pid":{},"tid":{},"ts":{}.{:03},"dur":{}.{:03},"name":"{}","args":{{{}}}}})",
                 track.process, track.thread, from.whole, from.thousandths, length.whole, length.thousandths, name,
                 args);
  file_.end_record();
  saw(end);
}

void TraceFile::instant(Track track, std::string_view name, Picoseconds at) {
  begin_event();
  const Microseconds time(at / kNanosecond);
  fmt::format_to(std::back_inserter(file_.text()),
                 R"({{"ph":"i","s":"g","pid":{},"tid":{},"ts":{}.{:03},"name":"{}"}})", track.process, track.thread,
                 time.whole, time.thousandths, name);
  file_.end_record();
  saw(at);
}

void TraceFile::counter(int process, std::string_view name, Picoseconds at, std::uint64_t value) {
  begin_event();
  const Microseconds time(at / kNanosecond);
  fmt::format_to(std::back_inserter(file_.text()),
                 R"({{"ph":"C","pid":{},"ts":{}.{:03},"name":"{}","args":{{"value":{}}}}})", process, time.whole,
                 time.thousandths, name, value);
  file_.end_record();
  saw(at);
}

}  // namespace gicube::emu
