// Executes the requests of pages (protocol.h) on one thread, the only one that calls the boards.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "render/renderer.h"
#include "view/live_counters.h"
#include "view/posted.h"
#include "view/request.h"
#include "view/settings.h"

namespace gicube::samples::view {

// A message to a page.
struct Packet {
  std::shared_ptr<const std::string> bytes;
  bool binary = false;
  std::string kind{};  // superseded by a newer one of its kind; empty: never
};

using Page = std::uint64_t;
constexpr Page kAllPages = 0;

struct ViewOptions {
  std::vector<std::string> inputs;
  Settings settings;             // --fix
  std::filesystem::path folder;  // for files of the viewer
  PostedFiles* files = nullptr;
  BoardOptions board;
};

class Viewer {
 public:
  // `send` is called on the viewer's thread and on that of ask(). The viewer's thread reads the input; errors are sent
  // to the pages.
  Viewer(const ViewOptions& options, std::function<void(Page, const Packet&)> send);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  // Stops the current job, and accepts no more. Returns whether it has ended in time: some steps, such as voxelising a
  // world, cannot be stopped.
  bool end(std::chrono::milliseconds patience);

  // These may be called from any thread.
  void come(Page page);  // the page gets "hello"
  void leave(Page page);
  void ask(Page page, Request request);

  struct Download {
    std::string name, type, bytes;
  };
  // png, exr, stats or tf of a whole picture, by its number; nothing if it does not exist, or no longer.
  std::optional<Download> download(const std::string& what, std::uint64_t number);

 private:
  struct Job {
    Page page = 0;
    std::optional<Request> request;  // unset: send "hello"
  };
  // A board with the open input.
  struct Desk {
    std::unique_ptr<Renderer> renderer;
    std::string uri;
    double ray_seconds = 0;  // last host time per pixel's ray and voxel of step; 0: unknown
  };
  struct Made {
    Image image;
    std::optional<Background> background;
    std::string statistics, function;
    Provenance provenance;
  };

  void work();
  void carry_out(const Job& job);
  // After a stop: whether the page has a newer request. If not, another page's picture took precedence, and the job is
  // repeated.
  bool make_way(const Job& job);
  void failed(const Job& job, const std::string& text, const std::string& field);
  void lose(const std::string& text);

  void open_input(const std::string& name);
  void open_files(const std::vector<std::string>& names);
  void close_boards();
  // The board for `options`, opened if necessary.
  Desk& desk(const RenderOptions& options);
  // The board of coarse pictures, slices and histograms: the same, or another functional one.
  Desk& quick_desk(const RenderOptions& options);
  Desk make_desk(const RenderOptions& options);
  // Sets the options of `desk`, on a new board if the old one would make other pictures than gicube-render.
  void serve(Desk& desk, const RenderOptions& options);
  // A renderer whose board has the open input's voxels.
  Renderer& volume_renderer();

  void picture(const Job& job);
  void compare(const Job& job);
  void slice(const Job& job);
  void histogram(Page page);
  Frame render(Desk& desk, const RenderOptions& options);
  void send_picture(const Job& job, Desk& desk, const RenderOptions& options, const Settings& settings, bool whole);
  Packet hello();
  Settings completed(const Settings& settings) const;
  // `kind`: Packet::kind.
  void tell(Page page, const nlohmann::ordered_json& message, const std::string& kind = {});
  void tell(Page page, const nlohmann::ordered_json& header, const std::vector<std::uint8_t>& bytes,
            const std::string& kind);
  Progress step(const std::string& what);
  void stop_if_told();
  // After a stop: whether the viewer continues.
  bool goes_on();

  ViewOptions options_;
  std::function<void(Page, const Packet&)> send_;
  Shelf shelf_;
  Settings chosen_;  // of the open input, complete
  nlohmann::ordered_json volume_, box_;
  std::vector<std::string> preset_texts_;  // of tf_text(); empty until an input is open
  std::string input_;                      // open; empty: none
  bool lost_ = false;
  std::string fault_;  // why the board is lost, or nothing is open
  Desk main_, quick_;

  std::mutex mutex_;  // guards the following members
  std::condition_variable wake_;
  std::deque<Job> jobs_;
  std::optional<Job> now_;
  std::map<std::uint64_t, Made> made_;  // the last ones, by number
  std::uint64_t last_number_ = 0;
  bool ends_ = false, ended_ = false;
  std::atomic<bool> stop_ = false;  // stops the current call
  LiveCounters live_;
  std::thread thread_;
};

}  // namespace gicube::samples::view
