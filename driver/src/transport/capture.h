// Writes every frame of a session to a file, both ways (docs/guide/capture.md).
#pragma once

#include <chrono>
#include <cstdint>
#include <fstream>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "gicube/wire/capture.h"
#include "gicube/wire/frame.h"

namespace gicube {

// All calls from any thread. A file that can't be written on, a full disk, ends there: the session goes on without it.
class Capture {
 public:
  // Throws OpenFailed that names the file.
  explicit Capture(const std::string& file);
  // Marks the end.
  ~Capture();

  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  void write(wire::CaptureKind kind, std::span<const std::uint8_t, wire::kFrameHeaderBytes> header,
             std::span<const std::uint8_t> payload);

 private:
  void begin_record(wire::CaptureKind kind);

  std::mutex mutex_;
  std::ofstream file_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

// For session `number` of a board, from 0: to `file`, session i > 0 to FILE.i. If `file` is empty, to what the environment
// variable GICUBE_CAPTURE names: the first session of this process to that file, the next ones to FILE.1, FILE.2. Null: to none.
std::shared_ptr<Capture> open_capture(const std::string& file, unsigned number);

}  // namespace gicube
