// A file that is written completely or not at all. The data goes to a temporary file beside the target,
// NAME.XXXXXXXX.part. When all of it is on the disk, the temporary file is renamed to the target; until then the target
// does not change. If writing is abandoned, the temporary file is removed. Only a killed process leaves its .part file.
//
// Symbolic links are followed: the file that the link names is replaced or created. A new file takes over the mode of
// the file that it replaces, and its owner and group where that is permitted. A file that this user may not write, or
// that nobody may (mode 0444), is refused. Pipes, devices and open descriptors of this process (/dev/stdout, /dev/fd/N)
// are written directly.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace gicube {

// All calls throw std::system_error with the text "TARGET: REASON". After that the object may only be destroyed.
class WholeFile {
 public:
  // `mode`: permissions of a new file, before the umask. A file that replaces another gets no permissions beyond these.
  explicit WholeFile(const std::filesystem::path& target, unsigned mode = 0666);
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  ~WholeFile();

  void write(std::string_view bytes);
  template <typename Value, std::size_t N>
  void write(std::span<Value, N> values) {
    write(std::string_view(reinterpret_cast<const char*>(values.data()), values.size_bytes()));
  }
  void flush();   // writes the buffer to the operating system
  void close();   // all data is on the disk, under the temporary name; nothing more can be written
  void commit();  // close(), then renames the file to the target

 private:
  void put(std::string_view bytes);

  const std::filesystem::path target_;
  std::filesystem::path place_;  // the target with its links followed
  std::filesystem::path part_;   // empty: written directly, or committed
  int fd_ = -1;
  std::string waiting_;
};

// Returns false for an existing file that WholeFile would refuse.
bool may_be_written(const std::filesystem::path& file);

// Throws std::system_error if any output of this process did not reach standard output. Programs call it at their end;
// otherwise they would report success with a full disk behind `> FILE`.
void check_standard_output();

}  // namespace gicube
