#include "frames.h"

#include "gicube/wire/checksum.h"

namespace gicube::fuzz {

std::vector<std::uint8_t> good_frame(wire::FrameHeader header, Bytes payload) {
  header.size = static_cast<std::uint32_t>(payload.size());
  std::vector<std::uint8_t> bytes(wire::kFrameHeaderBytes);
  wire::encode_sealed(header, payload, std::span(bytes).first<wire::kFrameHeaderBytes>());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

std::vector<std::uint8_t> frame_bytes(wire::FrameHeader header, Bytes payload, Input& spoiler, bool& spoilt) {
  const std::uint8_t kind = spoiler.u8();
  if (kind >= 246) spoilt = true;
  switch (kind) {  // before the checksum: the frame is whole, and wrong
    case 255: header.sequence = spoiler.u32(); break;
    case 254: header.flags = spoiler.u16(); break;
    case 253: header.credit_slots = spoiler.u8(); break;
    case 252: header.credit_bytes = spoiler.u64(); break;
    case 251: header.error = static_cast<wire::ErrorCode>(spoiler.below(20)); break;
    case 250: --header.sequence; break;  // it comes again
    default: break;
  }
  std::vector<std::uint8_t> bytes = good_frame(header, payload);
  switch (kind) {  // behind it: it was damaged on its way
    case 249: bytes[spoiler.u8() % bytes.size()] ^= static_cast<std::uint8_t>(1 << spoiler.below(8)); break;
    case 248: bytes.erase(bytes.end() - std::min<std::ptrdiff_t>(spoiler.u8(), std::ssize(bytes)), bytes.end()); break;
    case 247: wire::store(std::span(bytes), 12, spoiler.u32()); break;
    case 246: bytes = spoiler.bytes(spoiler.u8()); break;
    default: break;
  }
  return bytes;
}

wire::VersionInfo version_of(Input& input) {
  wire::VersionInfo info;
  info.capabilities = ~std::uint64_t{0};
  switch (input.u8()) {
    case 255: info.major = input.u16(); break;
    case 254: info.max_payload_bytes = input.u32(); break;
    case 253: info.window_slots = input.u32(); break;
    case 252: info.window_bytes = input.u64(); break;
    case 251: info.capabilities = input.u64(); break;
    case 250: info.flags = input.u32(); break;
    case 249: info.session = input.u64(); break;
    case 248: info.minor = input.u16(); break;
    case 247: info.taken = input.u32(); break;
    case 246: info.consumed = input.u32(); break;
    case 245: info.max_payload_bytes = wire::kMaxHandshakePayload; break;
    case 244: info.window_slots = 1 + input.below(4); break;
    default: break;
  }
  return info;
}

std::vector<std::uint8_t> version_payload(Input& input) {
  const wire::VersionInfo info = version_of(input);
  std::vector<std::uint8_t> payload(wire::kVersionBytes);
  wire::encode(info, payload);
  return payload;
}

bool FrameReader::take(Frame& frame) {
  if (bytes_.size() < wire::kFrameHeaderBytes) return false;
  const auto head = std::span<const std::uint8_t>(bytes_).first<wire::kFrameHeaderBytes>();
  const auto header = wire::decode_frame_header(head);
  expect(header.has_value(), "only frames come out");
  expect(header->size <= (64u << 20), "a frame has an agreed size");
  if (bytes_.size() < wire::kFrameHeaderBytes + header->size) return false;
  frame.header = *header;
  const auto payload = std::span<const std::uint8_t>(bytes_).subspan(wire::kFrameHeaderBytes, header->size);
  frame.payload.assign(payload.begin(), payload.end());
  expect(wire::frame_checksum(head, payload) == header->checksum, "a frame has its checksum");
  if (!wire::is_free(header->type)) {
    expect(header->sequence == taken_ + 1 || any_number_, "frames come in their order, none is missing");
    taken_ = header->sequence;
  }
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(wire::kFrameHeaderBytes + header->size));
  return true;
}

}  // namespace gicube::fuzz
