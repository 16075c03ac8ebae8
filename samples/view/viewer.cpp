#include "view/viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include "gicube/scene/error.h"
#include "gicube/scene/image_file.h"
#include "gicube/scene/transfer_function_file.h"
#include "scene/common/checks.h"
#include "scene/program/run_json.h"
#include "view/protocol.h"

namespace gicube::samples::view {
namespace {

using Json = nlohmann::ordered_json;
using Kind = Request::Kind;

// Leaves a call that waits for a board: something newer was asked for.
struct Stopped {};

constexpr const char* kGaveWay = "the comparison gave way to another picture";
constexpr const char* kNothingOpen = "nothing is open: name an input on the command line, or drop a file on the page";

// What is stopped when something newer comes.
bool is_picture(const std::optional<Request>& request) {
  return request && (request->kind == Kind::kPicture || request->kind == Kind::kCompare);
}

std::string name_of_input(const std::string& path) {
  const std::filesystem::path p(path);
  return path.starts_with("builtin:") ? path
         : p.has_filename()           ? p.filename().string()
                                      : p.parent_path().filename().string();
}

Packet packet(const Json& message, bool droppable) {
  auto text = message.dump(-1, ' ', false, Json::error_handler_t::replace);
  return {std::make_shared<const std::string>(std::move(text)), false, droppable};
}

Json numbers(const Vec3& v) { return {v.x, v.y, v.z}; }

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

Viewer::Viewer(const ViewOptions& options, std::function<void(Page, const Packet&)> send)
    : options_(options),
      send_(std::move(send)),
      live_([this](Page page, const BoardLook& look, bool running, bool with_units) {
        Json message{{"type", "machine"}, {"simulated_ms", to_ms(look.simulated)}, {"running", running}};
        for (const Counter& counter : look.counters.list()) {
          message["counters"][counter.name] = counter.value;
          if (with_units) message["units"][counter.name] = counter.unit;
        }
        tell(page, message, true);
      }) {
  shelf_.folder = options_.folder;
  for (const std::string& input : options_.inputs) shelf_.inputs.emplace(name_of_input(input), input);
  const auto look = options_.settings.find("transfer-function");
  if (look != options_.settings.end() && std::filesystem::is_regular_file(look->second)) {
    const std::string name = std::filesystem::path(look->second).filename().string();
    shelf_.functions[name] = std::exchange(look->second, name);
  }
  thread_ = std::thread([this] { work(); });
}

Viewer::~Viewer() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Viewer::come(Page page) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back({page, std::nullopt});
  }
  wake_.notify_all();
}

void Viewer::leave(Page page) {
  live_.listen(page, false);
  const std::lock_guard lock(mutex_);
  std::erase_if(jobs_, [page](const Job& job) { return job.page == page; });
  if (now_ && now_->page == page && is_picture(now_->request)) stop_ = true;
}

void Viewer::ask(Page page, Request request) {
  if (request.kind == Kind::kMachine) return live_.listen(page, request.on);
  bool full = false;
  std::optional<Job> dropped;  // a comparison that waits
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(jobs_, [&](const Job& job) {
      if (job.page != page || !job.request) return false;
      if (job.request->kind == Kind::kCompare && is_picture(request)) dropped = job;
      return (job.request->kind == request.kind &&
              (request.kind == Kind::kPicture ||
               (request.kind == Kind::kSlice && job.request->axis == request.axis))) ||
             (job.request->kind == Kind::kCompare && is_picture(request));
    });
    // A page's own comparison takes long, and gives way to the page; a moving one does not wait for another page's whole picture.
    if (is_picture(request) && now_ && is_picture(now_->request) &&
        (now_->page == page || (request.kind == Kind::kPicture && request.on && !now_->request->on))) {
      stop_ = true;
    }
    full = std::ranges::count(jobs_, page, &Job::page) >= static_cast<std::ptrdiff_t>(kMaxWaiting);
    if (!full) jobs_.push_back({page, std::move(request)});
  }
  wake_.notify_all();
  if (dropped) failed(*dropped, kGaveWay, "");
  if (full) tell(page, {{"type", "error"}, {"text", "too much is asked for at once; ask again"}});
}

