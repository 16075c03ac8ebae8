// Reads a capture from front to back (docs/guide/capture.md), gzipped or not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <vector>

#include "gicube/wire/capture.h"
#include "gicube/wire/frame.h"

namespace gicube::replay {

// The file is no capture, or damaged; the text names it and the byte.
class CaptureError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct CapturedFrame {
  wire::CaptureRecord record;
  wire::FrameHeader header;
  std::vector<std::uint8_t> payload;
};

class CaptureReader {
 public:
  // Throws CaptureError.
  explicit CaptureReader(const std::filesystem::path& file);
  ~CaptureReader();
  CaptureReader(CaptureReader&&) noexcept;

  // The next frame; false at the end. Throws CaptureError: a record or frame that can't be, a wrong checksum. Memory is
  // taken only as far as the file goes.
  bool next(CapturedFrame& frame);
  // After the end: whether the capture was completed, or its process died before.
  bool complete() const { return complete_; }

 private:
  struct File;

  std::size_t read(std::uint8_t* bytes, std::size_t count);
  [[noreturn]] void fail(const std::string& what) const;

  std::filesystem::path name_;
  std::unique_ptr<File> file_;
  std::uint64_t at_ = 0;  // byte, uncompressed
  bool complete_ = false;
};

}  // namespace gicube::replay
