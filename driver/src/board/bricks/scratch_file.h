// An unnamed file in the folder TMPDIR, or in /var/tmp. It ends with the process.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "transport/fd.h"

namespace gicube {

class ScratchFile {
 public:
  // `what`: its content for error messages, for instance "a volume larger than the card". Throws Error that names the
  // folder.
  explicit ScratchFile(std::string what);

  // Throws Error: the folder is full, or the file can't be written.
  void write(std::uint64_t at, std::span<const std::uint8_t> bytes);
  // Throws Error: the file can't be read, or is shorter.
  void read(std::uint64_t at, std::span<std::uint8_t> bytes) const;

 private:
  [[noreturn]] void fail(const char* does, const std::string& got) const;
  void in_steps(std::size_t bytes, const char* does, const auto& step) const;

  std::string what_;
  Fd file_;
};

}  // namespace gicube
