// A text file that grows record by record and is written in large pieces of whole records, so that what a killed process
// leaves behind ends with a whole record.
#pragma once

#include <cstddef>
#include <fstream>
#include <string>
#include <string_view>

namespace gicube::emu {

class TextFile {
 public:
  // Creates the file anew. Throws std::runtime_error that names it.
  explicit TextFile(const std::string& path);
  ~TextFile() { flush(); }

  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  // The end of what was not written yet: records are appended here, then end_record().
  std::string& text() { return text_; }
  void end_record() {
    if (text_.size() >= kPiece) flush();
  }
  void flush();
  // Writes everything, and `ending` behind it; the next record will overwrite the ending.
  void flush_with(std::string_view ending);

  const std::string& path() const { return path_; }
  // False once a write has failed, on a full disk for instance; nothing is written after that.
  bool good() const { return static_cast<bool>(file_); }

 private:
  static constexpr std::size_t kPiece = std::size_t{64} << 10;  // chosen: some thousand records

  std::string path_;
  std::ofstream file_;
  std::string text_;
};

}  // namespace gicube::emu
