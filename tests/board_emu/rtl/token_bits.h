// A ray's token as a vector of board_emu/rtl.
#pragma once

#include "lockstep.h"

namespace gicube::emu::lockstep {

// From the lowest bit: queue, processor (8), contribution (12), state (3), has_reserved_slot, the ray's handle.
struct TokenBits {
  std::size_t queue = 0, ray = 32;

  std::size_t size() const { return queue + 24 + ray; }
  template <typename Vector>
  void put(Vector& vector, std::size_t place, const RayToken& token) const {
    std::size_t at = place * size();
    const auto field = [&](std::size_t count, std::uint64_t value) {
      lockstep::put(vector, at, count, value);
      at += count;
    };
    field(queue, token.queue);
    field(8, token.processor);
    field(12, token.contribution);
    field(3, static_cast<std::uint64_t>(token.state));
    field(1, token.has_reserved_slot ? 1 : 0);
    field(ray, token.ray);
  }
  template <typename Vector>
  RayToken get(const Vector& vector, std::size_t place) const {
    return from(&vector, place);
  }
  RayToken from(const void* vector, std::size_t place = 0) const {
    std::size_t at = place * size();
    const auto field = [&](std::size_t count) {
      const std::uint64_t value = bits_at(vector, at, count);
      at += count;
      return value;
    };
    RayToken token;
    token.queue = static_cast<std::uint32_t>(field(queue));
    token.processor = static_cast<std::uint8_t>(field(8));
    token.contribution = static_cast<std::uint16_t>(field(12));
    token.state = static_cast<TokenStatus>(field(3));
    token.has_reserved_slot = field(1) != 0;
    token.ray = static_cast<std::uint32_t>(field(ray));
    return token;
  }
};

}  // namespace gicube::emu::lockstep
