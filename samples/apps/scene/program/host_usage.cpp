#include "scene/program/host_usage.h"

#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace gicube::samples {
namespace {

namespace fs = std::filesystem;

// proc(5), stat: user and system time are the 14th and 15th field. The second is a name in brackets, which may contain
// anything.
double cpu_seconds(const fs::path& process) {
  std::ifstream stream(process / "stat");
  std::string line;
  std::getline(stream, line);
  line.erase(0, line.rfind(')') + 1);
  std::istringstream fields(line);
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

// VmHWM of proc(5), status. (The peak of getrusage() includes that of the parent before exec.)
std::optional<double> peak_mib(const fs::path& process) {
  std::ifstream stream(process / "status");
  for (std::string word; stream >> word;) {
    double kib = 0;
    if (word == "VmHWM:" && stream >> kib) return kib / 1024;
  }
  return std::nullopt;
}

void add(const fs::path& process, std::optional<HostUsage>& sum) {
  const std::optional<double> peak = peak_mib(process);
  if (!peak) return;
  if (!sum) sum.emplace();
  sum->cpu_seconds += cpu_seconds(process);
  sum->peak_mib += *peak;
}

}  // namespace

RunUsage host_usage() {
  RunUsage usage;
  rusage own{};
  ::getrusage(RUSAGE_SELF, &own);
  for (const timeval& part : {own.ru_utime, own.ru_stime})
    usage.program.cpu_seconds += static_cast<double>(part.tv_sec) + 1e-6 * static_cast<double>(part.tv_usec);
  usage.program.peak_mib = static_cast<double>(own.ru_maxrss) / 1024;  // KiB
  std::error_code none;
  for (const auto& thread : fs::directory_iterator("/proc/self/task", none)) {
    std::ifstream children(thread.path() / "children");
    for (std::string child; children >> child;) add(fs::path("/proc") / child, usage.boards);
  }
  return usage;
}

nlohmann::ordered_json to_json(const RunUsage& usage) {
  nlohmann::ordered_json json;
  json["program_cpu_s"] = usage.program.cpu_seconds;
  json["program_peak_mib"] = usage.program.peak_mib;
  json["board_cpu_s"] = usage.boards ? nlohmann::ordered_json(usage.boards->cpu_seconds) : nullptr;
  json["board_peak_mib"] = usage.boards ? nlohmann::ordered_json(usage.boards->peak_mib) : nullptr;
  return json;
}

}  // namespace gicube::samples
