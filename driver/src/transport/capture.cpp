#include "capture.h"

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "gicube/error.h"

namespace gicube {
namespace {

void put(std::ofstream& file, const auto& bytes) {
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

Capture::Capture(const std::string& file) : file_(file, std::ios::binary | std::ios::trunc) {
  if (!file_) throw OpenFailed("capture: " + file + ": " + std::strerror(errno));
  put(file_, wire::encoded(wire::CaptureHeader{}));
  file_.flush();
}

Capture::~Capture() { begin_record(wire::CaptureKind::kEnd); }

void Capture::write(wire::CaptureKind kind, std::span<const std::uint8_t, wire::kFrameHeaderBytes> header,
                    std::span<const std::uint8_t> payload) {
  const std::lock_guard lock(mutex_);
  begin_record(kind);
  put(file_, header);
  put(file_, payload);
}

void Capture::begin_record(wire::CaptureKind kind) {
  const auto age = std::chrono::steady_clock::now() - begin_;
  const auto ns = static_cast<std::uint64_t>(std::chrono::nanoseconds(age).count());
  put(file_, wire::encoded(wire::CaptureRecord{kind, ns}));
}

std::shared_ptr<Capture> open_capture(const std::string& file, unsigned number) {
  static std::atomic<unsigned> from_environment{0};
  std::string name = file;
  if (name.empty()) {
    const char* named = std::getenv("GICUBE_CAPTURE");
    if (named == nullptr || *named == '\0') return nullptr;
    name = named;
    number = from_environment++;
  }
  if (number > 0) name += '.' + std::to_string(number);
  return std::make_shared<Capture>(name);
}

}  // namespace gicube
