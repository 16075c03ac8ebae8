#include "observe/text_file.h"

#include <stdexcept>

namespace gicube::emu {

TextFile::TextFile(const std::string& path) : path_(path), file_(path, std::ios::binary | std::ios::trunc) {
  if (!file_) throw std::runtime_error("expected a file that can be written, got " + path);
  text_.reserve(2 * kPiece);
}

void TextFile::flush() {
  file_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
  file_.flush();
  text_.clear();
}

void TextFile::flush_with(std::string_view ending) {
  file_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
  text_.clear();
  const std::streampos end = file_.tellp();
  file_ << ending << std::flush;
  file_.seekp(end);
}

}  // namespace gicube::emu
