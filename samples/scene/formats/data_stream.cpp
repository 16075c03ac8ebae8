#include "scene/formats/data_stream.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <system_error>

#include <fmt/format.h>
#include <zlib.h>

namespace gicube::samples {
namespace {

constexpr std::uint64_t kMaxDeflateRatio = 1032;           // zlib's technical notes: no deflate stream does better
constexpr std::size_t kChunkBytes = std::size_t{1} << 20;  // chosen: the first allocation for compressed data
constexpr int kGzipOrZlib = MAX_WBITS + 32;                // zlib.h: detect the header

[[noreturn]] void throw_truncated(const DataPlace& place, std::uint64_t wanted, const std::string& got) {
  throw FileError(place.file, "data", fmt::format("{} bytes", wanted), got + " (truncated, or the header is wrong)");
}

void check_nothing_after(const DataPlace& place, DataStream& stream, std::size_t bytes) {
  std::array<std::byte, 1> one;
  // Reading past the end also makes zlib check the stream's checksum.
  const bool more = stream.read(one) != 0;
  if (more && place.nothing_after) throw FileError(place.file, "data", fmt::format("{} bytes", bytes), "more");
}

}  // namespace

struct DataStream::State {
  std::filesystem::path file;
  std::ifstream input;
  std::uint64_t bytes = 0;  // of the file, behind the offset
  bool compressed = false;
  bool ended = false;
  z_stream inflater{};
  std::array<char, 65536> buffer;

  std::size_t read_plain(std::span<std::byte> out) {
    input.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
    if (input.bad()) throw FileError(file, "data", "readable bytes", std::strerror(errno));
    return static_cast<std::size_t>(input.gcount());
  }

  bool refill() {
    input.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    if (input.bad()) throw FileError(file, "data", "readable bytes", std::strerror(errno));
    inflater.next_in = reinterpret_cast<Bytef*>(buffer.data());
    inflater.avail_in = static_cast<uInt>(input.gcount());
    return inflater.avail_in > 0;
  }

  // A gzip file may consist of several streams; what else follows one is not ours.
  void end_member() {
    const bool more = inflater.avail_in > 0 || refill();
    ended = !more || *inflater.next_in != 0x1f;
    if (!ended) inflateReset(&inflater);
  }

  // One call of inflate() with at most 2^32 - 1 bytes of output.
  void inflate_some(std::span<std::byte> out) {
    if (inflater.avail_in == 0 && !refill()) {
      throw FileError(file, "compressed data", "a whole gzip or zlib stream", "its beginning (truncated)");
    }
    inflater.next_out = reinterpret_cast<Bytef*>(out.data());
    inflater.avail_out = static_cast<uInt>(std::min<std::size_t>(out.size(), std::numeric_limits<uInt>::max()));
    const int status = inflate(&inflater, Z_NO_FLUSH);
    if (status == Z_STREAM_END) {
      end_member();
    } else if (status != Z_OK && status != Z_BUF_ERROR) {
      throw FileError(file, "compressed data", "a gzip or zlib stream",
                      inflater.msg != nullptr ? inflater.msg : zError(status));
    }
  }

  std::size_t read_compressed(std::span<std::byte> out) {
    std::size_t done = 0;
    while (done < out.size() && !ended) {
      const auto rest = out.subspan(done);
      inflate_some(rest);
      done = static_cast<std::size_t>(reinterpret_cast<std::byte*>(inflater.next_out) - out.data());
    }
    return done;
  }

  ~State() {
    if (compressed) inflateEnd(&inflater);
  }
};

DataStream::DataStream(const std::filesystem::path& file, std::uint64_t offset, bool compressed)
    : state_(std::make_unique<State>()) {
  const std::uint64_t all = file_bytes(file);
  if (offset > all) {
    throw FileError(file, "data", fmt::format("to begin at byte {}", offset),
                    fmt::format("a file of {} bytes (truncated, or the header is wrong)", all));
  }
  state_->file = file;
  state_->bytes = all - offset;
  state_->input.open(file, std::ios::binary);
  if (!state_->input) throw FileError(file, "file", "a readable file", std::strerror(errno));
  state_->input.seekg(static_cast<std::streamoff>(offset));
  if (compressed && inflateInit2(&state_->inflater, kGzipOrZlib) != Z_OK) throw std::bad_alloc();
  state_->compressed = compressed;
}

DataStream::DataStream(DataStream&&) noexcept = default;
DataStream::~DataStream() = default;

std::size_t DataStream::read(std::span<std::byte> bytes) {
  return state_->compressed ? state_->read_compressed(bytes) : state_->read_plain(bytes);
}

std::uint64_t DataStream::max_bytes() const {
  // A file system's sizes are below 2^63, but not 1032 times below.
  if (!state_->compressed) return state_->bytes;
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint64_t>::max() / kMaxDeflateRatio;
  return std::min(state_->bytes, kMax) * kMaxDeflateRatio;
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

std::vector<std::byte> read_data(const DataPlace& place, std::size_t bytes) {
  DataStream stream(place.file, place.offset, place.compressed);
  const std::uint64_t max = stream.max_bytes();
  if (place.skip > max || bytes > max - place.skip) {
    const std::uint64_t left = place.skip > max ? 0 : max - place.skip;
    throw_truncated(place, bytes,
                    fmt::format("{}{}", place.compressed ? "a compressed stream for at most " : "", left));
  }
  std::vector<std::byte> out;
  for (std::uint64_t skipped = 0; skipped < place.skip; skipped += out.size()) {
    out.resize(std::min<std::uint64_t>(kChunkBytes, place.skip - skipped));
    if (stream.read(out) < out.size()) throw_truncated(place, place.skip, "less before the first sample");
  }
  out.clear();
  while (out.size() < bytes) {
    const std::size_t had = out.size();
    const std::size_t grown = std::max(2 * had, kChunkBytes);
    out.resize(place.compressed ? std::min(bytes, grown) : bytes);
    const std::size_t came = stream.read(std::span(out).subspan(had));
    if (had + came < out.size()) throw_truncated(place, bytes, fmt::format("{}", had + came));
  }
  check_nothing_after(place, stream, bytes);
  return out;
}

}  // namespace gicube::samples
