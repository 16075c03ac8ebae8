// Renders pictures one after the other, and reuses what the board still has from the previous one.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/board_group.h"
#include "gicube/image.h"
#include "gicube/light_plan.h"
#include "gicube/mpi.h"
#include "gicube/plan.h"
#include "gicube/scene/image_file.h"
#include "gicube/scene/light_field.h"
#include "gicube/scene/scene.h"
#include "render/colour_passes.h"
#include "render/options.h"
#include "render/pixel_life.h"
#include "render/statistics.h"
#include "scene/common/temporary_file.h"

namespace gicube::samples {

struct Frame {
  int number = 0;
  Image image;
  std::optional<Background> background;  // to be put behind the image
  FrameStatistics statistics;
};

// Called for each step with its name; returns the receiver of its progress.
using Steps = std::function<Progress(const std::string& what)>;

class Renderer {
 public:
  // Opens the board that `options` name. `while_waiting`: as OpenOptions; after an exception of it the next picture may
  // be requested. `ranks`: of an MPI job in which each has such an object; null if there is one host. Throws
  // UsageError, InputError, FileError, and the exceptions of Board::open().
  Renderer(const RenderOptions& options, Steps steps, const std::function<void()>& while_waiting = {},
           MpiExchange* ranks = nullptr);

  // Sets the options of the next pictures. Board and light stay those of the constructor. A transfer function's file is
  // identified by its name. After UsageError or InputError nothing has changed.
  void change(const RenderOptions& options);

  // Renders the pictures from `first` to before `last`, which share volume and light. Equal parts of the previous state
  // of the board are reused.
  void run(const std::vector<double>& times, std::size_t first, std::size_t last,
           const std::function<void(const Frame&)>& done);
  // The picture at a time.
  Frame picture(double time);
  // Loads all that this picture needs, except its light.
  void prepare(double time) { set_voxels(at(time)); }
  // Whether the board has a volume; false after an exception during loading.
  bool loaded() const { return loaded_.has_value(); }
  // Whether the board has the voxels of the picture at that time.
  bool holds(double time) const { return holds(at(time)); }

  // Whether the requested checkpoint is written, or none was requested.
  bool checkpoint_is_written() const { return !options_.checkpoint.unit || checkpoint_written_; }

  // The number of pictures from `first` on with the same volume and light.
  std::size_t run_length(const std::vector<double>& times, std::size_t first) const;

  // Setup of the last picture; without voxels.
  const SceneSetup& setup() const { return setup_; }
  const Scene& input() const { return input_; }
  Board& board() { return board_; }  // the first

 private:
  Scene at(double time) const;
  bool holds(const Scene& scene) const;
  // Makes and loads the scene's voxels unless the board has them. Returns the simulated time.
  Picoseconds set_voxels(const Scene& scene);
  // Sets up the scene for a board that was restored with its voxels.
  void take_over(const Scene& scene);
  // Called before picture `frame`.
  void write_checkpoint_if_due(std::size_t frame);
  void set_optics(const LightPass& pass);
  // Illuminates with the pass's light unless the board has it. Returns whether it was necessary.
  bool light(const LightPass& pass, const Scene& scene, std::size_t passes);
  // The scene's settings, or those of a plan, which is made for the first light of these voxels.
  Illumination planned(const LightPass& pass, const Illumination& settings, std::size_t passes,
                       const std::string& channel);
  // Applies the plan's settings and the derived volume's coordinates. The plan of a lit or scattered picture is made
  // here, after everything is loaded.
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
  std::optional<TemporaryFile> events_;  // of the pixel that is to be explained
  BoardGroup boards_;
  Board& board_;  // the first of them
  MpiExchange* ranks_;
  std::optional<LightField> field_;  // replaces lighting rays
  SceneSetup setup_;
  bool set_up_before_ = false;     // then the board cannot take another codebook
  std::optional<Loaded> loaded_;   // the board's volume
  std::optional<Scene> lit_;       // the scene whose light, of one pass, is on the board
  std::optional<Placement> part_;  // of the derived volume, with --crop and --level-of-detail
  std::optional<Plan> plan_;       // for these voxels, made for the first picture
  std::vector<LightPlan> light_plans_;
  LightingStatistics lighting_;
  bool has_lit_ = false;  // since the start, not before a restored checkpoint
  double rays_made_ = 0;  // for the pictures of this run
  bool checkpoint_written_ = false;
};

}  // namespace gicube::samples
