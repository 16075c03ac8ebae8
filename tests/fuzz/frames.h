// Frames on a socket as a fuzzer sends them: sealed and numbered as they must be, unless the input says otherwise.
#pragma once

#include "gicube/wire/frame.h"
#include "input.h"

namespace gicube::fuzz {

// The bytes of a frame with its number, checksum and size. Some inputs spoil it, `spoilt` says whether: the peer may
// then wait for the rest of it, or take it for one that it has.
std::vector<std::uint8_t> frame_bytes(wire::FrameHeader header, Bytes payload, Input& spoiler, bool& spoilt);
std::vector<std::uint8_t> good_frame(wire::FrameHeader header, Bytes payload);

// A version that mostly can be agreed on.
wire::VersionInfo version_of(Input& input);
std::vector<std::uint8_t> version_payload(Input& input);

// Takes a stream of frames apart as it comes, and holds every one to its checksum and number.
class FrameReader {
 public:
  struct Frame {
    wire::FrameHeader header;
    std::vector<std::uint8_t> payload;
  };

  void add(Bytes bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  // The next whole frame, if it has come. Throws Finding.
  bool take(Frame& frame);
  // The connection broke: the rest of a frame will not come.
  void lose_rest() { bytes_.clear(); }
  std::uint32_t taken() const { return taken_; }
  void expect_any_number() { any_number_ = true; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::uint32_t taken_ = 0;
  bool any_number_ = false;
};

}  // namespace gicube::fuzz
