#include "gicube/wire/bytes.h"

#include <rapidcheck/gtest.h>

#include "hex.h"
#include "records.h"
#include "test.h"

namespace gicube::wire {
namespace {

TEST(Bytes, AreStoredLeastSignificantFirst) {
  std::array<std::uint8_t, 6> bytes{};
  store(std::span(bytes), 1, std::uint32_t{0x11223344});
  EXPECT_EQ(to_hex(bytes), "00 44 33 22 11 00");
}

TEST(Bytes, HoldADoubleAsItsIeeeBits) {
  std::array<std::uint8_t, 8> bytes{};
  store(std::span(bytes), 0, -2.0);  // sign 1, exponent 1024 = 0x400, fraction 0
  EXPECT_EQ(to_hex(bytes), "00 00 00 00 00 00 00 C0");
  store(std::span(bytes), 0, std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(std::isnan(load<double>(bytes, 0)));
}

TEST(Bytes, ABitFieldMayCrossAWordBoundary) {
  BitRecord<2> bits;
  bits.put(60, 12, 0xABC);
  EXPECT_EQ(bits.words[0], 0xC000'0000'0000'0000u);
  EXPECT_EQ(bits.words[1], 0xABu);
  EXPECT_EQ(bits.get(60, 12), 0xABCu);
}

RC_GTEST_PROP(Bytes, FieldsSideBySideKeepTheirValues, ()) {
  const auto width = *rc::gen::inRange(1u, 33u);
  const auto offset = *rc::gen::inRange(0u, 128u - 2 * width + 1);
  const auto low = any_bits<std::uint32_t>(width), high = any_bits<std::uint32_t>(width);
  BitRecord<2> bits;
  bits.put(offset, width, low);
  bits.put(offset + width, width, high);
  RC_ASSERT(bits.get(offset, width) == low);
  RC_ASSERT(bits.get(offset + width, width) == high);
}

TEST(Bytes, SignExtensionKeepsBothEndsOfTheRange) {
  EXPECT_EQ(sign_extend(0x1FF, 10), 511);
  EXPECT_EQ(sign_extend(0x200, 10), -512);
  EXPECT_EQ(sign_extend(0x3FF, 10), -1);
  EXPECT_EQ(sign_extend(0, 10), 0);
}

}  // namespace
}  // namespace gicube::wire
