#include "studies/results/runs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <mutex>

#include "scene/parallel.h"
#include "studies/results/carry_out.h"

namespace gicube::samples::results {
namespace {

// Runs of one board, in the order in which they were asked for: what the caches hold passes from one to the next, so
// the order is part of the result.
using Group = std::vector<Run>;

std::vector<Group> grouped(const std::vector<Run>& runs) {
  std::vector<Group> groups;
  std::map<std::string, std::size_t> place;
  for (const Run& run : runs) {
    const auto [at, fresh] = place.try_emplace(run.board_key(), groups.size());
    if (fresh) groups.emplace_back();
    groups[at->second].push_back(run);
  }
  return groups;
}

}  // namespace

Run Run::with(const std::string& field, const std::string& value) const {
  Run other = *this;
  other.settings[field] = value;
  other.picture = false;
  return other;
}

Run Run::with(const Settings& more) const {
  Run other = *this;
  for (const auto& [field, value] : more) other = other.with(field, value);
  return other;
}

Run Run::at_step(double distance) const {
  Run other = *this;
  other.picture = picture && distance == step;
  other.step = distance;
  return other;
}

std::string Run::scene_key() const {
  return fmt::format("{} {}x{}x{} of {}", name_of(scene), dims[0], dims[1], dims[2], edge);
}

std::string Run::board_key() const {
  std::string text = (faint ? "faint " : "") + scene_key();
  if (light_rays > 0) text += fmt::format(" lit by {} rays in {} albedo", light_rays, high_albedo ? "high" : "low");
  if (kind == Kind::kFillBlock) text += fmt::format(" one block, step {}", step);  // its cache must be cold
  for (const auto& [field, value] : settings) text += fmt::format(" {}={}", field, value);
  return text;
}

std::string Run::key() const {
  if (kind == Kind::kLight)
    return fmt::format("{}: illumination pass, step {}{}{}", board_key(), step, leap ? "" : " without leaps",
                       jitter ? " jittered" : "");
  return fmt::format("{}: {}{} {}x{} step {} threshold {}{}{}{}", board_key(), name_of(view),
                     orthographic ? " (parallel)" : "", width, height, step, threshold, leap ? "" : " without leaps",
                     jitter ? " jittered" : "", kind == Kind::kHostRays ? " host rays" : "");
}

void ProgressMeter::show(std::size_t done, std::size_t all, double seconds) {
  if (!shown_ || all == 0) return;
  const bool terminal = ::isatty(::fileno(stderr)) != 0;
  const std::size_t tenths = 10 * done / all;
  if (!terminal && tenths == tenths_) return;
  tenths_ = tenths;
  const double left = done == 0 ? 0 : seconds * static_cast<double>(all - done) / static_cast<double>(done);
  fmt::print(stderr, "{}results: {} of {} runs, {:.0f} s, about {:.0f} s to go{}", terminal ? "\r\x1b[K" : "", done,
             all, seconds, left, terminal && done < all ? "" : "\n");
  std::fflush(stderr);
}

const Measurement& Runs::get(const Run& run) {
  const std::string key = run.key();
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  if (noted_.insert(key).second) wanted_.push_back(run);
  return nothing_;
}

void Runs::measure() {
  const std::vector<Group> groups = grouped(wanted_);
  const std::size_t all = wanted_.size();
  const auto start = std::chrono::steady_clock::now();
  ProgressMeter meter(!quiet_);
  SceneStore scenes;
  std::mutex mutex;
  std::size_t done = 0;
  const auto keep = [&](const Run& run, Measurement measurement) {
    const std::lock_guard lock(mutex);
    known_[run.key()] = std::move(measurement);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    meter.show(++done, all, seconds.count());
  };
  in_parallel(groups.size(), jobs_, [&](std::size_t i) { carry_out(groups[i], scenes, keep); });
  wanted_.clear();
  noted_.clear();
}

}  // namespace gicube::samples::results