void Viewer::work() {
  if (!options_.inputs.empty()) {
    Job first{kAllPages, Request()};
    first.request->kind = Kind::kBoard;
    input_ = name_of_input(options_.inputs.front());
    carry_out(first);
  }
  std::unique_lock lock(mutex_);
  for (;;) {
    now_.reset();
    wake_.wait(lock, [this] { return ends_ || !jobs_.empty(); });
    if (ends_) return;
    now_ = std::move(jobs_.front());
    jobs_.pop_front();
    stop_ = false;
    const Job job = *now_;
    lock.unlock();
    live_.set_running(is_picture(job.request));
    carry_out(job);
    live_.set_running(false);
    lock.lock();
  }
}

void Viewer::carry_out(const Job& job) try {
  if (!job.request) {
    send_(job.page, hello());
    if (lost_) return tell(job.page, {{"type", "board"}, {"state", "lost"}, {"text", fault_}});
    if (volume_.is_null() && !fault_.empty()) tell(job.page, {{"type", "error"}, {"text", fault_}});
    return;
  }
  const Kind kind = job.request->kind;
  if (kind == Kind::kOpen) return open_files(job.request->names);
  if (input_.empty()) throw UsageError(kNothingOpen);
  if (kind == Kind::kBoard) return open_input(input_);
  if (lost_) return tell(job.page, {{"type", "board"}, {"state", "lost"}, {"text", fault_}});
  if (kind == Kind::kPicture) return picture(job);
  if (kind == Kind::kCompare) return compare(job);
  if (kind == Kind::kSlice) return slice(job);
  histogram(job.page);
} catch (const Stopped&) {
  if (main_.renderer && !main_.renderer->loaded()) main_ = {};
  if (quick_.renderer && !quick_.renderer->loaded()) quick_ = {};
  const bool has_newer = make_way(job);
  if (has_newer && job.request->kind == Kind::kCompare) failed(job, kGaveWay, "");
} catch (const DeviceLost& error) {
  lose(error.what());
} catch (const TimedOut& error) {
  lose(error.what());
} catch (const OpenFailed& error) {
  lose(error.what());
} catch (const BadArgument& error) {
  failed(job, error.what(), error.field());
} catch (const InputError& error) {
  failed(job, error.what(), error.field());
} catch (const std::exception& error) {
  failed(job, error.what(), field_of(error.what()));
}

bool Viewer::make_way(const Job& job) {
  const std::lock_guard lock(mutex_);
  const bool has_newer = std::ranges::any_of(
      jobs_, [&job](const Job& other) { return other.page == job.page && is_picture(other.request); });
  if (!has_newer && !ends_ && job.page != kAllPages) jobs_.push_back(job);
  return has_newer;
}

void Viewer::failed(const Job& job, const std::string& text, const std::string& field) {
  Json message{{"type", "error"}};
  if (job.request && job.request->id > 0) message["id"] = job.request->id;
  if (!field.empty()) message["field"] = field;
  message["text"] = text;
  if (job.page == kAllPages) fault_ = text;  // at the start, when no page has come
  tell(job.page, message);
}

void Viewer::lose(const std::string& text) {
  lost_ = true;
  fault_ = text;
  close_boards();
  tell(kAllPages, {{"type", "board"}, {"state", "lost"}, {"text", text}});
}

void Viewer::close_boards() {
  live_.show("", 0);
  main_ = {};
  quick_ = {};
}

