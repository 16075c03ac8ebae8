#include "gicube/wire/frame.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hex.h"
#include "records.h"

namespace gicube::wire {
namespace {

TEST(FrameHeader, HasTheBytesThatItsTableSays) {
  FrameHeader header;
  header.type = FrameType::kMemoryWrite;  // 7
  header.flags = kPosted;                 // 2
  header.id = 0x01020304;
  header.size = 8 + 4096;  // 0x1008
  header.credit_slots = 5;
  header.time_ps = 1'000'000;   // one microsecond, 0xF4240
  header.credit_bytes = 8'192;  // 0x2000
  EXPECT_EQ(hex_of<kFrameHeaderBytes>(header),
            "47 49 43 55 07 00 02 00 04 03 02 01 08 10 00 00 "   // G I C U, type, flags, id, size
            "00 00 00 00 05 00 00 00 "                           // error, credit_slots
            "40 42 0F 00 00 00 00 00 00 20 00 00 00 00 00 00");  // time_ps, credit_bytes
}

RC_GTEST_PROP(FrameHeader, ComesBackAsItWas, ()) {
  const FrameHeader header = any_header();
  RC_ASSERT(decode_frame_header(encoded<kFrameHeaderBytes>(header)) == header);
}

RC_GTEST_PROP(FrameHeader, IsRefusedUnlessMagicAndTypeAreRight, ()) {
  std::array<std::uint8_t, kFrameHeaderBytes> bytes;
  for (auto& byte : bytes) byte = any_bits<std::uint8_t>(8);
  if (*rc::gen::arbitrary<bool>()) store(std::span(bytes), 0, kFrameMagic);
  if (*rc::gen::arbitrary<bool>()) store(std::span(bytes), 4, *rc::gen::inRange<std::uint16_t>(0, 20));
  const auto magic = load<std::uint32_t>(bytes, 0);
  const auto type = load<std::uint16_t>(bytes, 4);
  RC_ASSERT(decode_frame_header(bytes).has_value() == (magic == 0x55434947 && type >= 1 && type <= 14));
}

TEST(FrameNumbers, AreTheOnesThatRecordedTrafficHolds) {
  EXPECT_EQ(static_cast<int>(FrameType::kVersion), 1);
  EXPECT_EQ(static_cast<int>(FrameType::kCommand), 9);
  EXPECT_EQ(static_cast<int>(FrameType::kProgress), 14);
  EXPECT_EQ(static_cast<int>(ErrorCode::kProtocol), 1);
  EXPECT_EQ(static_cast<int>(ErrorCode::kBadAddress), 5);
  EXPECT_EQ(static_cast<int>(ErrorCode::kInternal), 9);
}

TEST(Version, HasTheBytesThatItsTableSays) {
  VersionInfo info{.major = 1, .minor = 2, .max_payload_bytes = 4u << 20, .window_slots = 64};
  info.window_bytes = 16u << 20;
  info.capabilities = kFunctionalLevel | kProgressFrames | kHostRays;  // 1 + 8 + 16 = 0x19
  EXPECT_EQ(hex_of<kVersionBytes>(info),
            "01 00 02 00 00 00 40 00 40 00 00 00 00 00 00 00 "   // versions, 0x400000, 0x40, reserved
            "00 00 00 01 00 00 00 00 19 00 00 00 00 00 00 00");  // 0x1000000, capabilities
}

RC_GTEST_PROP(Version, ComesBackAsItWas, ()) {
  const VersionInfo info = any_version();
  RC_ASSERT(decode_version(encoded<kVersionBytes>(info)) == info);
}

TEST(Agreement, TakesTheSmallerMinorAndPayloadAndTheCommonCapabilities) {
  VersionInfo mine, theirs;
  mine.minor = 3;
  mine.max_payload_bytes = 1u << 20;
  mine.capabilities = kFunctionalLevel | kHostRays;
  theirs.minor = 1;
  theirs.max_payload_bytes = 2u << 20;
  theirs.capabilities = kFunctionalLevel | kCycleLevel;
  for (const auto& agreed : {agree(mine, theirs), agree(theirs, mine)}) {
    ASSERT_TRUE(agreed.has_value());
    EXPECT_EQ(agreed->minor, 1);
    EXPECT_EQ(agreed->max_payload_bytes, 1u << 20);
    EXPECT_EQ(agreed->capabilities, kFunctionalLevel);
  }
}

TEST(Agreement, NeedsTheSameMajor) {
  VersionInfo theirs;
  theirs.major = kMajorVersion + 1;
  EXPECT_EQ(agree(VersionInfo{}, theirs), std::nullopt);
}

TEST(Agreement, NeedsAPeerThatCanTakeFrames) {
  const VersionInfo mine;
  VersionInfo theirs;
  theirs.max_payload_bytes = kMaxHandshakePayload;
  theirs.window_slots = 1;
  theirs.window_bytes = 2 * kMaxHandshakePayload;
  EXPECT_TRUE(agree(mine, theirs).has_value()) << "the least that a peer may offer";

  VersionInfo small = theirs;
  small.max_payload_bytes = kMaxHandshakePayload - 1;
  EXPECT_EQ(agree(mine, small), std::nullopt);
  VersionInfo deaf = theirs;
  deaf.window_slots = 0;
  EXPECT_EQ(agree(mine, deaf), std::nullopt);
  VersionInfo narrow = theirs;
  narrow.window_bytes = 2 * kMaxHandshakePayload - 1;
  EXPECT_EQ(agree(mine, narrow), std::nullopt) << "a largest frame could wait for credit that is never due";
}

}  // namespace
}  // namespace gicube::wire
