#include "read_trace.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace gicube::emu {

namespace {

std::int64_t nanoseconds(const nlohmann::json& microseconds) { return std::llround(microseconds.get<double>() * 1000); }

}  // namespace

std::uint64_t ReadTrace::sum(const std::string& track, const std::string& argument) const {
  std::uint64_t sum = 0;
  const auto found = slices.find(track);
  if (found == slices.end()) return 0;
  for (const ReadSlice& slice : found->second) sum += slice.args.value(argument, std::uint64_t{0});
  return sum;
}

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("no file " + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

ReadTrace read_trace(const std::string& text) {
  ReadTrace trace;
  std::map<int, std::string> processes;
  std::map<int, std::string> tracks;
  for (const nlohmann::json& event : nlohmann::json::parse(text)) {
    const std::string phase = event.at("ph"), name = event.at("name");
    if (phase == "M") {
      if (name == "process_name") processes[event.at("pid")] = event.at("args").at("name");
      if (name == "thread_name") {
        const std::string of = processes.at(event.at("pid"));
        if (!tracks.emplace(event.at("tid"), of + '/' + event.at("args").at("name").get<std::string>()).second) {
          throw std::runtime_error("two tracks with one number");
        }
      }
    } else if (phase == "X") {
      auto& slices = trace.slices[tracks.at(event.at("tid"))];
      const std::int64_t begin = nanoseconds(event.at("ts")), end = begin + nanoseconds(event.at("dur"));
      if (end < begin || (!slices.empty() && begin < slices.back().end_ns)) {
        throw std::runtime_error("overlap at " + event.dump());
      }
      slices.push_back({name, begin, end, event.at("args")});
    } else if (phase == "C") {
      trace.counters[processes.at(event.at("pid")) + '/' + name].emplace_back(nanoseconds(event.at("ts")),
                                                                              event.at("args").at("value"));
    } else if (phase == "i") {
      trace.instants[name].push_back(nanoseconds(event.at("ts")));
    } else {
      throw std::runtime_error("no such phase: " + phase);
    }
  }
  return trace;
}

}  // namespace gicube::emu