void Viewer::open_files(const std::vector<std::string>& names) {
  const auto ends = [](const std::string& name, std::initializer_list<const char*> all) {
    return std::ranges::any_of(all, [&name](const char* end) { return name.ends_with(end); });
  };
  for (const std::string& name : names) {
    if (!std::filesystem::exists(options_.folder / name)) throw InputError(name, "a posted file", "none of that name");
  }
  if (names.size() == 1 && ends(names.front(), {".tf"})) {
    // By its content, since another one may come by this name.
    shelf_.functions[names.front()] = file_of(bytes_of(options_.folder / names.front()), shelf_);
    return send_(kAllPages, hello());
  }
  // A header or a scene with its files, or else slices, which are a folder of their own.
  const auto head = std::ranges::find_if(names, [&](const std::string& name) {
    return names.size() == 1 || is_scene_path(name) || ends(name, {".nhdr", ".mhd"});
  });
  std::string name;
  const Shelf before = shelf_;
  if (head != names.end()) {
    name = *head;
    shelf_.inputs[name] = (options_.folder / name).string();
  } else {
    for (std::size_t number = 1; name.empty() || std::filesystem::exists(options_.folder / name); ++number) {
      name = fmt::format("slices-{}", number);
    }
    std::filesystem::create_directory(options_.folder / name);
    for (const std::string& slice : names) {
      std::filesystem::rename(options_.folder / slice, options_.folder / name / slice);
    }
    shelf_.inputs[name] = (options_.folder / name).string();
  }
  const std::string open = input_;
  try {
    open_input(name);
  } catch (const Error&) {
    shelf_ = before;
    close_boards();
    if (!open.empty()) open_input(open);  // what was there stays
    throw;
  }
}

void Viewer::open_input(const std::string& name) {
  Settings settings = options_.settings;
  settings["input"] = name;
  const RenderOptions options = options_of(settings, shelf_, options_.board);
  close_boards();
  Renderer& renderer = *quick_desk(options).renderer;
  renderer.prepare(options.animation.start.value_or(0));
  const SceneSetup& setup = renderer.setup();
  const Dims& dims = setup.volume.dims;
  const ValueRange range = renderer.board().value_range();
  for (const auto& [key, value] : chosen_settings(setup)) settings.emplace(key, value);
  chosen_ = settings;
  input_ = name;
  volume_ = {{"name", name},
             {"dims", dims},
             {"spacing", numbers(setup.volume.spacing)},
             {"range", {range.low, range.high}},
             {"world", renderer.input().world.has_value()},
             {"own_look", !settings.contains("transfer-function") &&
                              (is_scene_path(options.input) || !renderer.input().volume.builtin.empty())}};
  box_ = {{"low", numbers(setup.grid.point_of(setup.box.low))}, {"high", numbers(setup.grid.point_of(setup.box.high))}};
  send_(kAllPages, hello());
  if (std::exchange(lost_, false)) {
    tell(kAllPages, {{"type", "board"}, {"state", "ready"}, {"text", "a board is there"}});
  }
}

Packet Viewer::hello() {
  Json message{{"type", "hello"}};
  for (const auto& [name, path] : shelf_.inputs) message["inputs"].push_back(name);
  for (const auto& [name, path] : shelf_.functions) message["transfer_functions"].push_back(name);
  for (const char* list : {"inputs", "transfer_functions"}) {
    if (!message.contains(list)) message[list] = Json::array();
  }
  for (const Preset& preset : presets()) message["presets"].push_back({{"name", preset.name}, {"text", preset.text}});
  message["settings"] = chosen_;
  message["volume"] = volume_;
  message["box"] = box_;
  message["limits"] = {{"file_bytes", kMaxFileBytes}, {"message_bytes", kMaxMessageBytes}, {"size", 4095}};
  const Desk& shown = main_.renderer ? main_ : quick_;
  message["board"] = nullptr;
  if (shown.renderer) {
    const BoardInfo& info = shown.renderer->board().info();
    message["board"] = {{"uri", shown.uri}, {"level", gicube::name_of(info.fidelity)}, {"processors", info.processors}};
  }
  return packet(message, false);
}

Settings Viewer::completed(const Settings& settings) const {
  Settings all = settings;
  for (const auto& [name, value] : chosen_) {
    if ((name == "fov" && all.contains("orthographic")) || (name == "orthographic" && all.contains("fov"))) continue;
    all.emplace(name, value);
  }
  return all;
}

