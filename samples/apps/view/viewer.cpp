#include "view/viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "gicube/scene/error.h"
#include "gicube/scene/transfer_function_file.h"
#include "scene/common/checks.h"
#include "scene/common/while_reading.h"
#include "view/folder.h"
#include "view/protocol.h"
#include "view/slices.h"

namespace gicube::samples::view {
namespace {

using Json = nlohmann::ordered_json;
using Kind = Request::Kind;

// Thrown from a call that waits for a board, because there is a newer request.
struct Stopped {};

constexpr const char* kGaveWay = "the comparison was stopped by another picture";
constexpr const char* kOpensAnother = "another file is opened instead";
constexpr const char* kNothingOpen = "nothing is open: name an input on the command line, or drop a file on the page";

// Whether a newer request stops this one.
bool is_picture(const std::optional<Request>& request) {
  return request && (request->kind == Kind::kPicture || request->kind == Kind::kCompare);
}
bool is_open(const std::optional<Request>& request) { return request && request->kind == Kind::kOpen; }

std::string name_of_input(const std::string& path) {
  const std::filesystem::path p(path);
  return path.starts_with("builtin:") ? path
         : p.has_filename()           ? p.filename().string()
                                      : p.parent_path().filename().string();
}

Packet packet(const Json& message, const std::string& kind = {}) {
  auto text = message.dump(-1, ' ', false, Json::error_handler_t::replace);
  return {std::make_shared<const std::string>(std::move(text)), false, kind};
}

Json numbers(const Vec3& v) { return {v.x, v.y, v.z}; }

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
        if (!look.machine.is_null()) message["look"] = look.machine;
        tell(page, message, with_units ? "" : "machine");  // units come once
      }) {
  shelf_.folder = options_.folder;
  for (const std::string& input : options_.inputs) shelf_.inputs.emplace(name_of_input(input), input);
  const auto look = options_.settings.find("transfer-function");
  std::error_code no_path;  // a text may be too long for a path
  if (look != options_.settings.end() && std::filesystem::is_regular_file(look->second, no_path)) {
    const std::string name = std::filesystem::path(look->second).filename().string();
    shelf_.functions[name] = std::exchange(look->second, name);
  }
  thread_ = std::thread([this] { work(); });
}

Viewer::~Viewer() {
  end({});
  thread_.join();
}

bool Viewer::end(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  ends_ = stop_ = true;
  wake_.notify_all();
  return wake_.wait_for(lock, patience, [this] { return ended_; });
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
  if (now_ && now_->page == page && (is_picture(now_->request) || is_open(now_->request))) stop_ = true;
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
    // A page's new picture stops its comparison, and a moving picture stops another page's whole picture.
    if (is_picture(request) && now_ && is_picture(now_->request) &&
        (now_->page == page || (request.kind == Kind::kPicture && request.on && !now_->request->on))) {
      stop_ = true;
    }
    if (is_open(request) && now_ && is_open(now_->request)) stop_ = true;
    full = std::ranges::count(jobs_, page, &Job::page) >= static_cast<std::ptrdiff_t>(kMaxWaiting);
    if (!full) jobs_.push_back({page, std::move(request)});
  }
  wake_.notify_all();
  if (dropped) failed(*dropped, kGaveWay, "");
  if (full) tell(page, {{"type", "error"}, {"text", "too many requests are waiting; try again"}});
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
    if (ends_) break;
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
  ended_ = true;
  wake_.notify_all();
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
  if (is_open(job.request)) return failed(job, kOpensAnother, "");
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
  if (job.page == kAllPages) fault_ = text;  // at the start, before any page has connected
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
  PostedFiles::Opening opening(*options_.files, names);
  const std::filesystem::path& folder = options_.files->folder();
  if (names.size() == 1 && ends(names.front(), {".tf"})) {
    // The file is named by its content, since another one may have the same name.
    shelf_.functions[names.front()] = file_of(bytes_of(folder / names.front()), shelf_);
    opening.keep();
    return send_(kAllPages, hello());
  }
  // The files are a header or a scene with its files, or slices, which get their own folder.
  const auto head = std::ranges::find_if(names, [&](const std::string& name) {
    return names.size() == 1 || is_scene_path(name) || ends(name, {".nhdr", ".mhd", ".hdr"});
  });
  const std::string name = head != names.end() ? *head : opening.into_folder();
  const std::string open = input_;
  const Shelf before = shelf_;
  shelf_.inputs[name] = (folder / name).string();
  try {
    const scene::WhileReading looks([this] { stop_if_told(); });
    open_input(name);
  } catch (...) {
    opening.undo();
    if (!goes_on()) throw;
    shelf_ = before;
    close_boards();
    if (!open.empty()) open_input(open);  // restore the previous input
    throw;
  }
  opening.keep();
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
  describe_values(setup, range, volume_);
  preset_texts_.clear();
  for (const Preset& preset : presets()) preset_texts_.push_back(tf_text(preset, &setup));
  box_ = {{"low", numbers(setup.grid.point_of(setup.box.low))}, {"high", numbers(setup.grid.point_of(setup.box.high))}};
  send_(kAllPages, hello());
  if (std::exchange(lost_, false)) {
    tell(kAllPages, {{"type", "board"}, {"state", "ready"}, {"text", "the board is ready"}});
  }
}

