#include "scene/formats/reading_child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <span>
#include <system_error>
#include <utility>

#include "scene/common/while_reading.h"
#include "scene/formats/data_stream.h"

namespace gicube::scene {
namespace {

constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;  // chosen: bytes in addition to the samples
constexpr std::uint64_t kMaxRatio = 16384;                 // chosen: bytes of memory per byte of the file
constexpr std::size_t kChunk = std::size_t{1} << 20;       // chosen
constexpr std::size_t kMaxText = 4096;                     // chosen: names in a damaged file may have any length

// The fixed part of a LibraryVolume.
struct Numbers {
  Dims dims;
  StoredType type;
  Vec3 spacing;
  WorldPlacement placement;
  std::size_t warnings, sample_bytes;
  bool has_fault;
};
static_assert(std::is_trivially_copyable_v<Numbers>);

void send(int to, const void* bytes, std::size_t count) {
  const char* at = static_cast<const char*>(bytes);
  while (count > 0) {
    const ssize_t done = ::write(to, at, count);
    if (done < 0 && errno != EINTR) ::_exit(1);
    if (done < 0) continue;
    at += done;
    count -= static_cast<std::size_t>(done);
  }
}

void send(int to, const std::string& text) {
  const std::size_t bytes = std::min(text.size(), kMaxText);
  send(to, &bytes, sizeof bytes);
  send(to, text.data(), bytes);
}

void send(int to, const FileFault& fault) {
  for (const std::string& text : {fault.file.string(), fault.field, fault.expected, fault.got}) send(to, text);
}

// Frees the whole pages among these bytes, whose values are lost.
void give_back(const std::byte* bytes, std::size_t count) {
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const std::uintptr_t begin = (reinterpret_cast<std::uintptr_t>(bytes) + page - 1) / page * page;
  const std::uintptr_t end = (reinterpret_cast<std::uintptr_t>(bytes) + count) / page * page;
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
}

// The size of this process's address space.
std::uint64_t own_memory() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void limit(int what, std::uint64_t most) {
  rlimit now{};
  if (::getrlimit(what, &now) != 0) return;
  now.rlim_cur = std::min<rlim_t>(most, now.rlim_max);
  ::setrlimit(what, &now);
}

class Child {
 public:
  Child(const std::filesystem::path& file, std::uint64_t bytes, const std::function<LibraryVolume()>& read)
      : file_(file) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
    child_ = ::fork();
    if (child_ < 0) {
      const int fault = errno;
      for (const int end : ends) ::close(end);
      throw std::system_error(fault, std::generic_category(), "fork");
    }
    if (child_ == 0) {
      ::signal(SIGPIPE, SIG_DFL);
      for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) ::signal(signal, SIG_DFL);
      limit(RLIMIT_CORE, 0);
      limit(RLIMIT_CPU, kReadingSeconds + bytes / kBytesASecond);
      const std::uint64_t samples =
          std::min(kMaxVolumeBytes + kMaxVolumeBytes / 4, std::min(bytes, kMaxVolumeBytes) * kMaxRatio);
      limit(RLIMIT_AS, own_memory() + kMemory + samples);
      answer(ends[1], read());
      ::_exit(0);
    }
    ::close(ends[1]);
    from_ = ends[0];
  }
  ~Child() {
    ::close(from_);
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      ::waitpid(child_, nullptr, 0);
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  LibraryVolume result() {
    Numbers numbers{};
    receive(&numbers, sizeof numbers);
    LibraryVolume out;
    StoredLayout& layout = out.layout;
    layout.dims = numbers.dims;
    layout.type = numbers.type;
    layout.spacing = numbers.spacing;
    layout.placement = numbers.placement;
    for (std::size_t i = 0; i < numbers.warnings; ++i) out.warnings.push_back(receive_fault());
    if (numbers.has_fault) out.fault = receive_fault();
    out.samples.reserve(numbers.sample_bytes);
    while (out.samples.size() < numbers.sample_bytes) {
      WhileReading::look();
      const std::size_t had = out.samples.size();
      out.samples.resize(std::min(numbers.sample_bytes, had + kChunk));
      receive(out.samples.data() + had, out.samples.size() - had);
    }
    return out;
  }

 private:
  static void answer(int to, const LibraryVolume& volume) {
    const StoredLayout& l = volume.layout;
    const Numbers numbers{l.dims,
                          l.type,
                          l.spacing,
                          l.placement,
                          volume.warnings.size(),
                          volume.samples.size(),
                          volume.fault.has_value()};
    send(to, &numbers, sizeof numbers);
    for (const FileFault& warning : volume.warnings) send(to, warning);
    if (volume.fault) send(to, *volume.fault);
    // Sent pages are freed, so that both processes together hold the samples only once.
    for (std::size_t at = 0; at < volume.samples.size(); at += kChunk) {
      send(to, volume.samples.data() + at, std::min(kChunk, volume.samples.size() - at));
      give_back(volume.samples.data() + at, std::min(kChunk, volume.samples.size() - at));
    }
  }

  void receive(void* bytes, std::size_t count) {
    char* at = static_cast<char*>(bytes);
    while (count > 0) {
      const ssize_t done = ::read(from_, at, count);
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) throw_ended();
      at += done;
      count -= static_cast<std::size_t>(done);
    }
  }

  std::string receive_text() {
    std::size_t bytes = 0;
    receive(&bytes, sizeof bytes);
    std::string text(std::min(bytes, kMaxText), '\0');
    receive(text.data(), text.size());
    return text;
  }
  FileFault receive_fault() {
    FileFault fault;
    fault.file = receive_text();
    fault.field = receive_text();
    fault.expected = receive_text();
    fault.got = receive_text();
    return fault;
  }

  [[noreturn]] void throw_ended() {
    int status = 0;
    ::waitpid(std::exchange(child_, 0), &status, 0);
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    throw FileError(file_, "file", "one that its library can read",
                    signal == SIGXCPU || signal == SIGKILL
                        ? "one that takes too long (damaged)"
                        : fmt::format("a damaged one: the library ended by signal {}", signal));
  }

  std::filesystem::path file_;
  pid_t child_ = 0;
  int from_ = -1;
};

}  // namespace

LibraryVolume read_in_child(const std::filesystem::path& file, const std::function<LibraryVolume()>& read) {
  return Child(file, file_bytes(file), read).result();
}

}  // namespace gicube::scene
