// A board that makes one picture after the other, and what the last one left there.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/board_group.h"
#include "gicube/light_plan.h"
#include "gicube/mpi.h"
#include "gicube/plan.h"
#include "gicube/scene/light_field.h"
#include "gicube/scene/scene.h"
#include "render/colour_passes.h"
#include "render/frame.h"
#include "render/options.h"
#include "render/pixel_life.h"

namespace gicube::samples {

// Is told of each step, and returns who is to be told how far that one is.
using Steps = std::function<Progress(const std::string& what)>;

class Renderer {
 public:
  // Opens the board that `options` ask for. `while_waiting`: as OpenOptions; after what it throws the next picture may
  // be asked for. `ranks`: who share the pictures, each with such an object; null if there is one host.
  // Throws UsageError, InputError, FileError, and as Board::open().
  Renderer(const RenderOptions& options, Steps steps, const std::function<void()>& while_waiting = {},
           MpiExchange* ranks = nullptr);

  // Sets the subject of the next pictures. Board and light remain those of the constructor; a transfer function's file
  // counts as another one if it has another name. Throws UsageError and InputError: nothing has changed.
  void change(const RenderOptions& options);

  // Pictures `first` to before `last`: of one volume and one light. What is on the board is used again as far as it is
  // the same.
  void run(const std::vector<double>& times, std::size_t first, std::size_t last,
           const std::function<void(const Frame&)>& done);
  // The picture at a time.
  Frame picture(double time);
  // Brings onto the board what that picture needs, but for its light.
  void prepare(double time) { set_voxels(at(time)); }
  // Whether the board has a volume: not after a call that was left while it was loading one.
  bool loaded() const { return loaded_.has_value(); }
  // Whether the picture at a time is one of the voxels that are there.
  bool holds(double time) const { return holds(at(time)); }

  // Whether the checkpoint that was asked for is written, or none was asked for.
  bool checkpoint_is_written() const { return !options_.checkpoint.unit || checkpoint_written_; }

  // How many pictures from `first` on have its volume and its light.
  std::size_t run_length(const std::vector<double>& times, std::size_t first) const;

  // Setup of the last picture; without voxels.
  const SceneSetup& setup() const { return setup_; }
  const Scene& input() const { return input_; }
  Board& board() { return board_; }  // the first

 private:
  Scene at(double time) const;
  bool holds(const Scene& scene) const;
  // Makes and loads the scene's voxels unless they are there. The simulated time that it took.
  Picoseconds set_voxels(const Scene& scene);
  // The scene's voxels are on a board that goes on from a checkpoint.
  void take_over(const Scene& scene);
  // Before picture `frame`.
  void write_checkpoint_if_due(std::size_t frame);
  void set_optics(const LightPass& pass);
  // Spreads the pass's light unless it is there; whether that had to be done.
  bool light(const LightPass& pass, const Scene& scene, std::size_t passes);
  // The scene's lighting rays, or as many as a plan found enough for the first light that these voxels had.
  Illumination planned(const LightPass& pass, const Illumination& settings, std::size_t passes,
                       const std::string& channel);
  // The plan's settings, and its volume's voxels. Of lit and scattered pictures it is made here, once all is on the
  // board.
  void plan_view(const LightPass& pass, View& view);
  void picture(const LightPass& pass, const std::string& what, Frame& frame);

  struct Loaded {
    Scene scene;
    std::string transfer_function;
    bool crop = false;
    int level_of_detail = 0;
  };

  RenderOptions options_;
  Steps steps_;
  Scene input_;
  std::unique_ptr<EventFile> events_;  // of the pixel that is to be explained
  BoardGroup boards_;
  Board& board_;  // the first of them; what all must do goes to boards_
  MpiExchange* ranks_;
  std::optional<LightField> field_;  // in place of lighting rays
  SceneSetup setup_;
  bool set_up_before_ = false;     // the board can't take another codebook
  std::optional<Loaded> loaded_;   // what the board holds
  std::optional<Scene> lit_;       // whose light, of one pass, is on the board
  std::optional<Placement> part_;  // of what stands for the volume, with --crop and --level-of-detail
  std::optional<Plan> plan_;       // of these voxels, and what was first seen of them
  std::vector<LightPlan> light_plans_;
  LightingStatistics lighting_;
  bool has_lit_ = false;  // here, and not before a checkpoint
  double rays_made_ = 0;  // for pictures of this run
  bool checkpoint_written_ = false;
};

}  // namespace gicube::samples
