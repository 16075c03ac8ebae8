// Bytes of a file, as they are or out of a compressed stream.
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
  kGzip,
  kDeflate,
  kBzip2
};  // kGzip: gzip or zlib, the stream says which; kDeflate: bare

// Where the samples of a volume lie.
struct DataPlace {
  std::filesystem::path file;
  std::uint64_t offset = 0;  // bytes of the file before the data, or before its compressed stream
  Compression compression = Compression::kNone;
  std::uint64_t skip = 0;                       // uncompressed bytes before the first sample
  bool nothing_after = false;                   // bytes behind the samples are an error
  bool warns_of_more = false;                   // or a warning: of a file that has samples alone
  std::vector<std::filesystem::path> series{};  // in place of `file`: the same share of the samples in each
};

// Reads forward. Damage in the compressed stream, its checksum included, throws FileError.
class DataStream {
 public:
  // Throws FileError when the file is missing, unreadable, no regular file, or shorter than the offset.
  DataStream(const std::filesystem::path& file, std::uint64_t offset, Compression compression);
  DataStream(const DataStream&) = delete;
  DataStream& operator=(const DataStream&) = delete;
  ~DataStream();

  // Fills `bytes`, or as much of it as there is; how many bytes came.
  std::size_t read(std::span<std::byte> bytes);

  // An upper bound of the bytes that read() can give in all.
  std::uint64_t max_bytes() const;

 private:
  std::size_t read_file(void* bytes, std::size_t count);
  bool refill();
  void end_member();
  void inflate_some(std::span<std::byte> out);
  void decompress_some(std::span<std::byte> out);

  std::filesystem::path file_;
  std::ifstream input_;
  std::uint64_t bytes_;  // of the file, behind the offset
  Compression compression_;
  bool ended_ = false;
  z_stream inflater_{};
  bz_stream decompressor_{};
  std::array<char, 65536> buffer_;
};

// The size of a regular file. Throws FileError when it is missing or not regular.
std::uint64_t file_bytes(const std::filesystem::path& file);

// The first bytes of a file as they are stored, at most so many.
std::string file_start(const std::filesystem::path& file, std::size_t max_bytes);

bool starts_as_gzip(const std::filesystem::path& file);

// A stream that stands at the first sample, once the file's size has shown that so many bytes can be there. Throws
// FileError.
std::unique_ptr<DataStream> open_data(const DataPlace& place, std::size_t bytes);
// To be called behind the last byte: a compressed stream's checksum is checked, and that nothing follows where nothing
// may. Throws FileError. Warns once.
void end_data(DataStream& stream, DataPlace& place, std::size_t bytes);
[[noreturn]] void throw_truncated(const DataPlace& place, std::uint64_t bytes, const std::string& got);

// Exactly `bytes` bytes. Nothing is allocated before the file's size has shown that they can be there, and for
// compressed data not much more than has come. Throws FileError (truncated, damaged, too long).
std::vector<std::byte> read_data(DataPlace place, std::size_t bytes);

}  // namespace gicube::scene
