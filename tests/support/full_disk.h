// Disks that are full, and what whoever writes files owes his caller on them.
#pragma once

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <csignal>
#include <exception>
#include <iostream>

#include "temporary_directory.h"
#include "test.h"

namespace gicube::reference {

// Writes beyond so many bytes of a file fail, of this process and of those that it starts meanwhile: "File too large".
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limited{bytes, before_.rlim_max};
    EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &limited), 0);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

// A tmpfs of so many bytes, which only this thread and what it starts can see: "No space left on device".
class SmallDisk {
 public:
  explicit SmallDisk(std::size_t bytes) {
    static const bool own_mounts =
        ::unshare(CLONE_NEWNS) == 0 && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
    mounted_ = own_mounts &&
               ::mount("none", folder_.path().c_str(), "tmpfs", 0, ("size=" + std::to_string(bytes)).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(folder_.path().c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool mounted() const { return mounted_; }
  std::string path() const { return folder_.path(); }

 private:
  TemporaryDirectory folder_;
  bool mounted_ = false;
};

constexpr std::size_t kDiskBlock = 4096;  // bytes of a tmpfs, on machines with such pages

// The names of a folder's files, and what is in them.
inline std::map<std::string, std::string> files_in(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream stream(entry.path(), std::ios::binary);
    files[entry.path().filename().string()] = {std::istreambuf_iterator<char>(stream), {}};
  }
  return files;
}

// Calls `use` with a folder in which file `name` holds "before" and a new one can get to `room` bytes, a multiple of
// kDiskBlock, and with the reason that a longer one fails for: on a full tmpfs, where this process may mount one, and
// under a limit of file sizes, always.
inline void on_full_disks(const std::string& name, std::size_t room,
                          const std::function<void(const std::string& folder, const std::string& reason)>& use) {
  const auto prepare = [&](const std::string& folder) {
    std::ofstream(folder + "/" + name) << "before";
    return folder;
  };
  if (const SmallDisk disk(room + kDiskBlock); disk.mounted()) {
    use(prepare(disk.path()), "No space left on device");
  } else {
    std::cout << "no tmpfs may be mounted here: full disks are tested by a limit of file sizes alone\n";
  }
  const TemporaryDirectory folder;
  prepare(folder.path());
  const FileSizeLimit limit(room);
  use(folder.path(), "File too large");
}

// `write` throws, its text names the file or one that begins like it, and the reason; and the folder is as it was.
inline void expect_full_disk_leaves_nothing(const std::string& name, std::size_t room,
                                            const std::function<void(const std::string& file)>& write) {
  on_full_disks(name, room, [&](const std::string& folder, const std::string& reason) {
    std::string text = "no exception";
    try {
      write(folder + "/" + name);
    } catch (const std::exception& error) {
      text = error.what();
    }
    const std::string stem = name.substr(0, name.find_first_of("._"));
    EXPECT_NE(text.find(folder + "/" + stem), std::string::npos) << text;
    EXPECT_NE(text.find(reason), std::string::npos) << text;
    EXPECT_EQ(files_in(folder), (std::map<std::string, std::string>{{name, "before"}})) << name << ": " << reason;
  });
}

}  // namespace gicube::reference
