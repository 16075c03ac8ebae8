#include "gicube/wire/checksum.h"

#include <isa-l/crc.h>

#include <algorithm>
#include <array>

namespace gicube::wire {
namespace {

constexpr std::size_t kChecksumAt = 44;
constexpr std::size_t kMaxAtOnce = std::size_t{1} << 30;  // the library's lengths are int

// ISA-L 2.30 leaves values in the upper halves of vector registers. Until these are cleared, every SSE instruction of
// the thread must merge with them: gradient computation, for example, takes 1.8 times as long.
#if defined(__x86_64__)
[[gnu::target("avx")]] void clear_upper_halves() { __builtin_ia32_vzeroupper(); }
const bool kHasUpperHalves = __builtin_cpu_supports("avx") != 0;
#else
void clear_upper_halves() {}
constexpr bool kHasUpperHalves = false;
#endif

}  // namespace

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  std::uint32_t crc = ~before;
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(bytes.size(), kMaxAtOnce));
    // The library does not write to the data, although its parameter is not const.
    crc = crc32_iscsi(const_cast<unsigned char*>(part.data()), static_cast<int>(part.size()), crc);
    bytes = bytes.subspan(part.size());
  }
  if (kHasUpperHalves) clear_upper_halves();
  return ~crc;
}

std::uint32_t frame_checksum(std::span<const std::uint8_t, kFrameHeaderBytes> header,
                             std::span<const std::uint8_t> payload) {
  static_assert(kChecksumAt + 4 == kFrameHeaderBytes);
  constexpr std::array<std::uint8_t, 4> kNothing{};
  return crc32c(payload, crc32c(kNothing, crc32c(header.first<kChecksumAt>())));
}

void encode_sealed(const FrameHeader& header, std::span<const std::uint8_t> payload,
                   std::span<std::uint8_t, kFrameHeaderBytes> out) {
  encode(header, out);
  store(out, kChecksumAt, frame_checksum(out, payload));
}

}  // namespace gicube::wire
