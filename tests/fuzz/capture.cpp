// Captured sessions: a file becomes frames, up to a damage that is named.
#include "gicube/wire/capture.h"
#include "capture_reader.h"
#include "frames.h"
#include "memory_file.h"

namespace gicube::fuzz {
namespace {

// A capture whose frames have good checksums, mostly.
std::vector<std::uint8_t> assembled(Input& input) {
  std::vector<std::uint8_t> file = wire::encoded(wire::CaptureHeader{});
  std::uint32_t sequences[2] = {0, 0};
  while (!input.empty()) {
    const std::uint32_t kind = input.below(16) == 15 ? 2 + input.below(2) : input.below(2);
    wire::append(file, wire::CaptureRecord{static_cast<wire::CaptureKind>(kind), input.u16()});
    if (kind >= 2) continue;
    wire::FrameHeader header;
    header.type = static_cast<wire::FrameType>(1 + input.below(16));
    header.flags = input.u8() % 4;
    header.id = input.u8();
    header.sequence = wire::is_free(header.type) ? 0 : ++sequences[kind];
    const std::vector<std::uint8_t> payload = input.bytes(input.below(64));
    bool spoilt = false;
    const std::vector<std::uint8_t> frame = frame_bytes(header, payload, input, spoilt);
    file.insert(file.end(), frame.begin(), frame.end());
  }
  return file;
}

}  // namespace

void capture(Bytes bytes) {
  Input input(bytes);
  const bool raw = input.u8() % 4 == 0;
  const std::vector<std::uint8_t> contents = raw ? input.bytes(bytes.size()) : assembled(input);
  const MemoryFile file(contents);
  try {
    const replay::Recorded recorded = replay::read_recorded(file.path());
    replay::CaptureReader frames(file.path());
    replay::CapturedFrame frame;
    std::uint32_t last = 0;
    while (frames.next(wire::CaptureKind::kDown, frame)) {
      expect(frame.payload.size() == frame.header.size, "a frame has its payload");
      expect(wire::sequence_step(last, frame.header.sequence) > 0, "no frame comes twice");
      last = frame.header.sequence;
    }
    expect(recorded.largest_payload <= contents.size() || raw, "no payload is longer than the file");
  } catch (const replay::CaptureError&) {
  }
}

}  // namespace gicube::fuzz