Packet Viewer::hello() {
  Json message{{"type", "hello"}};
  for (const auto& [name, path] : shelf_.inputs) message["inputs"].push_back(name);
  for (const auto& [name, path] : shelf_.functions) message["transfer_functions"].push_back(name);
  for (const char* list : {"inputs", "transfer_functions"}) {
    if (!message.contains(list)) message[list] = Json::array();
  }
  for (std::size_t i = 0; i < presets().size(); ++i) {
    const Preset& preset = presets()[i];
    message["presets"].push_back(
        {{"name", preset.name}, {"text", preset_texts_.empty() ? std::string(preset.text) : preset_texts_[i]}});
  }
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
  return packet(message);
}

Settings Viewer::completed(const Settings& settings) const {
  Settings all = settings;
  for (const auto& [name, value] : chosen_) {
    if ((name == "fov" && all.contains("orthographic")) || (name == "orthographic" && all.contains("fov"))) continue;
    all.emplace(name, value);
  }
  return all;
}

void Viewer::stop_if_told() {
  if (stop_) throw Stopped();
}

bool Viewer::goes_on() {
  const std::lock_guard lock(mutex_);
  if (!ends_) stop_ = false;
  return !ends_;
}

void Viewer::tell(Page page, const Json& message, const std::string& kind) { send_(page, packet(message, kind)); }

void Viewer::tell(Page page, const Json& header, const std::vector<std::uint8_t>& bytes, const std::string& kind) {
  const std::string text = header.dump(-1, ' ', false, Json::error_handler_t::replace);
  auto all = std::make_shared<std::string>();
  all->reserve(4 + text.size() + bytes.size());
  for (int shift = 0; shift < 32; shift += 8) all->push_back(static_cast<char>(text.size() >> shift & 0xff));
  *all += text;
  all->append(bytes.begin(), bytes.end());
  send_(page, {std::move(all), true, kind});
}

Progress Viewer::step(const std::string& what) {
  static constexpr std::chrono::milliseconds kEvery{200};  // chosen: short steps are not reported
  auto told = std::make_shared<std::chrono::steady_clock::time_point>(std::chrono::steady_clock::now());
  return [this, what, told](std::uint32_t done, std::uint32_t all) {
    const auto now = std::chrono::steady_clock::now();
    if (now - *told < kEvery) return;
    *told = now;
    tell(kAllPages, {{"type", "progress"}, {"text", what}, {"done", done}, {"all", all}}, "progress");
  };
}

}  // namespace gicube::samples::view
