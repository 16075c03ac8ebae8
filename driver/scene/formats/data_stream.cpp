#include "scene/formats/data_stream.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "scene/common/checks.h"
#include "scene/common/while_reading.h"

namespace gicube::scene {
namespace {

constexpr std::uint64_t kMaxDeflateRatio = 1032;   // zlib's technical notes: no deflate stream does better
constexpr std::uint64_t kMaxBzip2Ratio = 1 << 20;  // 45 bytes can hold 45,899,235 (bzip2's manual, memory management)
constexpr std::size_t kChunkBytes = std::size_t{1} << 20;  // chosen
constexpr int kGzipOrZlib = MAX_WBITS + 32;                // zlib.h: detect the header

}  // namespace

void throw_truncated(const DataPlace& place, std::uint64_t bytes, const std::string& got) {
  throw FileError(place.file, "data", fmt::format("{} bytes", bytes), got + " (truncated, or the header is wrong)");
}

DataStream::DataStream(const std::filesystem::path& file, std::uint64_t offset, Compression compression)
    : file_(file), bytes_(file_bytes(file)), compression_(compression) {
  if (offset > bytes_) {
    throw FileError(file, "data", fmt::format("to begin at byte {}", offset),
                    fmt::format("a file of {} bytes (truncated, or the header is wrong)", bytes_));
  }
  bytes_ -= offset;
  input_.open(file, std::ios::binary);
  if (!input_) throw FileError(file, "file", "a readable file", std::strerror(errno));
  input_.seekg(static_cast<std::streamoff>(offset));
  const int window = compression == Compression::kDeflate ? -MAX_WBITS : kGzipOrZlib;
  if (compression == Compression::kBzip2) {
    start_bzip2();
  } else if (compression != Compression::kNone && inflateInit2(&inflater_, window) != Z_OK) {
    throw std::bad_alloc();
  }
}

DataStream::~DataStream() {
  if (compression_ == Compression::kBzip2) {
    BZ2_bzDecompressEnd(&decompressor_);
  } else if (compression_ != Compression::kNone) {
    inflateEnd(&inflater_);
  }
}

std::size_t DataStream::read_file(void* bytes, std::size_t count) {
  input_.read(static_cast<char*>(bytes), static_cast<std::streamsize>(count));
  if (input_.bad()) throw FileError(file_, "data", "readable bytes", std::strerror(errno));
  return static_cast<std::size_t>(input_.gcount());
}

bool DataStream::refill() {
  input_left_ = std::span(buffer_).first(read_file(buffer_.data(), buffer_.size()));
  return !input_left_.empty();
}

void DataStream::start_bzip2() {
  if (BZ2_bzDecompressInit(&decompressor_, 0, 0) != BZ_OK) throw std::bad_alloc();
}

// A compressed file may consist of several streams: those of gzip may be appended to each other, and compressors that
// work in several threads write several of bzip2. Other bytes behind a stream are ignored.
void DataStream::end_member() {
  const bool more = !input_left_.empty() || refill();
  const bool bzip2 = compression_ == Compression::kBzip2;
  ended_ = !more || compression_ == Compression::kDeflate || input_left_.front() != (bzip2 ? 'B' : '\x1f');
  if (ended_) return;
  if (!bzip2) {
    inflateReset(&inflater_);
    return;
  }
  BZ2_bzDecompressEnd(&decompressor_);
  start_bzip2();
}

// One call of inflate(). Returns the number of bytes.
std::size_t DataStream::inflate_some(std::span<std::byte> out) {
  inflater_.next_in = reinterpret_cast<Bytef*>(input_left_.data());
  inflater_.avail_in = static_cast<uInt>(input_left_.size());
  inflater_.next_out = reinterpret_cast<Bytef*>(out.data());
  inflater_.avail_out = static_cast<uInt>(out.size());
  const int status = inflate(&inflater_, Z_NO_FLUSH);
  if (status != Z_STREAM_END && status != Z_OK && status != Z_BUF_ERROR) {
    throw FileError(file_, "compressed data", "a gzip or zlib stream",
                    inflater_.msg != nullptr ? inflater_.msg : zError(status));
  }
  input_left_ = input_left_.last(inflater_.avail_in);
  if (status == Z_STREAM_END) end_member();
  return static_cast<std::size_t>(reinterpret_cast<std::byte*>(inflater_.next_out) - out.data());
}

// One call of BZ2_bzDecompress(). Returns the number of bytes.
std::size_t DataStream::decompress_some(std::span<std::byte> out) {
  decompressor_.next_in = input_left_.data();
  decompressor_.avail_in = static_cast<unsigned>(input_left_.size());
  decompressor_.next_out = reinterpret_cast<char*>(out.data());
  decompressor_.avail_out = static_cast<unsigned>(out.size());
  const int status = BZ2_bzDecompress(&decompressor_);
  if (status != BZ_STREAM_END && status != BZ_OK)
    throw FileError(file_, "compressed data", "a bzip2 stream", fmt::format("damage (bzip2's error {})", status));
  const auto made = static_cast<std::size_t>(reinterpret_cast<std::byte*>(decompressor_.next_out) - out.data());
  input_left_ = input_left_.last(decompressor_.avail_in);
  if (status == BZ_STREAM_END) end_member();
  return made;
}

std::size_t DataStream::read(std::span<std::byte> bytes) {
  WhileReading::look();
  if (compression_ == Compression::kNone) return read_file(bytes.data(), bytes.size());
  const bool bzip2 = compression_ == Compression::kBzip2;
  std::size_t done = 0;
  while (done < bytes.size() && !ended_) {
    WhileReading::look();
    if (input_left_.empty() && !refill()) {
      throw FileError(file_, "compressed data", bzip2 ? "a whole bzip2 stream" : "a whole gzip or zlib stream",
                      "its beginning (truncated)");
    }
    const auto out = bytes.subspan(done, std::min(bytes.size() - done, kChunkBytes));
    done += bzip2 ? decompress_some(out) : inflate_some(out);
  }
  return done;
}

std::uint64_t DataStream::max_bytes() const {
  // A file's size is below 2^63; times the ratio it may exceed 64 bits.
  if (compression_ == Compression::kNone) return bytes_;
  const std::uint64_t ratio = compression_ == Compression::kBzip2 ? kMaxBzip2Ratio : kMaxDeflateRatio;
  return std::min(bytes_, std::numeric_limits<std::uint64_t>::max() / ratio) * ratio;
}

std::uint64_t file_bytes(const std::filesystem::path& file) {
  std::error_code fault;
  const auto status = std::filesystem::status(file, fault);
  if (status.type() == std::filesystem::file_type::not_found) throw FileError(file, "file", "a file", "nothing there");
  if (fault) throw FileError(file, "file", "a readable file", fault.message());
  if (status.type() != std::filesystem::file_type::regular) {
    throw FileError(file, "file", "a regular file", "something else (folder, pipe or device)");
  }
  const std::uint64_t bytes = std::filesystem::file_size(file, fault);
  if (fault) throw FileError(file, "file", "a readable file", fault.message());
  return bytes;
}

std::string file_start(const std::filesystem::path& file, std::size_t max_bytes) {
  DataStream stream(file, 0, Compression::kNone);
  std::string start(std::min<std::uint64_t>(max_bytes, stream.max_bytes()), '\0');
  start.resize(stream.read(std::as_writable_bytes(std::span(start))));
  return start;
}

bool starts_as_gzip(const std::filesystem::path& file) { return file_start(file, 2) == "\x1f\x8b"; }

std::unique_ptr<DataStream> open_data(const DataPlace& place, std::size_t bytes) {
  auto stream = std::make_unique<DataStream>(place.file, place.offset, place.compression);
  const std::uint64_t max = stream->max_bytes();
  if (place.skip > max || bytes > max - place.skip) {
    const std::uint64_t left = place.skip > max ? 0 : max - place.skip;
    throw_truncated(
        place, bytes,
        fmt::format("{}{}", place.compression != Compression::kNone ? "a compressed stream for at most " : "", left));
  }
  std::vector<std::byte> passed;
  for (std::uint64_t skipped = 0; skipped < place.skip; skipped += passed.size()) {
    passed.resize(std::min<std::uint64_t>(kChunkBytes, place.skip - skipped));
    if (stream->read(passed) < passed.size()) throw_truncated(place, place.skip, "less before the first sample");
  }
  return stream;
}

void end_data(DataStream& stream, DataPlace& place, std::size_t bytes) {
  // Reading past the end makes zlib check the stream's checksum.
  std::byte one;
  if (stream.read({&one, 1}) == 0) return;
  if (place.nothing_after) throw FileError(place.file, "data", fmt::format("{} bytes", bytes), "more");
  if (!std::exchange(place.warns_of_more, false)) return;
  const std::uint64_t all = file_bytes(place.file) - std::min(file_bytes(place.file), place.offset + place.skip);
  warn(place.file, "data", fmt::format("{} bytes by the header", bytes),
       (place.compression != Compression::kNone ? "more" : fmt::format("{}", all)) +
           " (the rest is ignored, or the header is wrong)");
}

std::vector<std::byte> read_data(DataPlace place, std::size_t bytes) {
  if (!place.series.empty()) {
    const std::vector<std::filesystem::path> files = std::exchange(place.series, {});
    std::vector<std::byte> all;
    for (const auto& file : files) {
      place.file = file;
      const std::vector<std::byte> part = read_data(place, bytes / files.size());
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  }
  const auto stream = open_data(place, bytes);
  std::vector<std::byte> out;
  out.reserve(bytes);  // unwritten memory costs nothing if a compressed file ends early
  while (out.size() < bytes) {
    const std::size_t had = out.size();
    out.resize(std::min(bytes, had + kChunkBytes));
    const std::size_t came = stream->read(std::span(out).subspan(had));
    if (had + came < out.size()) throw_truncated(place, bytes, fmt::format("{}", had + came));
  }
  end_data(*stream, place, bytes);
  return out;
}

}  // namespace gicube::scene
