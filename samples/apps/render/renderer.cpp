#include "render/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "gicube/scene/error.h"
#include "gicube/scene/marks.h"
#include "render/hosts.h"
#include "render/planning.h"
#include "scene/program/board_run.h"

namespace gicube::samples {
namespace {

// chosen: the number of pictures with the same light that are kept until all colour passes are done; 64 of 512^2 need
// 128 MB.
constexpr std::size_t kMaxRun = 64;

void check_size(const LightField& field, const Dims& dims) {
  if (field.dims == dims) return;
  const auto text = [](const Dims& d) { return fmt::format("{} x {} x {}", d[0], d[1], d[2]); };
  throw InputError("--irradiance", "a field of the volume's " + text(dims) + " voxels", text(field.dims));
}

// The options of the boards, with a file for the events of a pixel that is to be explained.
BoardOptions board_of(const RenderOptions& options, std::optional<TemporaryFile>& events) {
  BoardOptions board = board_for(options.plan, options.board);
  if (!options.explain_pixel) return board;
  board.events = events.emplace().path();
  board.events_of = fmt::format("life={}:{}", (*options.explain_pixel)[0], (*options.explain_pixel)[1]);
  return board;
}

// Whether nodes move, so that a codebook of one picture's normals would not suit the next.
bool moves_nodes(const Scene& scene) {
  return std::any_of(scene.engines.begin(), scene.engines.end(),
                     [](const Engine& engine) { return engine.target.starts_with("node["); });
}

// The background to composite. An EXR has alpha instead, unless --composite is given.
std::optional<Background> background_of(const RenderOptions& options, const std::optional<Colour>& own) {
  const bool alpha = options.no_background || (options.output.extension() == ".exr" && !options.composite);
  const std::optional<Colour>& colour = options.background ? options.background : own;
  if (options.composite && !colour)
    throw UsageError("--composite: expected with --background, since the scene has none");
  if (alpha || !colour) return std::nullopt;
  return Background(*colour, options.composite.value_or(Composite::kDisplay));
}

// Adds the time between two readings to the sums.
void add(const std::vector<BoardTime>& begin, const std::vector<BoardTime>& end, std::vector<BoardTime>& sums) {
  sums.resize(end.size());
  for (std::size_t i = 0; i < end.size(); ++i) {
    for (const auto part : {&BoardTime::bus, &BoardTime::work, &BoardTime::bus_wait, &BoardTime::skew})
      sums[i].*part += end[i].*part - begin[i].*part;
  }
}

}  // namespace

Renderer::Renderer(const RenderOptions& options, Steps steps, const std::function<void()>& while_waiting,
                   MpiExchange* ranks)
    : options_(options),
      steps_(std::move(steps)),
      input_(input_scene(options)),
      boards_(open_boards(board_of(options, events_), while_waiting)),
      board_(boards_.board(0)),
      ranks_(ranks) {
  if (boards_.size() > 1) {
    expect_without(
        options, "several boards",
        {"--max-error or --time-budget", "--crop", "--level-of-detail", "--irradiance", "--checkpoint or --restore"});
  }
  if (ranks_ != nullptr) board_.share_blocks({std::shared_ptr<void>(), ranks_});
  if (!options.lighting.field.empty()) field_ = read_light_field(options.lighting.field);
}

void Renderer::change(const RenderOptions& options) {
  input_ = input_scene(options);
  options_ = options;
}

Frame Renderer::picture(double time) {
  Frame frame;
  run({time}, 0, 1, [&frame](const Frame& made) { frame = made; });
  return frame;
}

void Renderer::run(const std::vector<double>& times, std::size_t first, std::size_t last,
                   const std::function<void(const Frame&)>& done) {
  const Scene scene = at(times[first]);
  Picoseconds load = 0;
  together(ranks_, [&] { load = set_voxels(scene); });
  const std::vector<LightPass> passes = passes_of(setup_, board_.info().irradiance_words);
  const bool one_picture = passes.size() == 1 && pictures_of(passes[0]).size() == 1;
  if (events_ && !one_picture) {
    throw UsageError("--explain-pixel: expected a scene without colour passes, which make three pictures");
  }
  if (!one_picture && (options_.checkpoint.unit || !options_.board.restore.empty())) {
    throw UsageError("--checkpoint, --restore: expected a scene without colour passes, which make three pictures");
  }
  std::vector<Frame> frames(last - first);
  std::vector<View> views(frames.size());
  for (const LightPass& pass : passes) {
    const bool lit = scene.lighting.on && light(pass, scene, passes.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      Frame& frame = frames[i];
      set_look(at(times[first + i]), setup_);
      set_phong(options_, setup_.shading.phong);
      write_checkpoint_if_due(first + i);
      views[i] = setup_.view;
      for (const LightPass& each : pictures_of(pass)) {
        picture(each, fmt::format("picture {} of {}", first + i + 1, times.size()), frame);
      }
      if (scene.lighting.on && has_lit_) {  // otherwise the light is from a checkpoint
        frame.statistics.lighting.push_back(lighting_);
        frame.statistics.lighting.back().reused = !lit || i > 0;
      }
    }
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].number = static_cast<int>(first + i);
    frames[i].statistics.time = times[first + i];
    frames[i].statistics.load = i == 0 ? load : 0;
    frames[i].statistics.host = host_usage();
    frames[i].statistics.look = setup_.look_why;
    frames[i].statistics.invisible = board_.why_invisible(frames[i].image);
    if (options_.annotate) draw_marks(setup_.volume.placement, setup_.volume.spacing, views[i], frames[i].image);
    if (ranks_ != nullptr) share_statistics(*ranks_, frames[i].statistics);
    done(frames[i]);
  }
}

