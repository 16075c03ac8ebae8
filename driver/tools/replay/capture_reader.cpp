#include "capture_reader.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>

#include "gicube/wire/checksum.h"

namespace gicube::replay {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;           // bytes per read
constexpr std::uint32_t kMaxPayload = std::uint32_t{1} << 28;  // chosen: far above the limits that peers agree on

}  // namespace

void CaptureReader::Close::operator()(gzFile_s* file) const { ::gzclose(file); }

CaptureReader::CaptureReader(const std::filesystem::path& file) : name_(file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw CaptureError(file.string() + ": no such file");
  file_.reset(::gzopen(file.c_str(), "rb"));
  if (!file_) throw CaptureError(file.string() + ": cannot be read");
  std::array<std::uint8_t, wire::kCaptureHeaderBytes> header{};
  const bool is_whole = read(header.data(), header.size()) == header.size();
  const auto [magic, version] = wire::decode<wire::CaptureHeader>(header);
  if (!is_whole || magic != wire::kCaptureMagic) {
    throw CaptureError(file.string() + ": expected a capture, got something else");
  }
  if (version != wire::kCaptureVersion) {
    fail(fmt::format("expected a capture of version {}, got {}", wire::kCaptureVersion, version));
  }
}

void CaptureReader::fail(const std::string& what) const {
  throw CaptureError(fmt::format("{}: byte {}: {}", name_.string(), at_, what));
}

std::size_t CaptureReader::read(std::uint8_t* bytes, std::size_t count) {
  const int got = ::gzread(file_.get(), bytes, static_cast<unsigned>(count));
  int error = Z_OK;
  const char* text = ::gzerror(file_.get(), &error);
  if (got < 0 || (error != Z_OK && error != Z_BUF_ERROR)) fail(fmt::format("damaged: {}", text));
  at_ += static_cast<std::uint64_t>(got);
  return static_cast<std::size_t>(got);
}

bool CaptureReader::next(wire::CaptureKind direction, CapturedFrame& frame) {
  while (next_of_all(frame)) {
    if (frame.record.kind != direction || wire::is_free(frame.header.type)) continue;
    std::uint32_t& taken = taken_[static_cast<std::size_t>(direction)];
    // Frames before it are duplicates; those after a lost one are refused and sent again.
    if (wire::sequence_step(taken, frame.header.sequence) != 1) continue;
    taken = frame.header.sequence;
    return true;
  }
  return false;
}

bool CaptureReader::next_of_all(CapturedFrame& frame) {
  std::array<std::uint8_t, wire::kCaptureRecordBytes> record{};
  const std::size_t got = complete_ ? 0 : read(record.data(), record.size());
  if (got < record.size()) return false;
  frame.record = wire::decode<wire::CaptureRecord>(record);
  if (frame.record.kind > wire::CaptureKind::kEnd) fail("expected a record, got something else");
  if (frame.record.kind == wire::CaptureKind::kEnd) {
    complete_ = true;
    return false;
  }
  std::array<std::uint8_t, wire::kFrameHeaderBytes> header{};
  if (read(header.data(), header.size()) < header.size()) return false;
  const auto frame_header = wire::decode_frame_header(header);
  if (!frame_header || frame_header->size > kMaxPayload) fail("expected a frame's header, got something else");
  frame.header = *frame_header;
  frame.payload.clear();
  while (frame.payload.size() < frame_header->size) {
    const std::size_t begin = frame.payload.size();
    const std::size_t wanted = std::min<std::size_t>(kPiece, frame_header->size - begin);
    frame.payload.resize(begin + wanted);
    const std::size_t came = read(frame.payload.data() + begin, wanted);
    if (came < wanted) return false;
  }
  if (wire::frame_checksum(header, frame.payload) != frame_header->checksum) fail("a frame with a wrong checksum");
  largest_payload_ = std::max(largest_payload_, frame_header->size);
  if (frame_header->type == wire::FrameType::kVersion && frame.payload.size() >= wire::kVersionBytes) {
    minor_version_ = std::min(minor_version_, wire::decode<wire::VersionInfo>(frame.payload).minor);
  }
  return true;
}

Answer answer_of(const wire::FrameHeader& header, const std::vector<std::uint8_t>& payload) {
  Answer answer{header.type, header.error, header.time_ps, payload.size(), wire::crc32c(payload), {}};
  const std::size_t kept = std::min(payload.size(), Answer::kKept);
  answer.payload.assign(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(kept));
  return answer;
}

Recorded read_recorded(const std::filesystem::path& file) {
  Recorded recorded;
  CaptureReader reader(file);
  CapturedFrame frame;
  while (reader.next(wire::CaptureKind::kUp, frame)) {
    recorded.answers(frame.header.type).insert_or_assign(frame.header.id, answer_of(frame.header, frame.payload));
  }
  recorded.largest_payload = reader.largest_payload();
  recorded.minor_version = reader.minor_version();
  return recorded;
}

}  // namespace gicube::replay
