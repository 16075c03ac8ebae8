#include "gicube/composited_ranks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "board/picture_parts.h"
#include "board/state.h"
#include "encode/argument.h"
#include "encode/camera.h"
#include "radix_k.h"
#include "volume_parts.h"

namespace gicube {
namespace {

void check_can_be_composited(const View& view) {
  check(view);
  constexpr const char* kOff = "false in a picture that is composited";
  if (view.jitter) throw BadArgument("jitter", kOff, "true");
  if (view.irradiance) throw BadArgument("irradiance", kOff, "true");
  if (view.scatter) throw BadArgument("scatter", kOff, "true");
  expect(view.samples_per_axis == 1, "samples_per_axis", "1 in a picture that is composited", view.samples_per_axis);
}

// Puts the picture's rows into a whole picture, from pixel `at` on.
void put(const Image& image, std::size_t at, std::vector<FloatPixel>& whole) {
  for (const Pixel& pixel : image.pixels) {
    whole[at++] = {static_cast<float>(pixel.red) / 255, static_cast<float>(pixel.green) / 255,
                   static_cast<float>(pixel.blue) / 255, static_cast<float>(pixel.alpha) / 4095};
  }
}

// The lowest strip that has these rows, of a picture of so many: one of strips of equal height from the top, as a render command names them.
struct Strip {
  int rows = 0, number = 0;
};
Strip strip_of(std::pair<int, int> rows, int height) {
  constexpr int kMost = 255;  // a command counts them with 8 bits
  const auto [first, end] = rows;
  int high = std::max(end - first, (height + kMost - 1) / kMost);
  while (first / high != (end - 1) / high) ++high;
  return {high, first / high};
}

wire::Pixel as_words(const FloatPixel& pixel) {
  const auto word = [](float value, float one) { return std::lround(std::clamp(value, 0.0F, 1.0F) * one); };
  return {static_cast<std::uint8_t>(word(pixel.red, 255)), static_cast<std::uint8_t>(word(pixel.green, 255)),
          static_cast<std::uint8_t>(word(pixel.blue, 255)), static_cast<std::uint16_t>(word(pixel.alpha, 4095))};
}

}  // namespace

struct GICUBE_HIDDEN CompositedRanks::State {
  State(Board& of_rank, RayExchange& between) : board(of_rank), exchange(between) {}

  Board& board;
  RayExchange& exchange;
  std::vector<std::uint8_t> flags;  // the board's own, of which `costs` are
  std::vector<double> costs;        // one a block
  std::vector<RankReport> reports;