std::size_t Renderer::run_length(const std::vector<double>& times, std::size_t first) const {
  const Scene scene = at(times[first]);
  std::size_t length = 1;
  while (length < kMaxRun && first + length < times.size() && same_illumination(scene, at(times[first + length]))) {
    ++length;
  }
  return length;
}

Scene Renderer::at(double time) const { return scene_at(input_, options_, time); }

bool Renderer::holds(const Scene& scene) const {
  const auto asks = [](const Scene& s) { return s.view.shade || s.lighting.on; };  // whether it needs gradients
  return loaded_ && same_voxels(loaded_->scene, scene) && loaded_->crop == options_.crop &&
         loaded_->level_of_detail == options_.level_of_detail && (asks(loaded_->scene) || !asks(scene)) &&
         (loaded_->transfer_function == options_.transfer_function || (!part_ && keeps_voxels(scene, setup_)));
}

Picoseconds Renderer::set_voxels(const Scene& scene) {
  const Picoseconds begin = boards_.now();
  if (holds(scene)) {
    set_look(scene, setup_);
    if (loaded_->transfer_function == options_.transfer_function) return 0;
    lit_.reset();
    const ValueRange range = board_.value_range();
    for (std::size_t tag = 0; tag < setup_.materials.size(); ++tag) {
      const TransferFunction function = in_values_of(range, setup_.materials[tag]);
      boards_.on_all([&](Board& board) { board.set_transfer_function(function, static_cast<int>(tag)); });
    }
    loaded_->transfer_function = options_.transfer_function;
    return boards_.now() - begin;
  }
  steps_("reading the scene");
  const bool is_first = !set_up_before_;
  if (is_first && !options_.board.restore.empty()) {
    take_over(scene);
    return 0;
  }
  loaded_.reset();
  lit_.reset();
  const bool derived = options_.crop || options_.level_of_detail > 0;
  Scene read = scene;
  read.volume.in_planes = !derived && !options_.plan.wanted();  // these need all voxels
  setup_ = set_up(read, options_.board.threads);
  set_phong(options_, setup_.shading.phong);
  check_renders(setup_.volume.dims, board_.info(), setup_.volume.source);
  if (field_) check_size(*field_, setup_.volume.dims);
  boards_.on_all([&](Board& board) {
    board.set_shading(setup_.shading);
    board.set_brick_detail(options_.brick_detail);
  });
  const bool own_codebook = is_first && scene.world && scene.own_codebook && !moves_nodes(scene);
  set_up_before_ = true;
  plan_.reset();
  light_plans_.clear();
  part_.reset();
  const bool unlit = !scene.lighting.on && !setup_.view.scatter && !field_;
  if (derived && !unlit)
    throw UsageError("--crop, --level-of-detail: expected a picture without light of its own, and no scattering");
  if (options_.plan.wanted() && unlit) {
    plan_ = plan_and_load(board_, options_.plan, setup_, own_codebook, steps_("planning"));
  } else if (derived) {
    part_ = load_derived(board_, setup_, options_.crop, options_.level_of_detail, own_codebook,
                         steps_("loading the volume"));
  } else {
    const Progress told = steps_("loading the volume");
    boards_.on_all(
        [&](Board& board, std::size_t index) { load(board, setup_, own_codebook, index == 0 ? told : Progress()); });
  }
  setup_.free_voxels();
  loaded_ = Loaded{scene, options_.transfer_function, options_.crop, options_.level_of_detail};
  return boards_.now() - begin;
}

