#include "render/hosts.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "gicube/error.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

constexpr int kFailed = 1, kWrongUsage = 2;
constexpr const char* kLibrary = "libgicube-mpi.so." GICUBE_SOVERSION;

// All ranks know of the error, and the first one prints it.
struct Agreed : std::runtime_error {
  Agreed(const std::string& text, int exit_code) : std::runtime_error(text), code(exit_code) {}
  int code;
};

// MPI's own plug-ins look for its names among the global ones.
void* load_library() {
  constexpr int kHow = RTLD_NOW | RTLD_GLOBAL;
  std::error_code none;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::filesystem::path beside = program.parent_path() / GICUBE_PROGRAMS_TO_LIBRARIES / kLibrary;
  if (std::filesystem::exists(beside, none)) return ::dlopen(beside.c_str(), kHow);
  return ::dlopen(kLibrary, kHow);
}

}  // namespace

bool asks_for_hosts(int argc, const char* const* argv) {
  return std::any_of(argv + std::min(argc, 1), argv + argc,
                     [](std::string_view word) { return word == "--mpi" || word.starts_with("--mpi="); });
}

std::unique_ptr<MpiExchange> open_hosts() {
  void* const library = load_library();
  void* const open = library != nullptr ? ::dlsym(library, "gicube_mpi_open") : nullptr;
  if (open == nullptr) {
    throw Error(fmt::format("--mpi: expected {}, which the package gicube-mpi has, got: {}", kLibrary, ::dlerror()));
  }
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
        std::chrono::milliseconds(100));  // chosen: the launcher forwards it before all are ended
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
  const char* const against = options.plan.wanted()                               ? "--max-error or --time-budget"
                              : options.crop                                      ? "--crop"
                              : options.level_of_detail > 0                       ? "--level-of-detail"
                              : options.explain_pixel                             ? "--explain-pixel"
                              : !options.lighting.field.empty()                   ? "--irradiance"
                              : options.checkpoint.unit || !board.restore.empty() ? "--checkpoint or --restore"
                                                                                  : nullptr;
  if (against != nullptr) throw UsageError(std::string("--mpi: expected without ") + against);
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
