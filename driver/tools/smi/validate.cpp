// gicube-smi validate: opens a board and tests it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "gicube/board.h"
#include "options.h"
#include "output.h"

namespace gicube::smi {
namespace {

constexpr std::chrono::seconds kWatchdog{60};  // chosen: the cycle level needs some seconds for its picture

constexpr int kEdge = 48;  // voxels, chosen: several blocks, and a second of work at most
constexpr std::size_t kVoxels = kEdge * kEdge * kEdge;
constexpr int kImageEdge = 64;  // pixels
// FNV-1a of the pixels of picture(), equal on all boards with the same datapath.
constexpr std::uint64_t kPaperPicture = 0x44fbf7347c2dc06f, kWidePicture = 0xfde891ec6a9120bd;
constexpr double kMinBusShare = 0.5;  // chosen: share of the bus's rate while a volume is loaded

// The board failed a test.
void fail_if(bool wrong, const std::string& what) {
  if (wrong) throw std::runtime_error(what);
}

void load(Board& board, const std::vector<std::uint16_t>& values) {
  const auto samples = std::as_bytes(std::span(values));
  board.load_volume({.samples = samples, .type = SampleType::kUint12, .dims = {kEdge, kEdge, kEdge}});
}

std::vector<std::uint16_t> voxels(const auto& value) {
  std::vector<std::uint16_t> values(kVoxels);
  for (std::size_t i = 0; i < kVoxels; ++i) {
    const int x = static_cast<int>(i % kEdge), y = static_cast<int>(i / kEdge % kEdge),
              z = static_cast<int>(i / kEdge / kEdge);
    values[i] = static_cast<std::uint16_t>(value(x, y, z));
  }
  return values;
}

std::string clock(Board& board) {
  const Picoseconds begin = board.now();
  board.host_compute(1'000'000'000);
  fail_if(board.now() != begin + 1'000'000'000,
          fmt::format("1 ms of host work moved the clock by {} ps", board.now() - begin));
  const Counters counters = board.counters();
  fail_if(counters.list().empty(), "the board has no counters");
  return fmt::format("host work moves the clock; {} counters", counters.list().size());
}

// Tests each bit of each voxel as 0 and as 1, with equal and with other neighbours.
std::string memory(Board& board) {
  using Pattern = int (*)(int, int, int);
  const std::array<std::pair<const char*, Pattern>, 4> patterns{
      {{"checkerboard", [](int x, int y, int z) { return (x + y + z) % 2 == 0 ? 0x555 : 0xAAA; }},
       {"its inverse", [](int x, int y, int z) { return (x + y + z) % 2 == 0 ? 0xAAA : 0x555; }},
       {"walking ones", [](int x, int y, int z) { return 1 << (x + 3 * y + 5 * z) % 12; }},
       {"addresses", [](int x, int y, int z) { return (x * 131 + y * 71 + z * 1031) & 0xFFF; }}}};
  for (const auto& [name, pattern] : patterns) {
    const std::vector<std::uint16_t> written = voxels(pattern);
    load(board, written);
    const std::vector<float> read = board.read_volume({.low = {0, 0, 0}, .size = {kEdge, kEdge, kEdge}});
    fail_if(read.size() != kVoxels, fmt::format("{}: {} voxels came back, not {}", name, read.size(), kVoxels));
    std::size_t wrong = 0, first = 0;
    for (std::size_t i = kVoxels; i-- > 0;) {
      if (std::lround(read[i]) == written[i]) continue;
      ++wrong;
      first = i;
    }
    fail_if(wrong > 0, fmt::format("{}: {} of {} voxels differ, the first is voxel {}: 0x{:03x}, not 0x{:03x}", name,
                                   wrong, kVoxels, first, std::lround(read[first]), written[first]));
  }
  return fmt::format("{} patterns in {} voxels", patterns.size(), kVoxels);
}

std::string checksums(Board& board) {
  const std::vector<std::size_t> wrong = board.verify_volume();
  fail_if(!wrong.empty(), fmt::format("{} blocks are not as they were sent, the first is block {}", wrong.size(),
                                      wrong.empty() ? 0 : wrong.front()));
  const Dims blocks = board.blocks();
  return fmt::format("{} blocks are as they were sent", blocks[0] * blocks[1] * blocks[2]);
}

Image picture(Board& board) {
  load(board, voxels([](int x, int y, int z) {
         const double radius = length(Vec3{x - 23.5, y - 23.5, z - 23.5});
         return std::clamp(static_cast<int>(4095 - radius * 180), 0, 4095);
       }));
  board.set_transfer_function({.colours = {{0, {0.2, 0.4, 1.0}}, {1500, {0.2, 1.0, 0.4}}, {3000, {1.0, 0.5, 0.2}}},
                               .opacities = {{200, 0.0}, {900, 0.04}, {2500, 0.05}, {3000, 0.6}}});
  View view;
  view.width = view.height = kImageEdge;
  view.eye = {100, 80, -60};
  view.look_at = {23.5, 23.5, 23.5};
  return board.render(view);
}

std::string known_picture(Board& board) {
  const Image image = picture(board);
  std::uint64_t hash = 0xcbf29ce484222325;
  std::size_t visible = 0;
  for (const auto& [red, green, blue, alpha] : image.pixels) {
    visible += alpha > 0 ? 1 : 0;
    for (const unsigned part : {unsigned{red}, unsigned{green}, unsigned{blue}, unsigned{alpha}}) {
      for (const unsigned byte : {part & 0xFF, part >> 8}) hash = (hash ^ byte) * 0x100000001b3;
    }
  }
  const std::uint64_t known = board.info().wide ? kWidePicture : kPaperPicture;
  fail_if(hash != known, fmt::format("{}x{} pixels, {} of them not empty, hash {:016x}, not {:016x}", image.width,
                                     image.height, visible, hash, known));
  return fmt::format("{}x{} pixels, each bit as on every other board of its datapath", image.width, image.height);
}

// The opacity of a homogeneous medium is known.
std::string rays(Board& board) {
  constexpr double kOpacity = 0.02;  // of a voxel
  load(board, voxels([](int, int, int) { return 2000; }));
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, kOpacity}}});
  std::vector<HostRay> sent;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    sent.push_back(
        {.id = 7 * i, .position = {1. + i % 40, static_cast<double>(1 + i / 40), 0}, .direction = {0, 0, 1}});
  }
  const Picoseconds begin = board.now();
  const RayBatch batch = board.receive(board.submit(sent));
  fail_if(batch.rays.size() != sent.size(), fmt::format("{} rays came back of {}", batch.rays.size(), sent.size()));
  const double expected = 1 - std::pow(1 - kOpacity, kEdge - 1);
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const TracedRay& ray = batch.rays[i];
    fail_if(ray.id != sent[i].id, fmt::format("ray {} came back with id {}, not {}", i, ray.id, sent[i].id));
    fail_if(std::abs(ray.opacity - expected) > 0.02,
            fmt::format("ray {} has opacity {:.4f}, expected {:.4f}", i, ray.opacity, expected));
  }
  return fmt::format("{} there and back in {}, opacity {:.4f}", sent.size(),
                     time_text(static_cast<double>(board.now() - begin)), batch.rays.front().opacity);
}