void Renderer::take_over(const Scene& scene) {
  setup_ = set_up(scene, options_.board.threads);
  set_phong(options_, setup_.shading.phong);
  const auto text = [](const Dims& d) { return fmt::format("{} x {} x {} voxels", d[0], d[1], d[2]); };
  const Dims there = board_.dims();
  if (there != setup_.volume.dims) {
    throw InputError("--restore", "a checkpoint with the scene's volume of " + text(setup_.volume.dims), text(there));
  }
  set_up_before_ = true;
  setup_.free_voxels();
  loaded_ = Loaded{scene, options_.transfer_function, false, 0};
  if (scene.lighting.on) lit_ = scene;
}

void Renderer::write_checkpoint_if_due(std::size_t frame) {
  const CheckpointOptions& asked = options_.checkpoint;
  const View& view = setup_.view;
  rays_made_ += static_cast<double>(view.width) * view.height * view.samples_per_axis * view.samples_per_axis;
  if (checkpoint_is_written()) return;
  const bool is_due = asked.unit == CheckpointOptions::Unit::kFrame          ? static_cast<double>(frame) >= asked.at
                      : asked.unit == CheckpointOptions::Unit::kMilliseconds ? to_ms(board_.now()) >= asked.at
                                                                             : rays_made_ > asked.at;
  if (!is_due) return;
  board_.save(asked.file.string());
  checkpoint_written_ = true;
  steps_(fmt::format("checkpoint before picture {} at {:.3f} ms: {}", frame, to_ms(board_.now()), asked.file.string()));
}

namespace {

void add_detail(Board& board, std::optional<BrickDetail>& sum) {
  const auto own = board.brick_detail();
  if (!own) return;
  if (!sum) sum.emplace();
  for (std::size_t level = 0; level < own->blocks.size(); ++level) sum->blocks[level] += own->blocks[level];
  sum->largest_density = std::max(sum->largest_density, own->largest_density);
  sum->largest_opacity = std::max(sum->largest_opacity, own->largest_opacity);
}

}  // namespace

void Renderer::set_optics(const LightPass& pass) {
  boards_.on_all([&](Board& board) {
    for (std::size_t tag = 0; tag < pass.optics.size(); ++tag) {
      board.set_material(pass.optics[tag], static_cast<int>(tag));
    }
  });
}

