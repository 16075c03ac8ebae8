// A file that is whole or not there: its bytes go to a temporary file beside the target, NAME.XXXXXXXX.part, which takes the target's
// name when all of them are on the disk. Until then what the target was stays. Whatever ends the writing before leaves nothing, but
// for a process that is killed: it leaves the .part.
//
// A symbolic link is followed: the file that it names is replaced, or made. A file that is replaced hands on its mode,
// and its owner and group where that is allowed. One that this user may not write to, or that nobody may (mode 0444),
// is refused. A pipe, a device, and what this process has open (/dev/stdout, /dev/fd/N) is written to directly.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace gicube {

// All calls throw std::system_error, whose text is "TARGET: REASON"; the object is good for nothing then but to be destroyed.
class WholeFile {
 public:
  // `mode`: a new file's permissions, from which the umask takes. One that replaces another has no more of them than
  // these.
  explicit WholeFile(const std::filesystem::path& target, unsigned mode = 0666);
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  ~WholeFile();

  void write(std::string_view bytes);
  template <typename Value, std::size_t N>
  void write(std::span<Value, N> values) {
    write(std::string_view(reinterpret_cast<const char*>(values.data()), values.size_bytes()));
  }
  void flush();   // to the operating system
  void close();   // all is on the disk, under the temporary name; no more is written
  void commit();  // close(), and the target's name

 private:
  void put(std::string_view bytes);

  const std::filesystem::path target_;
  std::filesystem::path place_;  // where its links lead
  std::filesystem::path part_;   // empty: written directly, or committed
  int fd_ = -1;
  std::string waiting_;
};

// False for a file that a WholeFile refuses since it may not be written to.
bool may_be_written(const std::filesystem::path& file);

// Throws std::system_error unless all that this process has printed got to standard output. For the end of a program, which else ends
// well with a full disk behind `> FILE`.
void check_standard_output();

}  // namespace gicube
