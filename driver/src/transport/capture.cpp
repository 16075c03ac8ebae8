// Captures of sessions.
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "frame_stream.h"
#include "gicube/whole_file.h"
#include "gicube/wire/capture.h"

namespace gicube {
namespace {

constexpr unsigned kOwnersOnly = 0600;  // a capture holds all that the application sent

// All functions may be called on any thread.
class Capture {
 public:
  explicit Capture(const std::string& name) {
    try {
      file_.emplace(name, kOwnersOnly);
      put(wire::encoded(wire::CaptureHeader{}));
      file_->flush();
    } catch (const std::system_error& error) {
      throw OpenFailed(std::string("capture: ") + error.what());
    }
  }
  // A destructor can't throw: it reports the failure.
  ~Capture() {
    if (!file_) return;
    try {
      begin_record(wire::CaptureKind::kEnd);
      file_->commit();
    } catch (const std::system_error& error) {
      std::fprintf(stderr, "gicube: capture: %s\n", error.what());
    }
  }

  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  void write(wire::CaptureKind kind, std::span<const std::uint8_t> header, std::span<const std::uint8_t> payload) {
    const std::lock_guard lock(mutex_);
    if (!file_) throw std::runtime_error("capture: an earlier write failed");
    try {
      begin_record(kind);
      put(header);
      put(payload);
      file_->flush();
    } catch (const std::system_error& error) {
      file_.reset();  // frees its space on the full disk
      throw std::runtime_error(std::string("capture: ") + error.what());
    }
  }

 private:
  void put(std::span<const std::uint8_t> bytes) { file_->write(bytes); }
  void begin_record(wire::CaptureKind kind) {
    const std::chrono::nanoseconds age = std::chrono::steady_clock::now() - begin_;
    put(wire::encoded(wire::CaptureRecord{kind, static_cast<std::uint64_t>(age.count())}));
  }

  std::mutex mutex_;
  std::optional<WholeFile> file_;  // empty after a failed write
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
