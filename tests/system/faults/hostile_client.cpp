#include "hostile_client.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "gicube/wire/checksum.h"
#include "gicube/wire/frame.h"

namespace gicube::system_test {
namespace {

using reference::RawClient;
using wire::FrameHeader;
using wire::FrameType;
using Bytes = std::vector<std::uint8_t>;
using Random = std::mt19937_64;

Bytes noise(Random& random, std::size_t size) {
  Bytes bytes(size);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

Bytes frame(const FrameHeader& header, const Bytes& payload) {
  Bytes bytes(wire::kFrameHeaderBytes);
  wire::encode_sealed(header, payload, std::span(bytes).first<wire::kFrameHeaderBytes>());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

Bytes version_frame(const wire::VersionInfo& version, const std::string& token) {
  Bytes payload(wire::kVersionBytes);
  wire::encode(version, payload);
  payload.insert(payload.end(), token.begin(), token.end());
  FrameHeader header{FrameType::kVersion};
  header.size = static_cast<std::uint32_t>(payload.size());
  return frame(header, payload);
}

// Takes whatever the board says until it closes; the board must not wait for ever.
void listen_to_the_end(RawClient& client) {
  try {
    while (client.receive()) {
    }
  } catch (const std::runtime_error&) {  // no frame
  }
}

void nothing_at_all(RawClient&, Random&, const std::string&) {}

void silence(RawClient&, Random& random, const std::string&) {
  std::this_thread::sleep_for(std::chrono::milliseconds(random() % 40));
}

void garbage(RawClient& client, Random& random, const std::string&) {
  client.send_bytes(noise(random, random() % 70'000));
  listen_to_the_end(client);
}

void half_a_header(RawClient& client, Random& random, const std::string& token) {
  Bytes bytes = version_frame({}, token);
  bytes.resize(random() % wire::kFrameHeaderBytes);
  client.send_bytes(bytes);
}

void half_a_payload(RawClient& client, Random& random, const std::string& token) {
  Bytes bytes = version_frame({}, token);
  bytes.resize(wire::kFrameHeaderBytes + random() % wire::kVersionBytes);
  client.send_bytes(bytes);
  client.end_sending();
  listen_to_the_end(client);
}

void one_byte_at_a_time(RawClient& client, Random& random, const std::string& token) {
  Bytes bytes = version_frame({}, token);
  const std::size_t stop = random() % bytes.size();
  for (std::size_t i = 0; i < stop; ++i) {
    if (!client.send_bytes(std::span(bytes).subspan(i, 1))) return;
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
}

void a_flipped_bit(RawClient& client, Random& random, const std::string& token) {
  Bytes bytes = version_frame({}, token);
  const std::size_t bit = random() % (bytes.size() * 8);
  bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1u << bit % 8);
  client.send_bytes(bytes);
  client.end_sending();  // a longer payload will never come
  listen_to_the_end(client);
}

void a_huge_payload(RawClient& client, Random& random, const std::string&) {
  FrameHeader header{FrameType::kVersion};
  header.size = static_cast<std::uint32_t>(random() | 0x8000'0000);
  client.send_bytes(frame(header, {}));
  client.send_bytes(noise(random, 20'000));
  listen_to_the_end(client);
}

void another_major_version(RawClient& client, Random& random, const std::string& token) {
  wire::VersionInfo version;
  version.major = static_cast<std::uint16_t>(version.major + 1 + random() % 60'000);
  client.send_bytes(version_frame(version, token));
  listen_to_the_end(client);
}

// The board has an owner: this one is refused, and goes on talking as if it were not.
void the_board_of_another(RawClient& client, Random& random, const std::string& token) {
  client.send_bytes(version_frame({}, token));
  FrameHeader header{FrameType::kCommand, wire::kPosted, static_cast<std::uint32_t>(random())};
  Bytes payload = noise(random, 1000);
  header.size = static_cast<std::uint32_t>(payload.size());
  for (header.sequence = 1; header.sequence < 50; ++header.sequence) {
    if (!client.send_bytes(frame(header, payload))) break;
  }
  listen_to_the_end(client);
}

// A guess at the owner's session.
void a_stolen_session(RawClient& client, Random& random, const std::string& token) {
  wire::VersionInfo version;
  version.session = random() | 1;
  version.taken = static_cast<std::uint32_t>(random());
  client.send_bytes(version_frame(version, token));
  listen_to_the_end(client);
}

void no_version_first(RawClient& client, Random& random, const std::string&) {
  const auto type = static_cast<FrameType>(2 + random() % 13);
  FrameHeader header{type, static_cast<std::uint16_t>(random() % 4), static_cast<std::uint32_t>(random())};
  const Bytes payload = noise(random, random() % 5000);
  header.size = static_cast<std::uint32_t>(payload.size());
  client.send_bytes(frame(header, payload));
  listen_to_the_end(client);
}

}  // namespace

bool misbehave(const Door& door, int way, std::uint64_t seed) {
  using Way = void (*)(RawClient&, Random&, const std::string& token);
  static constexpr std::array<Way, kHostileWays> kWays{nothing_at_all,       silence,          garbage,
                                                       half_a_header,        half_a_payload,   one_byte_at_a_time,
                                                       a_flipped_bit,        a_huge_payload,   another_major_version,
                                                       the_board_of_another, a_stolen_session, no_version_first};
  Random random(seed);
  try {
    RawClient client = door.connect();
    kWays.at(static_cast<std::size_t>(way))(client, random, door.token);
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace gicube::system_test