  VolumeParts deal(const View& view);
  std::vector<FloatPixel> render_part(const VolumeParts& parts, const View& view, const Progress& progress,
                                      RankReport& report);
  void gather_reports(const RankReport& own);
  void learn(const VolumeParts& parts);
};

VolumeParts CompositedRanks::State::deal(const View& view) {
  std::vector<std::uint8_t> now = board.empty_flags();
  if (now != flags) {
    costs.clear();
    for (const std::uint8_t empty : now) costs.push_back(empty == 0);
    flags = std::move(now);
  }
  const std::array up{std::abs(view.up.x), std::abs(view.up.y), std::abs(view.up.z)};
  const auto upright = static_cast<std::size_t>(std::ranges::max_element(up) - up.begin());
  return VolumeParts(board.blocks(), costs, exchange.ranks(), upright);
}

// Of the whole size, though it is rendered where the part may be seen.
std::vector<FloatPixel> CompositedRanks::State::render_part(const VolumeParts& parts, const View& view,
                                                            const Progress& progress, RankReport& report) {
  std::vector<FloatPixel> pixels(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
  std::vector<std::uint8_t> leapt_over(flags.size(), 1);
  parts.for_each_block(exchange.rank(), [&](std::size_t block) {
    leapt_over[block] = flags[block];
    report.blocks += flags[block] == 0;
  });
  Board::State& s = *board.state_;
  const wire::RenderCommand camera = viewing_command(view, s.volume->relative_spacing);
  const std::pair rows = parts.rows(exchange.rank(), camera, s.info.block_voxels);
  if (report.blocks == 0 || rows.first >= rows.second) return pixels;
  Board::State::PicturePart part;
  Strip strip = strip_of(rows, view.height);
  if (strip.rows < view.height && s.device.agreed().minor >= wire::kPartsMinor) {
    part = {static_cast<std::uint16_t>(strip.rows), static_cast<std::uint8_t>(strip.number),
            static_cast<std::uint8_t>((view.height + strip.rows - 1) / strip.rows)};
  } else {
    strip = {};
  }
  View leaping = view;
  leaping.leap = true;
  const std::uint64_t before = board.counters().value("pipeline.samples");
  const Picoseconds begin = board.now();
  try {
    board.set_empty_flags(leapt_over);
    {
      const auto lock = s.begin();
      s.render(leaping, part, progress);
      put(s.read_picture(), static_cast<std::size_t>(strip.rows) * static_cast<std::size_t>(strip.number * view.width),
          pixels);
    }
    report.work = board.now() - begin;
  } catch (...) {  // also of the caller's progress
    try {
      board.set_empty_flags(flags);
    } catch (const Error&) {  // the board is lost, and its flags with it
    }
    throw;
  }
  board.set_empty_flags(flags);
  report.samples = board.counters().value("pipeline.samples") - before;
  return pixels;
}

void CompositedRanks::State::gather_reports(const RankReport& own) {
  std::vector<std::uint8_t> message(sizeof own);
  std::memcpy(message.data(), &own, sizeof own);
  const auto all = exchange.exchange(std::vector(static_cast<std::size_t>(exchange.ranks()), message));
  reports.clear();
  for (const auto& each : all) {
    RankReport& report = reports.emplace_back();
    if (each.size() != sizeof report) throw Error("another rank's report is cut off: are all ranks of one version?");
    std::memcpy(&report, each.data(), sizeof report);
  }
}

// Costs are half of what they were, and half what was measured, spread over each part as its costs were: simulated time, or samples where
// these take none.
void CompositedRanks::State::learn(const VolumeParts& parts) {
  const bool timed = board.info().fidelity != Fidelity::kFunctional;
  const auto measure = [timed](const RankReport& report) {
    return timed ? to_ms(report.work) : static_cast<double>(report.samples);
  };
  double measured = 0;
  for (const RankReport& report : reports) measured += measure(report);
  const double all = std::accumulate(costs.begin(), costs.end(), 0.0);
  if (measured == 0 || all == 0) return;
  for (int rank = 0; rank < exchange.ranks(); ++rank) {
    double cost = 0;
    parts.for_each_block(rank, [&](std::size_t block) { cost += costs[block]; });
    if (cost == 0) continue;
    const double share = measure(reports[static_cast<std::size_t>(rank)]) / measured;
    const double factor = 0.5 * (1 / all + share / cost);
    parts.for_each_block(rank, [&](std::size_t block) { costs[block] *= factor; });
  }
}

CompositedRanks::CompositedRanks(Board& board, RayExchange& exchange)
    : state_(std::make_unique<State>(board, exchange)) {}
CompositedRanks::CompositedRanks(CompositedRanks&&) noexcept = default;
CompositedRanks& CompositedRanks::operator=(CompositedRanks&&) noexcept = default;
CompositedRanks::~CompositedRanks() = default;

Image CompositedRanks::render(const View& view, const Progress& progress) {
  State& s = *state_;
  check_can_be_composited(view);
  s.board.state_->need_all_blocks("CompositedRanks::render()");
  RankReport report;
  const VolumeParts parts = s.deal(view);
  std::vector<FloatPixel> pixels = s.render_part(parts, view, progress, report);
  const std::vector<int> order = parts.front_to_back(view, s.board.info().block_voxels);
  pixels =
      composite(s.exchange, order, std::move(pixels), static_cast<float>(view.opacity_threshold), report.bytes_sent);
  s.gather_reports(report);
  s.learn(parts);
  Image image{view.width, view.height, {}};
  if (pixels.empty()) return {};
  image.pixels.resize(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) take_pixel(as_words(pixels[i]), image.pixels[i]);
  return image;
}

const std::vector<RankReport>& CompositedRanks::reports() const { return state_->reports; }

}  // namespace gicube
