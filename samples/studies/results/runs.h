// What is to be measured, and the measuring: runs are asked for by value, and carried out on emulated boards, several at
// a time.
//
// A page is written in passes: get() of a run not yet measured notes it down and gives an empty measurement; measure()
// carries out what was noted; the next pass reads it, and may ask for more that depends on it.
#pragma once

#include <cstdio>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "studies/results/figures.h"
#include "studies/results/scenes.h"

namespace gicube::samples::results {

using Settings = std::map<std::string, std::string>;  // of the board's configuration: path.to.field and value

struct Run {
  enum class Kind {
    kFrame,      // one rendering, image transfer included
    kLight,      // an illumination pass
    kHostRays,   // the view's rays made by the host, sent there and back
    kFillBlock,  // host rays through block (0, 0, 0), one in each column of cells along z
  };

  Kind kind = Kind::kFrame;
  SceneName scene = SceneName::kBuckyball;
  ViewName view = ViewName::kOblique;
  Dims dims{};   // voxels of the volume
  int edge = 0;  // voxels: what the scene's lengths refer to
  int width = 0, height = 0;
  double step = 0.5;
  double threshold = 0.98;
  bool leap = true;
  bool jitter = false;
  bool faint = false;  // no ray ever gets opaque: without early termination
  bool orthographic = false;
  int light_rays = 0;        // a face voxel, k, of the illumination pass before it (or that it is); 0 = none
  bool high_albedo = false;  // of that pass
  bool picture = false;      // keep the image; no part of the key
  Settings settings;

  // The same on a board configured otherwise, without a picture.
  Run with(const std::string& field, const std::string& value) const;
  Run with(const std::string& field, int value) const { return with(field, std::to_string(value)); }
  Run with(const Settings& more) const;

  // The same with samples that far apart, in voxels; without a picture unless it is the same run.
  Run at_step(double distance) const;

  // Runs of one key are the same; runs of one board_key share a board and its volume, those of one scene_key the volume.
  std::string key() const;
  std::string board_key() const;
  std::string scene_key() const;
};

// Says how far a long measurement is: on a terminal in place, else a line each tenth.
class ProgressMeter {
 public:
  explicit ProgressMeter(bool shown) : shown_(shown) {}
  void show(std::size_t done, std::size_t all, double seconds);

 private:
  bool shown_;
  std::size_t tenths_ = 0;
};

class Runs {
 public:
  explicit Runs(int jobs, bool quiet) : jobs_(jobs), quiet_(quiet) {}

  const Measurement& get(const Run& run);
  bool complete() const { return wanted_.empty(); }
  std::size_t measured() const { return known_.size(); }

  // Throws the driver's errors with the run's key before the message.
  void measure();

 private:
  int jobs_;
  bool quiet_;
  std::map<std::string, Measurement> known_;
  std::vector<Run> wanted_;  // in the order in which they were asked for
  std::set<std::string> noted_;
  Measurement nothing_;
};

}  // namespace gicube::samples::results
