// Files that pages post. A new one waits in a folder beside those that were opened, until it is opened itself: one that
// can't be takes nothing from them, not even by their name.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "scene/names.h"
#include "view/protocol.h"

namespace gicube::samples::view {

// Calls from any thread, but Opening's from one.
class PostedFiles {
 public:
  // `folder` has those that were opened.
  explicit PostedFiles(std::filesystem::path folder);

  const std::filesystem::path& folder() const { return folder_; }

  // One that comes. Its bytes count from here on, and no longer if it goes before it is kept.
  class Part {
   public:
    Part(PostedFiles& all, const std::string& name);
    ~Part();
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    // Takes room for so many bytes. False: there is none; those that it will replace do not count.
    bool take(std::uint64_t bytes);
    // Bytes that it has taken room for.
    void write(std::string_view bytes) { stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); }
    // It waits to be opened. False: the disk had no room.
    bool keep();

   private:
    PostedFiles& all_;
    std::filesystem::path path_, target_;
    std::uint64_t replaced_ = 0, taken_ = 0;
    bool kept_ = false;
    std::ofstream stream_;
  };

  // Gives waiting files their places in the folder; what had them comes back unless they are kept.
  class Opening {
   public:
    // Throws InputError: there is none of such a name.
    Opening(PostedFiles& all, const std::vector<std::string>& names);
    ~Opening();
    Opening(const Opening&) = delete;
    Opening& operator=(const Opening&) = delete;

    // Moves them into a new folder, whose name it returns.
    std::string into_folder();
    void keep();
    void undo();  // what the destructor does, unless they are kept

   private:
    PostedFiles& all_;
    std::vector<std::string> names_, new_;  // new: those that waited
    std::filesystem::path slices_;          // empty: none
    bool done_ = false;                     // kept or undone
  };

 private:
  std::filesystem::path waiting(const std::string& name) const { return folder_ / ".new" / name; }
  std::filesystem::path aside(const std::string& name) const { return folder_ / ".old" / name; }
  void remove(const std::filesystem::path& file);

  const std::filesystem::path folder_;
  std::mutex mutex_;  // of what has which name
  std::atomic<std::uint64_t> bytes_ = 0;
  std::atomic<std::uint64_t> last_part_ = 0;
};

}  // namespace gicube::samples::view
