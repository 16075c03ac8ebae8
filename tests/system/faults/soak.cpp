#include "soak.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <fstream>
#include <functional>
#include <optional>
#include <random>
#include <stdexcept>

#include "board_process.h"
#include "good_client.h"
#include "server/faults/fault_plan.h"
#include "temporary_directory.h"

namespace gicube::system_test {
namespace {

// Equal for equal bits.
std::uint64_t digest(const TracedRay& ray) {
  std::uint64_t hash = 0xCBF29CE484222325u ^ ray.id;
  const std::array values{ray.position.x,  ray.position.y, ray.position.z, ray.direction.x, ray.direction.y,
                          ray.direction.z, ray.colour[0],  ray.colour[1],  ray.colour[2],   ray.opacity};
  for (const double value : values) hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001B3u;
  return hash;
}

std::vector<std::uint64_t> digests(const std::vector<TracedRay>& rays) {
  std::vector<std::uint64_t> all;
  for (const TracedRay& ray : rays) all.push_back(digest(ray));
  return all;
}

// The plan of one process: faults of the link and of the memory by chance, and its end.
std::string plan_text(const SoakPlan& plan, std::uint32_t process) {
  std::mt19937_64 random(plan.seed * 1000 + process);
  const std::uint64_t seed = random();
  std::string text = fmt::format(
      "random {{ seed: {} kinds: [drop, delay, corrupt, duplicate, hang, link_loss, slow] mean_messages: {} "
      "max_delay_ms: 3 bytes_per_second: 20000000 slow_messages: 4 }}\n"
      "random {{ seed: {} kinds: [memory_detected, memory_silent] mean_messages: {} }}\n",
      seed, plan.link_mean, seed, plan.memory_mean);
  if (process == plan.kills) return text;
  // So that all processes together have most of the work: a batch is about two messages each way.
  const std::uint64_t share = 2 * plan.batches / (plan.kills + 1);
  text += fmt::format("fault {{ direction: down message: {} kind: kill }}\n", share / 2 + random() % share);
  return text;
}

class Soak {
 public:
  explicit Soak(const SoakPlan& plan) : plan_(plan) { find_expected(); }

 private:
  // Calls until it works: the errors that the plan explains are met with what an application does about them.
  template <typename Call>
  auto insist(const Call& call) {
    for (;;) {
      try {
        return call();
      } catch (const MemoryFault&) {
        ++report_.memory_faults;
      } catch (const DeviceLost&) {
        go_on();
      } catch (const TimedOut&) {
        go_on();
      }
    }
  }

 public:
  SoakReport run() {
    start_process();
    OpenOptions options;
    options.watchdog = std::chrono::milliseconds(plan_.watchdog_ms);
    // chosen: enough on a busy machine too. A call that is given up and made again is another message, and faults go by
    // their number.
    options.reopen_attempts = 12;
    options.keep_volume = true;
    board_.emplace(Board::open(uri(), options));
    insist([&] { prepare(*board_); });
    for (std::size_t first = 0; first < plan_.batches; first += plan_.group) {
      trace_group(first, std::min(plan_.group, plan_.batches - first));
    }
    const std::uint64_t counted = insist([&] { return board_->counters().value("dsp.host_rays"); });
    report_.carried_out_twice = counted - traced_;
    report_.peak_memory = process_->peak_memory();
    board_.reset();
    process_->send_signal(SIGTERM);
    process_->exit_code();
    read_log();
    for (const std::uint8_t times : accepted_) {
      report_.lost += times == 0 ? 1 : 0;
      report_.doubled += times > 1 ? 1 : 0;
    }
    return std::move(report_);
  }

 private:
  std::string uri() const { return "unix:" + folder_.file("board"); }
  std::string file(const std::string& name) const {
    return folder_.file(fmt::format("{}.{}", name, report_.processes));
  }

  void find_expected() {
    std::vector<std::string> arguments = small_board();
    arguments.insert(arguments.end(), {"--listen", uri()});
    BoardProcess process(arguments);
    process.read_line();
    Board board = Board::open(uri());
    prepare(board);
    for (std::size_t i = 0; i < plan_.batches; ++i) {
      const auto batch = digests(board.receive(board.submit(rays(i))).rays);
      expected_.insert(expected_.end(), batch.begin(), batch.end());
    }
    accepted_.resize(expected_.size());
  }

  std::vector<HostRay> rays(std::size_t batch) const { return good_rays(batch * plan_.rays, plan_.rays); }