std::string bandwidth(Board& board) {
  const std::vector<std::uint16_t> values = voxels([](int x, int y, int z) { return 1 + x + y + z; });
  const Counters before = board.counters();
  load(board, values);
  const Counters window = board.counters() - before;
  const double bytes = static_cast<double>(window.value("bus.down.bytes"));
  const double seconds = static_cast<double>(window.value("bus.down.busy_ps")) * 1e-12;
  fail_if(bytes <= 0 || seconds <= 0, "loading a volume did not use the bus");
  const double rate = bytes / seconds;
  double peak = 133.4e6;  // PCI, and its multiples on AGP
  while (peak < rate && peak < 1e9) peak *= 2;
  const std::string seen = fmt::format("{}/s of the bus's {}/s", bytes_text(rate), bytes_text(peak));
  fail_if(rate > peak * 1.01 || rate < kMinBusShare * peak, seen);
  return seen;
}

std::string refusals(Board& board) {
  const std::vector<HostRay> outside{{.id = 1, .position = {-1, 0, 0}, .direction = {0, 0, 1}}};
  try {
    board.submit(outside);
    fail_if(true, "a ray from outside the volume was accepted");
  } catch (const BadArgument&) {
  }
  const std::vector<HostRay> inside{{.id = 2, .position = {1, 1, 1}, .direction = {0, 0, 1}}};
  fail_if(board.receive(board.submit(inside)).rays.size() != 1, "no ray came back after a refusal");
  return "a bad ray is refused, and the next one comes back";
}

// In this order; after each the board is usable for the next. run() returns the observed result, or throws.
struct Check {
  const char* name;
  std::string (*run)(Board&);
};
constexpr Check kChecks[] = {{"clock", clock},           {"memory", memory}, {"checksums", checksums},
                             {"picture", known_picture}, {"rays", rays},     {"bandwidth", bandwidth},
                             {"refusals", refusals}};

struct Result {
  std::string name;
  const char* outcome;  // one of the three
  std::string details;

  static constexpr const char *kPass = "pass", *kFail = "FAIL", *kSkipped = "skipped";
};

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

std::vector<Result> run_all(const std::string& uri) {
  std::vector<Result> results;
  std::optional<Board> board;
  try {
    OpenOptions options;
    options.watchdog = kWatchdog;
    board.emplace(Board::open(uri, options));
    const BoardInfo& info = board->info();
    results.push_back({"open", Result::kPass,
                       fmt::format("{} level, {} processors, volumes to {}^3, protocol {}.{}", name_of(info.fidelity),
                                   info.processors, info.max_volume_voxels, info.protocol_major, info.protocol_minor)});
  } catch (const Error& error) {
    results.push_back({"open", Result::kFail, one_line(error.what())});
  }
  bool lost = !board;
  for (const Check& check : kChecks) {
    if (lost) {
      results.push_back({check.name, Result::kSkipped, "there is no board"});
      continue;
    }
    try {
      results.push_back({check.name, Result::kPass, check.run(*board)});
    } catch (const std::exception& error) {
      results.push_back({check.name, Result::kFail, one_line(error.what())});
      lost = dynamic_cast<const DeviceLost*>(&error) != nullptr || dynamic_cast<const TimedOut*>(&error) != nullptr;
    }
  }
  return results;
}

}  // namespace

int validate(const Options& options) {
  const std::vector<Result> results = run_all(options.uri);
  const auto passed = static_cast<std::size_t>(std::ranges::count(results, Result::kPass, &Result::outcome));
  const bool good = passed == results.size();
  if (options.json) {
    nlohmann::ordered_json tests = nlohmann::ordered_json::array();
    for (const Result& result : results) {
      tests.push_back({{"name", result.name}, {"result", result.outcome}, {"details", result.details}});
    }
    print({{"uri", options.uri}, {"passed", good}, {"tests", std::move(tests)}});
    return good ? 0 : 1;
  }
  Table table({{"TEST"}, {"RESULT"}, {"WHAT WAS SEEN"}});
  for (const Result& result : results) table.add({result.name, result.outcome, result.details});
  fmt::print("{}{} of {} tests passed\n", table.text(), passed, results.size());
  return good ? 0 : 1;
}

}  // namespace gicube::smi