Viewer::Desk Viewer::make_desk(const RenderOptions& options) {
  Desk made;
  made.uri = board_uri(options.board);
  made.renderer = std::make_unique<Renderer>(
      options, [this](const std::string& what) { return step(what); }, [this] { stop_if_told(); });
  return made;
}

void Viewer::serve(Desk& desk, const RenderOptions& options) {
  desk.renderer->change(options);
  // A board takes a world's own codebook of normals once.
  const bool is_world = desk.renderer->input().world && desk.renderer->loaded();
  if (is_world && !desk.renderer->holds(options.animation.start.value_or(0))) {
    desk = {};
    desk = make_desk(options);
  }
}

Board& Viewer::volume_board() {
  for (const Desk* desk : {&quick_, &main_}) {
    if (desk->renderer && desk->renderer->loaded()) return desk->renderer->board();
  }
  const RenderOptions options = options_of(chosen_, shelf_, options_.board);
  Renderer& renderer = *quick_desk(options).renderer;
  renderer.prepare(options.animation.start.value_or(0));
  return renderer.board();
}

void Viewer::stop_if_told() {
  if (stop_) throw Stopped();
}

Viewer::Desk& Viewer::desk(const RenderOptions& options) {
  const std::string uri = board_uri(options.board);
  const bool is_quick = quick_.renderer && quick_.uri == uri;  // of another page, which shows it at another level
  Desk& found = is_quick && main_.uri != uri ? quick_ : main_;
  if (found.renderer && found.uri == uri) {
    serve(found, options);
  } else {
    found = {};
    found = make_desk(options);
  }
  live_.show(found.uri, found.renderer->board().info().config_hash);
  return found;
}

Viewer::Desk& Viewer::quick_desk(const RenderOptions& options) {
  Desk& asked = desk(options);
  if (asked.renderer->board().info().fidelity == Fidelity::kFunctional) return asked;
  RenderOptions quick = options;
  if (!quick.board.board.starts_with("emu:")) {
    quick.board.board = "emu:";
    quick.board.settings = {fmt::format("asic.max_volume_voxels={}", asked.renderer->board().info().max_volume_voxels)};
  }
  quick.board.fidelity = "functional";
  if (quick_.renderer && quick_.uri == board_uri(quick.board)) {
    serve(quick_, quick);
  } else {
    quick_ = {};
    quick_ = make_desk(quick);
  }
  return quick_;
}

Frame Viewer::render(Desk& desk, const RenderOptions& options) {
  serve(desk, options);
  const Frame frame = desk.renderer->picture(options.animation.start.value_or(0));
  live_.counted({desk.renderer->board().now(), desk.renderer->board().counters()});
  const View& view = desk.renderer->setup().view;
  const double rays = double(view.width) * view.height * view.samples_per_axis * view.samples_per_axis;
  desk.ray_seconds = frame.statistics.host_seconds * view.step / rays;
  return frame;
}

void Viewer::picture(const Job& job) {
  const auto input = job.request->settings.find("input");
  if (input != job.request->settings.end() && input->second != input_) open_input(input->second);
  const Settings settings = completed(job.request->settings);
  const RenderOptions options = options_of(settings, shelf_, options_.board);
  Desk& quick = quick_desk(options);
  const bool is_same = quick.uri == board_uri(options.board);
  quick.renderer->prepare(options.animation.start.value_or(0));
  const View& view = quick.renderer->setup().view;
  // As long as the whole one's host time is not known, it counts as too long.
  const double rays = double(view.width) * view.height * view.samples_per_axis * view.samples_per_axis;
  const double budget = std::chrono::duration<double>(kFrameBudget).count();
  const double seconds = quick.ray_seconds * rays / view.step;
  const bool fits = is_same && quick.ray_seconds > 0 && seconds <= budget;
  if (!fits) {
    // Steps twice as long first, which show least; then fewer pixels.
    double share = quick.ray_seconds > 0 ? budget / seconds : 1.0 / 16;
    RenderOptions coarse = options;
    coarse.samples = 1;
    share *= view.samples_per_axis * view.samples_per_axis;
    if (share < 1 && view.step <= 1) coarse.step = 2 * view.step, share *= 2;
    const double scale = std::clamp(std::sqrt(share), 1.0 / 16, 1.0);
    const auto scaled = [scale](int pixels) { return std::max(1, static_cast<int>(std::lround(scale * pixels))); };
    coarse.size = {scaled(view.width), scaled(view.height)};
    send_picture(job, quick, coarse, settings, false);
    if (job.request->on) return;
  }
  stop_if_told();
  send_picture(job, desk(options), options, settings, true);
}