  void start_process() {
    ++report_.processes;
    std::ofstream(file("plan")) << plan_text(plan_, static_cast<std::uint32_t>(report_.processes - 1));
    std::vector<std::string> arguments = small_board();
    arguments.insert(arguments.end(), {"--listen", uri(), "--faults", file("plan"), "--fault-log", file("log")});
    // In its box, as always, and with every limit.
    arguments.insert(arguments.end(),
                     {"--max-memory", "16", "--max-results", "8", "--max-connections", "4", "--max-connections-of-peer",
                      "3", "--max-wait", "60", "--max-command-time", "60"});
    process_.emplace(arguments);
    if (process_->read_line().empty()) throw std::runtime_error(process_->read_errors());
  }

  // Where the driver has given up: the board was killed, or was lost more often in a row than it tries again.
  void go_on() {
    for (;;) {
      if (process_->has_ended()) {
        replace_process();
      } else {
        ++report_.given_up;
      }
      try {
        board_->reopen();
        return;
      } catch (const DeviceLost&) {
      } catch (const TimedOut&) {
      } catch (const OpenFailed&) {  // killed once more, by a fault of the new plan
      }
    }
  }

  void replace_process() {
    if (process_->exit_code() != 128 + SIGKILL) throw std::runtime_error("the board ended, but was not killed");
    read_log();
    start_process();
    traced_ = 0;
  }

  void read_log() {
    std::ifstream stream(file("log"));
    std::vector<v1::PlannedFault> faults;
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const emu::ParsedFaultPlan parsed = emu::parse_fault_plan(text);
    if (!parsed.diagnostics.empty()) throw std::runtime_error("the log is no plan: " + to_string(parsed.diagnostics));
    for (const v1::PlannedFault& fault : parsed.plan.fault()) faults.push_back(fault);
    std::sort(faults.begin(), faults.end(), [](const auto& a, const auto& b) {
      return std::pair(a.direction(), a.message()) < std::pair(b.direction(), b.message());
    });
    report_.log += fmt::format("# process {}\n", report_.processes);
    for (const v1::PlannedFault& fault : faults) {
      report_.log += emu::to_text(fault) + "\n";
      ++report_.kinds[v1::PlannedFault::Kind_Name(fault.kind())];
      ++report_.faults;
    }
  }

  // A batch that met a memory error is gone, and is submitted anew.
  std::vector<TracedRay> receive(std::size_t batch, Ticket ticket) {
    for (;;) {
      try {
        std::vector<TracedRay> rays = board_->receive(ticket).rays;
        traced_ += rays.size();
        return rays;
      } catch (const MemoryFault&) {
        ++report_.memory_faults;
        ticket = insist([&] { return board_->submit(rays(batch)); });
      } catch (const DeviceLost&) {
        go_on();
      } catch (const TimedOut&) {
        go_on();
      }
    }
  }

  // The rays of a group are taken once the volume that they went through has been found sound. A board that took the
  // place of another on the way can't vouch for that one's volume.
  void trace_group(std::size_t first, std::size_t count) {
    for (;;) {
      const std::uint64_t process = report_.processes;
      std::vector<Ticket> tickets;
      for (std::size_t i = 0; i < count; ++i) {
        tickets.push_back(insist([&] { return board_->submit(rays(first + i)); }));
      }
      std::vector<std::vector<TracedRay>> results;
      for (std::size_t i = 0; i < count; ++i) results.push_back(receive(first + i, tickets[i]));
      const auto damaged = insist([&] { return board_->verify_volume(); });
      if (damaged.empty() && report_.processes == process) {
        for (std::size_t i = 0; i < count; ++i) accept(first + i, results[i]);
        return;
      }
      if (damaged.empty()) continue;
      ++report_.volumes_mended;
      static const GoodVolume volume;
      insist([&] { board_->load_volume(volume.view()); });
    }
  }

  void accept(std::size_t batch, const std::vector<TracedRay>& rays) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const std::size_t number = batch * plan_.rays + i;
      ++report_.rays;
      if (i >= plan_.rays) {
        ++report_.doubled;
        continue;
      }
      ++accepted_[number];
      if (digest(rays[i]) != expected_[number]) ++report_.wrong;
    }
  }

  const SoakPlan plan_;
  const reference::TemporaryDirectory folder_;
  std::vector<std::uint64_t> expected_;  // of each ray
  std::vector<std::uint8_t> accepted_;   // times
  std::uint64_t traced_ = 0;             // rays that the present process has returned
  SoakReport report_;
  std::optional<BoardProcess> process_;
  std::optional<Board> board_;
};

}  // namespace

SoakReport soak(const SoakPlan& plan) { return Soak(plan).run(); }

}  // namespace gicube::system_test
