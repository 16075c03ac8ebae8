// Bytes of a file, or of a compressed stream in it.
#pragma once

#include <bzlib.h>
#include <zlib.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gicube/scene/error.h"

namespace gicube::scene {

enum class Compression {
  kNone,
  kGzip,     // gzip or zlib, detected from the stream
  kDeflate,  // without a header
  kBzip2
};

// The position of a volume's samples.
struct DataPlace {
  std::filesystem::path file;
  std::uint64_t offset = 0;  // bytes of the file before the data, or before its compressed stream
  Compression compression = Compression::kNone;
  std::uint64_t skip = 0;                       // uncompressed bytes before the first sample
  bool nothing_after = false;                   // bytes after the samples are an error
  bool warns_of_more = false;                   // bytes after the samples give a warning
  std::vector<std::filesystem::path> series{};  // replaces `file`: each has the same share of the samples
};

// Reads forward. Throws FileError for a damaged compressed stream or a wrong checksum.
class DataStream {
 public:
  // Throws FileError when the file is missing, unreadable, no regular file, or shorter than the offset.
  DataStream(const std::filesystem::path& file, std::uint64_t offset, Compression compression);
  DataStream(const DataStream&) = delete;
  DataStream& operator=(const DataStream&) = delete;
  ~DataStream();

  // Fills `bytes` as far as there is data. Returns the number of bytes read.
  std::size_t read(std::span<std::byte> bytes);

  // An upper bound of the number of bytes that read() can return in total.
  std::uint64_t max_bytes() const;

 private:
  std::size_t read_file(void* bytes, std::size_t count);
  bool refill();
  void start_bzip2();
  void end_member();
  std::size_t inflate_some(std::span<std::byte> out);
  std::size_t decompress_some(std::span<std::byte> out);

  std::filesystem::path file_;
  std::ifstream input_;
  std::uint64_t bytes_;  // of the file, after the offset
  Compression compression_;
  bool ended_ = false;
  z_stream inflater_{};
  bz_stream decompressor_{};
  std::array<char, 65536> buffer_;
  std::span<char> input_left_;  // of the buffer
};

// The size of a regular file. Throws FileError when it is missing or not regular.
std::uint64_t file_bytes(const std::filesystem::path& file);

// The first bytes of a file as stored, at most `max_bytes`.
std::string file_start(const std::filesystem::path& file, std::size_t max_bytes);

bool starts_as_gzip(const std::filesystem::path& file);

// A stream positioned at the first sample. Throws FileError if the file is too small for `bytes` bytes.
std::unique_ptr<DataStream> open_data(const DataPlace& place, std::size_t bytes);
// To be called after the last byte: checks a compressed stream's checksum, and whether bytes follow that must not.
// Throws FileError. Warns once.
void end_data(DataStream& stream, DataPlace& place, std::size_t bytes);
[[noreturn]] void throw_truncated(const DataPlace& place, std::uint64_t bytes, const std::string& got);

// Reads exactly `bytes` bytes. Memory is allocated only if the file is large enough, and for compressed data only
// little more than was decompressed. Throws FileError (truncated, damaged, too long).
std::vector<std::byte> read_data(DataPlace place, std::size_t bytes);

}  // namespace gicube::scene