void Viewer::send_picture(const Job& job, Desk& desk, const RenderOptions& options, const Settings& settings,
                          bool whole) {
  const Frame frame = render(desk, options);
  std::vector<std::uint8_t> pixels = png_pixels(frame.image, frame.background);
  if (frame.background) {
    std::vector<std::uint8_t> opaque;
    opaque.reserve(frame.image.pixels.size() * 4);
    for (std::size_t i = 0; i < pixels.size(); i += 3)
      opaque.insert(opaque.end(), {pixels[i], pixels[i + 1], pixels[i + 2], 255});
    pixels = std::move(opaque);
  }
  const FrameStatistics& statistics = frame.statistics;
  const bool timed = statistics.board.fidelity != Fidelity::kFunctional;
  Json header{{"type", "picture"},
              {"id", job.request->id},
              {"width", frame.image.width},
              {"height", frame.image.height},
              {"final", whole},
              {"frame_ms", timed ? Json(to_ms(statistics.frame)) : Json(nullptr)},
              {"level", gicube::name_of(statistics.board.fidelity)},
              {"host_ms", 1e3 * statistics.host_seconds}};
  if (whole) {
    const std::string command = command_of(settings, shelf_, options_.board);
    header["command"] = command;
    Provenance provenance = provenance_of(statistics.board, statistics.scene_hash);
    provenance.command = command;
    const auto look = settings.find("transfer-function");
    std::string function;
    if (look != settings.end()) {
      const bool is_text = look->second.find('\n') != std::string::npos;
      const auto file = shelf_.functions.find(look->second);
      function = is_text                          ? look->second
                 : file != shelf_.functions.end() ? bytes_of(file->second)
                                                  : std::string(bytes_of(options.transfer_function));
      for (const Preset& preset : presets()) {
        if (preset.name == look->second) function = preset.text;
      }
    }
    const std::string python = python_of(settings, shelf_, options, desk.renderer->setup(), frame.background);
    if (!python.empty()) header["python"] = python;
    Made made{frame.image, frame.background, to_json(statistics).dump(2) + '\n', function, provenance};
    const std::lock_guard lock(mutex_);
    header["number"] = ++last_number_;
    made_.emplace(last_number_, std::move(made));
    if (made_.size() > kMaxMade) made_.erase(made_.begin());
  }
  tell(job.page, std::move(header), pixels, true);
}

void Viewer::compare(const Job& job) {
  Json message{{"type", "compared"}, {"id", job.request->id}};
  std::vector<Image> images;
  for (const Settings* settings : {&job.request->settings, &job.request->other}) {
    const RenderOptions options = options_of(completed(*settings), shelf_, options_.board);
    Desk desk = make_desk(options);
    live_.show(desk.uri, desk.renderer->board().info().config_hash);
    const Frame frame = desk.renderer->picture(options.animation.start.value_or(0));
    const bool timed = frame.statistics.board.fidelity != Fidelity::kFunctional;
    Json counters = Json::object();
    for (const Counter& counter : frame.statistics.counters.list()) counters[counter.name] = counter.value;
    message["frames"].push_back({{"frame_ms", timed ? Json(to_ms(frame.statistics.frame)) : Json(nullptr)},
                                 {"settings", *settings},
                                 {"counters", counters}});
    images.push_back(frame.image);
  }
  message["same"] = images[0] == images[1];
  tell(job.page, message);
}

