#include "gicube/wire/ray.h"

#include <rapidcheck/gtest.h>

#include "hex.h"
#include "records.h"
#include "test.h"

namespace gicube::wire {
namespace {

TEST(RayPacket, HasTheBytesThatItsTableSays) {
  Ray ray;
  ray.u = 0x0123;                                 // bytes 0-1    23 01
  ray.v = 0x4567;                                 // bytes 2-3    67 45
  ray.position = {0x0ABCDE, 0x123456, 0xFEDCBA};  // bytes 4-12   DE BC 0A  56 34 12  BA DC FE
  ray.direction = {0x4000, -0x4000, 1};           // bytes 13-18  00 40  00 C0  01 00
  ray.colour = {0xABC, 0xDEF, 0x123};             // from here nibbles, low one first: C B A  F E D  3 2 1
  ray.opacity = 0x89ABCD;                         // D C B A 9 8
  ray.contribution = 0x765;                       // 5 6 7        bytes 19-27  BC FA DE 23 D1 BC 9A 58 76
  ray.lifetime = 0x2A5;                           // byte 28 A5, and 10 in bits 0-1 of byte 29
  ray.generation = 0x9;                           // 1001 in bits 2-5 of byte 29
  ray.interaction = 0x5C3;                        // its lowest 11 in bits 6-7 of byte 29: 11 1001 10 = E6;
                                                  // 0x5C3 >> 2 = 0x170: byte 30 70, and 01 in bits 0-1 of byte 31
  ray.flags = kHostRay | kHighAlbedo;             // 100010 in bits 2-7 of byte 31: 100010 01 = 89
  EXPECT_EQ(hex_of<kRayBytes>(ray),
            "23 01 67 45 DE BC 0A 56 34 12 BA DC FE 00 40 00 C0 01 00 BC FA DE 23 D1 BC 9A 58 76 A5 E6 70 89");
}

TEST(RayPacket, IsTwoHundredAndFiftySixBits) {
  EXPECT_EQ(kRayBytes * 8, 16 + 16 + 3 * 24 + 3 * 16 + 3 * 12 + 24 + 12 + 10 + 4 + 12 + 6);
}

RC_GTEST_PROP(RayPacket, ComesBackAsItWas, ()) {
  const Ray ray = any_ray();
  RC_ASSERT(decode<Ray>(encoded<kRayBytes>(ray)) == ray);
}

RC_GTEST_PROP(RayPacket, EveryBitPatternIsARayThatEncodesToItself, ()) {
  std::array<std::uint8_t, kRayBytes> bytes;
  for (auto& byte : bytes) byte = any_bits<std::uint8_t>(8);
  RC_ASSERT(encoded<kRayBytes>(decode<Ray>(bytes)) == bytes);
}

RC_GTEST_PROP(RayPacket, AHostIdTravelsInUAndV, (std::uint32_t id)) {
  Ray ray;
  ray.set_host_id(id);
  RC_ASSERT(decode<Ray>(encoded<kRayBytes>(ray)).host_id() == id);
}

}  // namespace
}  // namespace gicube::wire
