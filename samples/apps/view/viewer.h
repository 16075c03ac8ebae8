// Carries out what pages ask for (protocol.h): one thread, which alone calls the boards.
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
  std::string kind{};  // pointless once a newer one of its kind follows; empty: never
};

using Page = std::uint64_t;
constexpr Page kAllPages = 0;

struct ViewOptions {
  std::vector<std::string> inputs;
  Settings settings;             // --fix
  std::filesystem::path folder;  // for what the viewer writes
  PostedFiles* files = nullptr;
  BoardOptions board;
};

class Viewer {
 public:
  // `send` is called from the viewer's thread and from that of ask(). The input is read by the viewer's; what goes
  // wrong is told to the pages.
  Viewer(const ViewOptions& options, std::function<void(Page, const Packet&)> send);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  // Stops what is under way, and takes no more. Whether that has ended in time: some steps, as making a world's voxels,
  // do not stop.
  bool end(std::chrono::milliseconds patience);

  // From any thread.
  void come(Page page);  // it gets hello
  void leave(Page page);
  void ask(Page page, Request request);

  struct Download {
    std::string name, type, bytes;
  };
  // png, exr, stats or tf of a whole picture, by its number; nothing if it is not there, or no longer.
  std::optional<Download> download(const std::string& what, std::uint64_t number);

 private:
  struct Job {
    Page page = 0;
    std::optional<Request> request;  // none: hello
  };
  // A board with the open input.
  struct Desk {
    std::unique_ptr<Renderer> renderer;
    std::string uri;
    double ray_seconds = 0;  // host time of a voxel's length of a pixel's ray, as last seen; 0: not known
  };
  struct Made {
    Image image;
    std::optional<Background> background;
    std::string statistics, function;
    Provenance provenance;
  };

  void work();
  void carry_out(const Job& job);
  // After a stop: whether the page has asked for something newer. If not, another page's picture came between, and it
  // is done again.
  bool make_way(const Job& job);
  void failed(const Job& job, const std::string& text, const std::string& field);
  void lose(const std::string& text);

  void open_input(const std::string& name);
  void open_files(const std::vector<std::string>& names);
  void close_boards();
  // The board that `options` ask for, opened if need be.
  Desk& desk(const RenderOptions& options);
  // The board of coarse pictures, slices and histograms: the same, or a functional one beside it.
  Desk& quick_desk(const RenderOptions& options);
  Desk make_desk(const RenderOptions& options);
  // Has `desk` serve `options`, on a new board where one would make other pictures than gicube-render.
  void serve(Desk& desk, const RenderOptions& options);
  // One whose board holds the open input's voxels.
  Renderer& volume_renderer();

  void picture(const Job& job);
  void compare(const Job& job);
  void slice(const Job& job);
  void histogram(Page page);
  Frame render(Desk& desk, const RenderOptions& options);
  void send_picture(const Job& job, Desk& desk, const RenderOptions& options, const Settings& settings, bool whole);
  Packet hello();
  Settings completed(const Settings& settings) const;
  // `kind`: as Packet's.
  void tell(Page page, const nlohmann::ordered_json& message, const std::string& kind = {});
  void tell(Page page, const nlohmann::ordered_json& header, const std::vector<std::uint8_t>& bytes,
            const std::string& kind);
  Progress step(const std::string& what);
  void stop_if_told();
  // After a stop of what was under way: whether there is something to go on for.
  bool goes_on();

  ViewOptions options_;
  std::function<void(Page, const Packet&)> send_;
  Shelf shelf_;
  Settings chosen_;  // of the open input: complete
  nlohmann::ordered_json volume_, box_;
  std::vector<std::string> preset_texts_;  // as of tf_text(); empty before an input is open
  std::string input_;                      // open; empty: none
  bool lost_ = false;
  std::string fault_;  // why it is lost, or nothing is open
  Desk main_, quick_;

  std::mutex mutex_;  // of what follows
  std::condition_variable wake_;
  std::deque<Job> jobs_;
  std::optional<Job> now_;
  std::map<std::uint64_t, Made> made_;  // the last ones, by number
  std::uint64_t last_number_ = 0;
  bool ends_ = false, ended_ = false;
  std::atomic<bool> stop_ = false;  // the call under way
  LiveCounters live_;
  std::thread thread_;
};

}  // namespace gicube::samples::view
