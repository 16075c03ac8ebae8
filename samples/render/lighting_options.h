// The options of gicube-render about global illumination, and about pictures at several times.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace gicube::samples {

// What is not set is left to the scene.
struct LightingOptions {
  std::string illumination;  // none, low, high; empty: the scene's
  std::string rules;         // conserving, as-printed; empty: the scene's
  std::optional<int> rays;   // k, a face voxel
  std::optional<int> lifetime;
  std::optional<double> exposure;
  bool colour_passes = false;
  std::filesystem::path field;  // light that is known already, in place of lighting rays; empty: none
};

struct AnimationOptions {
  std::optional<double> start;  // seconds; 0
  int frames = 1;
  std::optional<double> fps;       // 25 without both
  std::optional<double> duration;  // seconds from the first frame to the one after the last
};

void add_lighting_options(CLI::App& app, LightingOptions& options);
void add_animation_options(CLI::App& app, AnimationOptions& options);

// Throws UsageError: fps or a duration without frames, or both.
void check_animation(const AnimationOptions& options);

void set_lighting(const LightingOptions& options, Scene& scene);

// The time of each frame, in seconds.
std::vector<double> frame_times(const AnimationOptions& options);

// "out.png" as "out_0007.png"; `output` itself for a single picture.
std::filesystem::path frame_file(const std::filesystem::path& output, const AnimationOptions& options, int frame);

}  // namespace gicube::samples
