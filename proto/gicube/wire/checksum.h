// The checksum of frames: CRC-32C (Castagnoli, reflected, as in iSCSI and SCTP). Not header-only: target
// gicube_checksum.
#pragma once

#include <cstdint>
#include <span>

#include "gicube/wire/frame.h"

namespace gicube::wire {

// Checksum of `bytes`. `before` is the checksum of the preceding data; 0 if there is none.
std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

// Returns the correct checksum for this header and payload. The header's current checksum field is ignored.
std::uint32_t frame_checksum(std::span<const std::uint8_t, kFrameHeaderBytes> header,
                             std::span<const std::uint8_t> payload);

// encode() with the checksum of header and payload. `header.checksum` is ignored.
void encode_sealed(const FrameHeader& header, std::span<const std::uint8_t> payload,
                   std::span<std::uint8_t, kFrameHeaderBytes> out);

}  // namespace gicube::wire
