#include "gicube/wire/frame.h"

#include <rapidcheck/gtest.h>

#include "gicube/wire/checksum.h"
#include "hex.h"
#include "records.h"
#include "test.h"

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
  header.sequence = 0x11223344;
  header.checksum = 0xAABBCCDD;
  EXPECT_EQ(hex_of<kFrameHeaderBytes>(header),
            "47 49 43 55 07 00 02 00 04 03 02 01 08 10 00 00 "  // G I C U, type, flags, id, size
            "00 00 00 00 05 00 00 00 "                          // error, credit_slots
            "40 42 0F 00 00 00 00 00 00 20 00 00 00 00 00 00 "  // time_ps, credit_bytes
            "44 33 22 11 DD CC BB AA");                         // sequence, checksum
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
  RC_ASSERT(decode_frame_header(bytes).has_value() == (magic == 0x55434947 && type >= 1 && type <= 16));
}

TEST(FrameNumbers, AreTheOnesThatRecordedTrafficHolds) {
  EXPECT_EQ(static_cast<int>(FrameType::kVersion), 1);
  EXPECT_EQ(static_cast<int>(FrameType::kCommand), 9);
  EXPECT_EQ(static_cast<int>(FrameType::kProgress), 14);
  EXPECT_EQ(static_cast<int>(FrameType::kCheckpoint), 16);
  EXPECT_EQ(static_cast<int>(ErrorCode::kProtocol), 1);
  EXPECT_EQ(static_cast<int>(ErrorCode::kBadAddress), 5);
  EXPECT_EQ(static_cast<int>(ErrorCode::kInternal), 9);
  EXPECT_EQ(static_cast<int>(ErrorCode::kCorrupted), 10);
  EXPECT_EQ(static_cast<int>(ErrorCode::kDeadline), 11);
  EXPECT_EQ(static_cast<int>(ErrorCode::kMemory), 12);
  EXPECT_EQ(static_cast<int>(ErrorCode::kTaken), 13);
  EXPECT_EQ(static_cast<int>(ErrorCode::kNoSession), 14);
  EXPECT_EQ(static_cast<int>(ErrorCode::kForbidden), 15);
}

TEST(Sequence, StepsAcrossItsWrap) {
  EXPECT_EQ(sequence_step(7, 8), 1);
  EXPECT_EQ(sequence_step(7, 7), 0);
  EXPECT_EQ(sequence_step(7, 5), -2);
  EXPECT_EQ(sequence_step(7, 10), 3);
  EXPECT_EQ(sequence_step(0xFFFF'FFFF, 0), 1);
  EXPECT_EQ(sequence_step(1, 0xFFFF'FFFE), -3);
}

TEST(Checksum, IsTheOneOfTheStandard) {  // check value of CRC-32C/iSCSI; RFC 3720 B.4: 32 bytes of zeros
  const std::string_view digits = "123456789";
  EXPECT_EQ(crc32c(std::vector<std::uint8_t>(digits.begin(), digits.end())), 0xE3069283u);
  EXPECT_EQ(crc32c(std::vector<std::uint8_t>(32)), 0x8A9136AAu);
  EXPECT_EQ(crc32c({}), 0u);
}

RC_GTEST_PROP(Checksum, OfAFrameSeesEveryBit, ()) {
  FrameHeader header = any_header();
  std::vector<std::uint8_t> payload(*rc::gen::inRange<std::size_t>(0, 300), 0x5A);
  std::array<std::uint8_t, kFrameHeaderBytes> bytes{};
  encode_sealed(header, payload, bytes);
  header.checksum = frame_checksum(bytes, payload);
  RC_ASSERT(decode_frame_header(bytes) == header);
  const auto bit = *rc::gen::inRange<std::size_t>(0, 8 * (bytes.size() + payload.size()));
  std::uint8_t& hit = bit / 8 < bytes.size() ? bytes[bit / 8] : payload[bit / 8 - bytes.size()];
  hit = static_cast<std::uint8_t>(hit ^ 1u << bit % 8);
  RC_ASSERT(frame_checksum(bytes, payload) != load<std::uint32_t>(bytes, 44));
}

TEST(Version, HasTheBytesThatItsTableSays) {
  VersionInfo info{.major = 1, .minor = 2, .max_payload_bytes = 4u << 20, .window_slots = 64};
  info.window_bytes = 16u << 20;
  info.capabilities = kFunctionalLevel | kProgressFrames | kHostRays;  // 1 + 8 + 16 = 0x19
  info.flags = kForce;
  info.session = 0x1122334455667788;
  info.taken = 9;
  info.consumed = 8;
  info.wait_ms = 1000;  // 0x3E8
  EXPECT_EQ(hex_of<kVersionBytes>(info),
            "01 00 02 00 00 00 40 00 40 00 00 00 01 00 00 00 "  // versions, 0x400000, 0x40, flags
            "00 00 00 01 00 00 00 00 19 00 00 00 00 00 00 00 "  // 0x1000000, capabilities
            "88 77 66 55 44 33 22 11 09 00 00 00 08 00 00 00 "  // session, taken, consumed
            "E8 03 00 00 00 00 00 00");                         // wait_ms, reserved
}

RC_GTEST_PROP(Version, ComesBackAsItWas, ()) {
  const VersionInfo info = any_version();
  RC_ASSERT(decode<VersionInfo>(encoded<kVersionBytes>(info)) == info);
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
