// Payloads that tests of sessions send, and the last word that ends one.
#pragma once

#include "served_boards.h"
#include "test.h"

namespace gicube::emu {

inline std::vector<std::uint8_t> word(std::uint32_t value) {
  std::vector<std::uint8_t> bytes(4);
  wire::store(std::span(bytes), 0, value);
  return bytes;
}

inline std::vector<std::uint8_t> memory_request(std::uint64_t address, std::uint64_t length) {
  std::vector<std::uint8_t> bytes(16);
  wire::store(std::span(bytes), 0, address);
  wire::store(std::span(bytes), 8, length);
  return bytes;
}

// Every frame until the session's end; the last one is the last word.
inline std::optional<reference::RawFrame> last_frame(reference::RawClient& client) {
  std::optional<reference::RawFrame> last;
  while (auto frame = client.receive()) last = std::move(frame);
  return last;
}

inline void expect_ended(reference::RawClient& client, wire::ErrorCode error, std::uint32_t id, const char* words) {
  const auto last = last_frame(client);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.type, wire::FrameType::kVersion);
  EXPECT_EQ(last->header.flags, wire::kResponse);
  EXPECT_EQ(last->header.error, error);
  EXPECT_EQ(last->header.id, id);
  EXPECT_THAT(last->text(), HasSubstr(words));
}

}  // namespace gicube::emu
