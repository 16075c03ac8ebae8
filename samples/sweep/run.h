// One run of gicube-render: its command, the files that it leaves, and what they say.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace gicube::samples::sweep {

class RunFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// `program`: a path, or a name on the PATH. What it writes goes to the file `log`; it runs in `folder`, or in this process' own.
// Throws RunFailed unless it ends with exit code 0: how it ended, and the last line that it wrote.
void run_to_end(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                const std::filesystem::path& log, const std::filesystem::path& folder = {});

struct Run {
  std::vector<std::string> arguments;  // of gicube-render, without its output and statistics

  // Names the run in its folder: the same for equal arguments and an input file that has not changed.
  std::string key() const;
  // For a shell, with a picture and statistics of its own.
  std::string command() const;
};

// Where runs are kept: KEY.json, which is there once the run is done, KEY.exr and KEY.log.
class RunFolder {
 public:
  // Makes the folder. Throws FileError.
  explicit RunFolder(std::filesystem::path folder);

  std::filesystem::path statistics(const Run& run) const { return folder_ / (run.key() + ".json"); }
  std::filesystem::path picture(const Run& run) const { return folder_ / (run.key() + ".exr"); }
  std::filesystem::path log(const Run& run) const { return folder_ / (run.key() + ".log"); }
  bool has(const Run& run) const;

  // Runs `program` and waits. A run that is killed leaves nothing that has() could take for a result.
  // Throws RunFailed with the command, how it ended, and the last line that it wrote.
  void carry_out(const Run& run, const std::filesystem::path& program) const;

  // Throws FileError.
  nlohmann::json read(const Run& run) const;

 private:
  std::filesystem::path folder_;
};

// Carries out the runs that have no result yet, `jobs` at once (0 = one a core). `progress` gets the number of results; its calls
// do not overlap. After a failure no run starts; it is thrown when those under way have ended. Results stay.
void carry_out_all(const RunFolder& folder, const std::vector<Run>& runs, const std::filesystem::path& program,
                   int jobs, const std::function<void(std::size_t done)>& progress);

// A number of a run's statistics: a name of their first level, or a JSON pointer ("/counters/bus.up.bytes/value").
// Throws InputError if there is no such number.
double figure(const nlohmann::json& statistics, const std::string& name);
// NaN if there is none: what a fidelity level does not model.
double figure_or_nan(const nlohmann::json& statistics, const std::string& name);

}  // namespace gicube::samples::sweep
