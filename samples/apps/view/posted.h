// Files posted by pages. A new file waits in another folder than the opened ones until it is opened. If that fails, the
// opened files are unchanged, even one of the same name.
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

// May be used from any thread, Opening from one only.
class PostedFiles {
 public:
  // `folder` has the opened files.
  explicit PostedFiles(std::filesystem::path folder);

  const std::filesystem::path& folder() const { return folder_; }

  // A file being received. Its bytes count until it is destroyed without keep().
  class Part {
   public:
    Part(PostedFiles& all, const std::string& name);
    ~Part();
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    // Reserves room for this many bytes. False: there is not enough; the bytes of a replaced file do not count.
    bool take(std::uint64_t bytes);
    // Appends bytes, for which room is reserved.
    void write(std::string_view bytes) { stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); }
    // Completes the file, which then waits to be opened. False: the disk is full.
    bool keep();

   private:
    PostedFiles& all_;
    std::filesystem::path path_, target_;
    std::uint64_t replaced_ = 0, taken_ = 0;
    bool kept_ = false;
    std::ofstream stream_;
  };

  // Moves waiting files into the folder. Files that they replace come back unless keep() is called.
  class Opening {
   public:
    // Throws InputError: there is no file of such a name.
    Opening(PostedFiles& all, const std::vector<std::string>& names);
    ~Opening();
    Opening(const Opening&) = delete;
    Opening& operator=(const Opening&) = delete;

    // Moves them into a new folder, whose name it returns.
    std::string into_folder();
    void keep();
    void undo();  // called by the destructor unless they are kept

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
  std::mutex mutex_;  // guards moving files
  std::atomic<std::uint64_t> bytes_ = 0;
  std::atomic<std::uint64_t> last_part_ = 0;
};

}  // namespace gicube::samples::view