void Viewer::slice(const Job& job) {
  Board& board = volume_board();
  const Dims dims = board.dims();
  const auto axis = static_cast<std::size_t>(job.request->axis);
  const int at = job.request->at;
  if (at >= dims[axis]) throw InputError("at", fmt::format("a voxel from 0 to {}", dims[axis] - 1), std::to_string(at));
  VoxelBox box{{0, 0, 0}, dims};
  box.low[axis] = at;
  box.size[axis] = 1;
  const ValueRange range = board.value_range();
  const double scale = range.high > range.low ? 255 / (range.high - range.low) : 0;
  std::vector<std::uint8_t> grey;
  for (const float value : board.read_volume(box)) {
    grey.push_back(static_cast<std::uint8_t>(std::clamp(std::lround((double{value} - range.low) * scale), 0L, 255L)));
  }
  const Json header{{"type", "slice"},
                    {"id", job.request->id},
                    {"axis", std::string(1, "xyz"[axis])},
                    {"at", at},
                    {"width", axis == 0 ? dims[1] : dims[0]},
                    {"height", axis == 2 ? dims[1] : dims[2]}};
  tell(job.page, header, grey, false);
}

void Viewer::histogram(Page page) {
  Board& board = volume_board();
  const Dims dims = board.dims();
  const ValueRange range = board.value_range();
  constexpr std::size_t kBins = 256;
  std::vector<std::uint64_t> counts(kBins);
  const double scale = range.high > range.low ? kBins / (range.high - range.low) : 0;
  constexpr int kSlab = 32;  // chosen: 8 MB of a 256^3 volume at once
  for (int z = 0; z < dims[2]; z += kSlab) {
    const VoxelBox box{{0, 0, z}, {dims[0], dims[1], std::min(kSlab, dims[2] - z)}};
    for (const float value : board.read_volume(box)) {
      const double bin = (double{value} - range.low) * scale;
      ++counts[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))];
    }
  }
  tell(page, {{"type", "histogram"}, {"low", range.low}, {"high", range.high}, {"counts", counts}});
}

void Viewer::tell(Page page, const Json& message, bool droppable) { send_(page, packet(message, droppable)); }

void Viewer::tell(Page page, Json header, const std::vector<std::uint8_t>& bytes, bool droppable) {
  const std::string text = header.dump(-1, ' ', false, Json::error_handler_t::replace);
  auto all = std::make_shared<std::string>();
  all->reserve(4 + text.size() + bytes.size());
  for (int shift = 0; shift < 32; shift += 8) all->push_back(static_cast<char>(text.size() >> shift & 0xff));
  *all += text;
  all->append(bytes.begin(), bytes.end());
  send_(page, {std::move(all), true, droppable});
}

Progress Viewer::step(const std::string& what) {
  static constexpr std::chrono::milliseconds kEvery{200};  // chosen: short steps are not told of
  auto told = std::make_shared<std::chrono::steady_clock::time_point>(std::chrono::steady_clock::now());
  return [this, what, told](std::uint32_t done, std::uint32_t all) {
    const auto now = std::chrono::steady_clock::now();
    if (now - *told < kEvery) return;
    *told = now;
    tell(kAllPages, {{"type", "progress"}, {"text", what}, {"done", done}, {"all", all}}, true);
  };
}

std::optional<Viewer::Download> Viewer::download(const std::string& what, std::uint64_t number) {
  std::optional<Made> made;
  {
    const std::lock_guard lock(mutex_);
    const auto found = made_.find(number);
    if (found != made_.end()) made = found->second;
  }
  if (!made) return std::nullopt;
  if (what == "stats") return Download{"picture.json", "application/json", made->statistics};
  if (what == "tf") return Download{"view.tf", "text/plain", made->function};
  if (what != "png" && what != "exr") return std::nullopt;
  const std::filesystem::path file = options_.folder / (".picture." + what);
  write_image(made->image, file, what == "png" ? made->background : std::nullopt, made->provenance);
  return Download{"picture." + what, what == "png" ? "image/png" : "image/x-exr", bytes_of(file)};
}

}  // namespace gicube::samples::view
