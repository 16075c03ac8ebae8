#include "render/hosts.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "gicube/error.h"
#include "scene/common/plug_in.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

constexpr int kFailed = 1, kWrongUsage = 2;

// An error that all ranks have; the first one prints it.
struct Agreed : std::runtime_error {
  Agreed(const std::string& text, int exit_code) : std::runtime_error(text), code(exit_code) {}
  int code;
};

}  // namespace

bool asks_for_hosts(int argc, const char* const* argv) {
  return std::any_of(argv + std::min(argc, 1), argv + argc,
                     [](std::string_view word) { return word == "--mpi" || word.starts_with("--mpi="); });
}

std::unique_ptr<MpiExchange> open_hosts() {
  // MPI's own plug-ins need its symbols to be global.
  std::string error;
  void* const open = function_in("mpi", "gicube_mpi_open", RTLD_NOW | RTLD_GLOBAL, error);
  if (open == nullptr) throw Error("--mpi: expected libgicube-mpi.so, which the package gicube-mpi has, got: " + error);
  return std::unique_ptr<MpiExchange>(reinterpret_cast<decltype(&gicube_mpi_open)>(open)());
}

int run_rank(MpiExchange& ranks, const std::function<int()>& body) {
  try {
    return body();
  } catch (const Agreed& error) {
    if (ranks.rank() == 0) std::cerr << "gicube-render: " << error.what() << '\n';
    return error.code;
  } catch (const std::exception& error) {
    std::cerr << fmt::format("gicube-render: rank {} of {}: {}\n", ranks.rank(), ranks.ranks(), error.what())
              << std::flush;
    std::this_thread::sleep_for(
        std::chrono::milliseconds(100));  // chosen: the launcher forwards the text before it ends all ranks
    ranks.abort(kFailed);
    return kFailed;
  }
}

void together(RayExchange* ranks, const std::function<void()>& step) {
  if (ranks == nullptr) return step();
  std::string error;
  int code = kFailed;
  try {
    step();
  } catch (const UsageError& wrong) {
    error = wrong.what();
    code = kWrongUsage;
  } catch (const std::exception& failed) {
    error = failed.what();
  }
  const std::vector<std::uint8_t> text(error.begin(), error.end());
  const auto errors = ranks->exchange(std::vector(static_cast<std::size_t>(ranks->ranks()), text));
  const auto first = std::ranges::find_if(errors, [](const auto& each) { return !each.empty(); });
  if (first == errors.end()) return;
  const std::string what(first->begin(), first->end());
  if (std::ranges::all_of(errors, [&](const auto& each) { return each == *first; })) throw Agreed(what, code);
  throw Agreed(fmt::format("rank {} of {}: {}", first - errors.begin(), ranks->ranks(), what), kFailed);
}

void choose_part(const RayExchange& ranks, RenderOptions& options) {
  BoardOptions& board = options.board;
  const auto count = static_cast<std::size_t>(ranks.ranks()), rank = static_cast<std::size_t>(ranks.rank());
  if (board.board.find("boards=") != std::string::npos) {
    throw UsageError("--mpi: expected one board a rank, got emu:?boards=");
  }
  if (!board.others.empty() || !board.board.starts_with("emu:")) {
    if (board.others.size() + 1 != count) {
      throw UsageError(fmt::format("--board: expected one for each of {} ranks, or one emu: for all, got {}", count,
                                   board.others.size() + 1));
    }
    if (rank > 0) board.board = board.others[rank - 1];
    board.others.clear();
  }
  expect_without(options, "--mpi",
                 {"--max-error or --time-budget", "--crop", "--level-of-detail", "--irradiance", "--explain-pixel",
                  "--checkpoint or --restore"});
  if (rank > 0) {
    board.quiet = true;
    board.stats.clear();
  }
}

void share_statistics(RayExchange& ranks, FrameStatistics& statistics) {
  const Counters& counters = statistics.counters;
  const RankStatistics own{statistics.frame, bus_ms(counters), counters.value("pipeline.samples"),
                           counters.value("dsp.forwarded_rays"), statistics.bytes_sent};
  std::vector<std::vector<std::uint8_t>> to(static_cast<std::size_t>(ranks.ranks()));
  to[0].resize(sizeof own);
  std::memcpy(to[0].data(), &own, sizeof own);
  for (const auto& bytes : ranks.exchange(std::move(to))) {
    if (bytes.size() != sizeof own) continue;  // to other ranks than the first
    RankStatistics& each = statistics.ranks.emplace_back();
    std::memcpy(&each, bytes.data(), sizeof each);
    statistics.frame = std::max(statistics.frame, each.work);
  }
}

}  // namespace gicube::samples
