// Captures of sessions.
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>

#include "frame_stream.h"
#include "gicube/wire/capture.h"

namespace gicube {
namespace {

// All calls from any thread.
class Capture {
 public:
  explicit Capture(const std::string& file) : file_(file, std::ios::binary | std::ios::trunc) {
    if (!file_) throw OpenFailed("capture: " + file + ": " + std::strerror(errno));
    put(wire::encoded(wire::CaptureHeader{}));
    file_.flush();
  }
  ~Capture() { begin_record(wire::CaptureKind::kEnd); }

  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  void write(wire::CaptureKind kind, std::span<const std::uint8_t> header, std::span<const std::uint8_t> payload) {
    const std::lock_guard lock(mutex_);
    begin_record(kind);
    put(header);
    put(payload);
  }

 private:
  void put(std::span<const std::uint8_t> bytes) {
    file_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  void begin_record(wire::CaptureKind kind) {
    const std::chrono::nanoseconds age = std::chrono::steady_clock::now() - begin_;
    put(wire::encoded(wire::CaptureRecord{kind, static_cast<std::uint64_t>(age.count())}));
  }

  std::mutex mutex_;
  std::ofstream file_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace

FrameTap capture_session(const std::string& file, unsigned number) {
  static std::atomic<unsigned> from_environment{0};
  std::string name = file;
  if (name.empty()) {
    const char* named = std::getenv("GICUBE_CAPTURE");
    if (named == nullptr || *named == '\0') return {};
    name = named;
    number = from_environment++;
  }
  if (number > 0) name += '.' + std::to_string(number);
  return [capture = std::make_shared<Capture>(name)](bool sent, auto header, auto payload) {
    capture->write(sent ? wire::CaptureKind::kDown : wire::CaptureKind::kUp, header, payload);
  };
}

}  // namespace gicube
