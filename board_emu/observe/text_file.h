// A text file that is written in large pieces of whole records. If the process is killed, the file ends with a whole
// record.
#pragma once

#include <fmt/format.h>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace gicube::emu {

// kNew: fails if the name exists, even as a symbolic link.
enum class Creation { kReplaces, kNew };

class TextFile {
 public:
  // Creates or replaces the file. Throws std::runtime_error, which names it.
  explicit TextFile(const std::string& path, Creation creation = Creation::kReplaces)
      : path_(path), file_(std::fopen(path.c_str(), creation == Creation::kNew ? "wbxe" : "wbe"), &std::fclose) {
    if (!file_) {
      const bool is_there = creation == Creation::kNew && errno == EEXIST;
      throw std::runtime_error(
          (is_there ? "expected the name of a new file, got " : "expected a file that can be written, got ") + path);
    }
    std::setvbuf(file_.get(), nullptr, _IONBF, 0);  // the pieces are large
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
  // Writes everything, and then `ending`, which the next record overwrites.
  void flush_with(std::string_view ending) {
    if (!file_) return text_.clear();
    const bool written = write(text_);
    text_.clear();
    const long end = std::ftell(file_.get());
    const bool ended = ending.empty() || (write(ending) && std::fseek(file_.get(), end, SEEK_SET) == 0);
    if (!written || !ended) remove();
  }

  const std::string& path() const { return path_; }
  // False after a write has failed, for example on a full disk. The file is then removed, and nothing more is written.
  bool good() const { return file_ != nullptr; }

 private:
  bool write(std::string_view bytes) { return std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size(); }
  void remove() {
    file_.reset();
    std::error_code ignored;
    if (std::filesystem::is_regular_file(path_, ignored)) std::filesystem::remove(path_, ignored);
  }

  static constexpr std::size_t kPiece = std::size_t{64} << 10;  // chosen: some thousand records

  std::string path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::string text_;  // not yet written
};

}  // namespace gicube::emu