bool Renderer::light(const LightPass& pass, const Scene& scene, std::size_t passes) {
  if (passes == 1 && lit_ && same_illumination(*lit_, scene)) return false;
  lit_.reset();
  set_optics(pass);
  const std::string channel = passes > 1 ? fmt::format(" ({})", name_of(pass)) : "";
  Illumination settings = scene.lighting.settings;
  settings.light_colours = pass.light_colours;
  settings = planned(pass, settings, passes, channel);
  RunWindow window(boards_);
  lighting_ = {};
  has_lit_ = true;
  const Progress told = steps_("lighting" + channel);
  boards_.on_all([&](Board& board, std::size_t index) {
    LightingReport report = board.illuminate(pass.lights, settings, index == 0 ? told : Progress());
    if (index == 0) lighting_.report = std::move(report);  // each has the same
  });
  lighting_.channel = name_of(pass);
  lighting_.settings = settings;
  lighting_.lights = pass.lights.size();
  lighting_.duration = window.simulated();
  lighting_.host_seconds = window.host_seconds();
  lighting_.counters = window.counters();
  if (passes == 1) lit_ = scene;
  return true;
}

Illumination Renderer::planned(const LightPass& pass, const Illumination& settings, std::size_t passes,
                               const std::string& channel) {
  if (!options_.plan.wanted() || pass.lights.empty()) return settings;
  for (const LightPlan& plan : light_plans_) {
    if (plan.channel == pass.channel) return plan.settings(settings);
  }
  board_.set_shading(setup_.shading);
  light_plans_.push_back(
      plan_pass(board_, options_.plan, setup_, pass, passes, steps_("planning the light" + channel)));
  return light_plans_.back().settings(settings);
}

void Renderer::plan_view(const LightPass& pass, View& view) {
  if (part_) view = part_->view(view);
  if (!options_.plan.wanted()) return;
  if (!plan_) {
    board_.set_shading(setup_.shading);
    set_optics(pass);
    plan_ = plan_lit(board_, options_.plan, view, light_plans_, pass.channel < 0 ? 1 : 3, steps_("planning"));
  }
  view = plan_->view(view);
}

void Renderer::picture(const LightPass& pass, const std::string& what, Frame& frame) {
  View view = setup_.view;
  view.exposure = setup_.lighting.exposure;
  plan_view(pass, view);
  RunWindow window(boards_);
  const std::uint64_t sent = ranks_ != nullptr ? ranks_->bytes_sent() : 0;
  const std::vector<BoardTime> before = boards_.times();
  boards_.on_all([&](Board& board) { board.set_shading(setup_.shading); });
  set_optics(pass);
  frame.background = background_of(options_, setup_.background);
  if (field_) {
    const double voxel = setup_.grid.voxel, asked = setup_.lighting.exposure * voxel * voxel;
    frame.image =
        picture_of(board_, *field_, view, asked > 0 ? asked : exposure_for(*field_), frame.background, steps_(what));
  } else {
    put_together(pass, boards_.render(view, steps_(what)), frame.background, frame.image);
  }

  FrameStatistics& statistics = frame.statistics;
  if (events_) statistics.pixel = pixel_life(events_->path());
  statistics.frame += window.simulated();
  statistics.host_seconds += window.host_seconds();
  const Counters counters = window.counters();
  statistics.counters = sum_of({&statistics.counters, &counters});
  statistics.board = board_.info();
  if (boards_.size() > 1) {
    add(before, boards_.times(), statistics.boards);
    statistics.own_buses = boards_.buses() == HostBuses::kOwn;
  }
  for (std::size_t i = 0; options_.brick_detail > 0 && i < boards_.size(); ++i)
    add_detail(boards_.board(i), statistics.detail);
  if (ranks_ != nullptr) statistics.bytes_sent += ranks_->bytes_sent() - sent;
  statistics.width = frame.image.width;
  statistics.height = frame.image.height;
  statistics.dims = setup_.volume.dims;
  statistics.seed = options_.board.seed;
  statistics.scene_hash = scene_hash(setup_);
  statistics.plan = plan_;
  statistics.light_plans = light_plans_;
}

}  // namespace gicube::samples
