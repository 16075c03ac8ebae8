// A text file that is written in large pieces of whole records, so that what a killed process leaves ends with one.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace gicube::emu {

class TextFile {
 public:
  // Creates the file anew. Throws std::runtime_error that names it.
  explicit TextFile(const std::string& path) : path_(path), file_(path, std::ios::binary | std::ios::trunc) {
    if (!file_) throw std::runtime_error("expected a file that can be written, got " + path);
    text_.reserve(2 * kPiece);
  }
  ~TextFile() { flush(); }

  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  template <typename... Args>
  void add(fmt::format_string<Args...> text, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), text, std::forward<Args>(args)...);
  }
  void end_record() {
    if (text_.size() >= kPiece) flush();
  }
  void flush() { flush_with(""); }
  // Writes everything, and `ending` behind it; the next record will overwrite the ending.
  void flush_with(std::string_view ending) {
    if (!file_) return text_.clear();
    file_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
    text_.clear();
    const std::streampos end = file_.tellp();
    file_ << ending << std::flush;
    if (!ending.empty()) file_.seekp(end);
    if (!file_) remove();
  }

  const std::string& path() const { return path_; }
  // False once a write has failed, on a full disk for instance; the file is gone then, and nothing is written after that.
  bool good() const { return static_cast<bool>(file_); }

 private:
  void remove() {
    file_.close();
    std::error_code ignored;
    if (std::filesystem::is_regular_file(path_, ignored)) std::filesystem::remove(path_, ignored);
  }

  static constexpr std::size_t kPiece = std::size_t{64} << 10;  // chosen: some thousand records

  std::string path_;
  std::ofstream file_;
  std::string text_;  // not written yet
};

}  // namespace gicube::emu
