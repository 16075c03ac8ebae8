#include "sweep/run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <mutex>

#include "gicube/parallel_for.h"
#include "gicube/scene/error.h"
#include "scene/names.h"

extern char** environ;  // POSIX has it in no header

namespace gicube::samples::sweep {
namespace {

// FNV-1a.
std::uint64_t hash(const std::string& text) {
  std::uint64_t sum = 0xcbf29ce484222325;
  for (const char c : text) sum = (sum ^ static_cast<std::uint8_t>(c)) * 0x100000001b3;
  return sum;
}

std::string quoted(const std::string& argument) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=.,:/+@%";
  if (!argument.empty() && argument.find_first_not_of(kPlain) == std::string::npos) return argument;
  std::string out = "'";
  for (const char c : argument) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string last_line(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line, last = "it wrote nothing";
  while (std::getline(stream, line)) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace

void run_to_end(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                const std::filesystem::path& log, const std::filesystem::path& folder) {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::string log_file = std::filesystem::absolute(log).string();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, log_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  if (!folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t child = -1;
  const int failed = ::posix_spawnp(&child, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw RunFailed(program.string() + ": " + std::strerror(failed));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  throw RunFailed(WIFEXITED(status) ? fmt::format("exit code {}: {}", WEXITSTATUS(status), last_line(log))
                                    : fmt::format("ended by signal {}", WTERMSIG(status)));
}

std::string Run::key() const {
  std::string all;
  for (const std::string& argument : arguments) all += argument + '\n';
  std::error_code none;
  if (!arguments.empty() && std::filesystem::is_regular_file(arguments.front(), none)) {
    const auto written = std::filesystem::last_write_time(arguments.front(), none).time_since_epoch().count();
    all += fmt::format("{} {}", std::filesystem::file_size(arguments.front(), none), written);
  }
  return fmt::format("{:016x}", hash(all));
}

std::string Run::command() const {
  std::string text = "gicube-render";
  for (const std::string& argument : arguments) text.append(1, ' ').append(quoted(argument));
  return text + " -o picture.exr --stats run.json";
}

RunFolder::RunFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw FileError(folder_, "folder", "one that can be made", error.message());
}

bool RunFolder::has(const Run& run) const { return std::filesystem::exists(statistics(run)); }

void RunFolder::carry_out(const Run& run, const std::filesystem::path& program) const {
  const std::filesystem::path picture_part = folder_ / (run.key() + ".part.exr"),
                              statistics_part = folder_ / (run.key() + ".part.json");
  std::vector<std::string> arguments = run.arguments;
  arguments.insert(arguments.end(), {"-o", picture_part.string(), "--stats", statistics_part.string(), "--quiet"});
  try {
    run_to_end(program, arguments, log(run));
  } catch (const RunFailed& failure) {
    for (const auto& part : {picture_part, statistics_part}) std::filesystem::remove(part);
    throw RunFailed(run.command() + "\n  " + failure.what());
  }
  std::filesystem::rename(picture_part, picture(run));
  std::filesystem::rename(statistics_part, statistics(run));  // last: it says that the run is done
}

nlohmann::json RunFolder::read(const Run& run) const {
  std::ifstream stream(statistics(run));
  nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
  if (!json.is_object()) throw FileError(statistics(run), "statistics", "a JSON object", "something else");
  return json;
}

void carry_out_all(const RunFolder& folder, const std::vector<Run>& runs, const std::filesystem::path& program,
                   int jobs, const std::function<void(std::size_t done)>& progress) {
  std::vector<Run> left;
  std::ranges::copy_if(runs, std::back_inserter(left), [&](const Run& run) { return !folder.has(run); });
  std::size_t done = runs.size() - left.size();
  std::mutex mutex;
  progress(done);
  parallel_for(left.size(), static_cast<unsigned>(jobs), [&](std::size_t i) {
    folder.carry_out(left[i], program);
    const std::lock_guard lock(mutex);
    progress(++done);
  });
}

double figure_or_nan(const nlohmann::json& statistics, const std::string& name) {
  try {
    const nlohmann::json& value =
        name.starts_with('/') ? statistics.at(nlohmann::json::json_pointer(name)) : statistics.at(name);
    if (value.is_number()) return value.get<double>();
  } catch (const nlohmann::json::exception&) {
    // Not there, or no pointer.
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double figure(const nlohmann::json& statistics, const std::string& name) {
  const double value = figure_or_nan(statistics, name);
  if (std::isnan(value)) throw InputError(name, "a number in the run's statistics", "none of that name");
  return value;
}

}  // namespace gicube::samples::sweep
