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

constexpr std::uint64_t kMaxDeflateRatio = 1032;           // zlib's technical notes: no deflate stream does better
constexpr std::size_t kChunkBytes = std::size_t{1} << 20;  // chosen
constexpr int kGzipOrZlib = MAX_WBITS + 32;                // zlib.h: detect the header

}  // namespace

void throw_truncated(const DataPlace& place, std::uint64_t bytes, const std::string& got) {
  throw FileError(place.file, "data", fmt::format("{} bytes", bytes), got + " (truncated, or the header is wrong)");
}

DataStream::DataStream(const std::filesystem::path& file, std::uint64_t offset, bool compressed)
    : file_(file), bytes_(file_bytes(file)), compressed_(compressed) {
  if (offset > bytes_) {
    throw FileError(file, "data", fmt::format("to begin at byte {}", offset),
                    fmt::format("a file of {} bytes (truncated, or the header is wrong)", bytes_));
  }
  bytes_ -= offset;
  input_.open(file, std::ios::binary);
  if (!input_) throw FileError(file, "file", "a readable file", std::strerror(errno));
  input_.seekg(static_cast<std::streamoff>(offset));
  if (compressed && inflateInit2(&inflater_, kGzipOrZlib) != Z_OK) throw std::bad_alloc();
}

DataStream::~DataStream() {
  if (compressed_) inflateEnd(&inflater_);
}

std::size_t DataStream::read_file(void* bytes, std::size_t count) {
  input_.read(static_cast<char*>(bytes), static_cast<std::streamsize>(count));
  if (input_.bad()) throw FileError(file_, "data", "readable bytes", std::strerror(errno));
  return static_cast<std::size_t>(input_.gcount());
}

bool DataStream::refill() {
  inflater_.avail_in = static_cast<uInt>(read_file(buffer_.data(), buffer_.size()));
  inflater_.next_in = reinterpret_cast<Bytef*>(buffer_.data());
  return inflater_.avail_in > 0;
}

// A gzip file may consist of several streams; what else follows one is not ours.
void DataStream::end_member() {
  const bool more = inflater_.avail_in > 0 || refill();
  ended_ = !more || *inflater_.next_in != 0x1f;
  if (!ended_) inflateReset(&inflater_);
}

// One call of inflate().
void DataStream::inflate_some(std::span<std::byte> out) {
  if (inflater_.avail_in == 0 && !refill()) {
    throw FileError(file_, "compressed data", "a whole gzip or zlib stream", "its beginning (truncated)");
  }
  inflater_.next_out = reinterpret_cast<Bytef*>(out.data());
  inflater_.avail_out = static_cast<uInt>(std::min(out.size(), kChunkBytes));
  const int status = inflate(&inflater_, Z_NO_FLUSH);
  if (status == Z_STREAM_END) {
    end_member();
  } else if (status != Z_OK && status != Z_BUF_ERROR) {
    throw FileError(file_, "compressed data", "a gzip or zlib stream",
                    inflater_.msg != nullptr ? inflater_.msg : zError(status));
  }
}

std::size_t DataStream::read(std::span<std::byte> bytes) {
  WhileReading::look();
  if (!compressed_) return read_file(bytes.data(), bytes.size());
  std::size_t done = 0;
  while (done < bytes.size() && !ended_) {
    WhileReading::look();
    inflate_some(bytes.subspan(done));
    done = static_cast<std::size_t>(reinterpret_cast<std::byte*>(inflater_.next_out) - bytes.data());
  }
  return done;
}

std::uint64_t DataStream::max_bytes() const {
  // A file system's sizes are below 2^63, but not 1032 times below.
  if (!compressed_) return bytes_;
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint64_t>::max() / kMaxDeflateRatio;
  return std::min(bytes_, kMax) * kMaxDeflateRatio;
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
  DataStream stream(file, 0, false);
  std::string start(std::min<std::uint64_t>(max_bytes, stream.max_bytes()), '\0');
  start.resize(stream.read(std::as_writable_bytes(std::span(start))));
  return start;
}

bool starts_as_gzip(const std::filesystem::path& file) { return file_start(file, 2) == "\x1f\x8b"; }

std::unique_ptr<DataStream> open_data(const DataPlace& place, std::size_t bytes) {
  auto stream = std::make_unique<DataStream>(place.file, place.offset, place.compressed);
  const std::uint64_t max = stream->max_bytes();
  if (place.skip > max || bytes > max - place.skip) {
    const std::uint64_t left = place.skip > max ? 0 : max - place.skip;
    throw_truncated(place, bytes,
                    fmt::format("{}{}", place.compressed ? "a compressed stream for at most " : "", left));
  }
  std::vector<std::byte> passed;
  for (std::uint64_t skipped = 0; skipped < place.skip; skipped += passed.size()) {
    passed.resize(std::min<std::uint64_t>(kChunkBytes, place.skip - skipped));
    if (stream->read(passed) < passed.size()) throw_truncated(place, place.skip, "less before the first sample");
  }
  return stream;
}

void end_data(DataStream& stream, DataPlace& place, std::size_t bytes) {
  // Reading past the end also makes zlib check the stream's checksum.
  std::byte one;
  if (stream.read({&one, 1}) == 0) return;
  if (place.nothing_after) throw FileError(place.file, "data", fmt::format("{} bytes", bytes), "more");
  if (!std::exchange(place.warns_of_more, false)) return;
  const std::uint64_t all = file_bytes(place.file) - std::min(file_bytes(place.file), place.offset + place.skip);
  warn(place.file, "data", fmt::format("{} bytes by the header", bytes),
       (place.compressed ? "more" : fmt::format("{}", all)) + " (the rest is ignored, or the header is wrong)");
}

std::vector<std::byte> read_data(DataPlace place, std::size_t bytes) {
  const auto stream = open_data(place, bytes);
  std::vector<std::byte> out;
  out.reserve(bytes);  // memory that is not written to costs nothing, should a compressed file end early
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
