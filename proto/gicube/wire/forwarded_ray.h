// Rays that wait on one card and go on on another, by way of their hosts: the commands kTakeRays and kGiveRays. README.md has their
// bytes.
//
// kTakeRays takes rays off the card that wait for the blocks it names, at most `max_rays` and those by their homes and numbers first;
// if `ended` is 1, instead those that other cards made and that have come to their ends here. Its completion: a TakenHeader, and the
// records. Without a block and with `ended` 0 it says nothing but 0.
//
// kGiveRays gives a card ForwardedRays, which wait on as if they had come to wait here, and EndedRays that it made itself (their home
// is 0), which have come to their ends. Its completion is a WaitingHeader as after kContinue (command.h), without a ledger. They are
// of one kRender, whose rows this card has begun; or of kTrace or kIlluminate, of which this card may have made no ray: then the
// header says of which. Registers and tables must be as on the card that made them.
#pragma once

#include <array>
#include <cstdint>

#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/record.h"

namespace gicube::wire {

// A ray as it waits, with bits that its packet does not have; four times the size of one. Fields as the board's RayState.
struct ForwardedRay {
  std::uint64_t number = 0;  // on the card that made it: (v, u) of a picture's
  std::uint32_t block = 0;   // that it waits for
  std::uint16_t home = 0;    // 0: this card made it; else what the hosts call the card that did
  std::uint8_t trapped = 0;  // 1: it waits for a routine's answer besides
  std::array<std::int32_t, 3> position{}, step{};
  std::uint32_t exponent = 0, length = 0, opacity = 0, interacted = 0;
  std::array<std::uint16_t, 3> colour{};
  std::array<std::int16_t, 3> direction{};
  std::uint16_t u = 0, v = 0, lifetime = 0;
  std::uint8_t generation = 0, under_way = 0, flags = 0;
  std::array<std::uint32_t, 4> wide{};  // opacity and colour of the wide datapath, as bits of IEEE 754 numbers
  std::array<std::uint16_t, 3> rest{}, step_rest{};
  std::array<std::uint16_t, 3> green_energy{}, blue_energy{};

  constexpr void fields(auto&& list) {
    list(number, block, home, trapped, position, step, exponent, length, opacity, interacted, colour, direction, u, v,
         lifetime, generation, under_way, flags, wide, rest, step_rest, green_energy, blue_energy, Reserved<12>{});
  }
  friend constexpr bool operator==(const ForwardedRay&, const ForwardedRay&) = default;
};
inline constexpr std::size_t kForwardedRayBytes = bytes_of<ForwardedRay>();
static_assert(kForwardedRayBytes == 4 * kRayBytes);

struct EndedRay {
  std::uint64_t number = 0;  // as a ForwardedRay's
  std::uint16_t home = 0;
  Ray ray;

  constexpr void fields(auto&& list) { list(number, home, Reserved<6>{}, ray, Reserved<16>{}); }
  friend constexpr bool operator==(const EndedRay&, const EndedRay&) = default;
};
inline constexpr std::size_t kEndedRayBytes = 2 * kRayBytes;

struct TakeRaysHeader {
  std::uint32_t max_rays = 0;  // that the completion may hold
  std::uint32_t blocks = 0;    // numbers of 4 bytes that follow, ascending
  std::uint8_t ended = 0;      // 1: rays that have ended are taken, and no block is named

  constexpr void fields(auto&& list) { list(Opcode::kTakeRays, max_rays, blocks, ended, Reserved<3>{}); }
};
inline constexpr std::size_t kTakeRaysHeaderBytes = bytes_of<TakeRaysHeader>();

struct TakenHeader {
  std::uint32_t rays = 0;  // records that follow
  std::uint32_t left = 0;  // such rays that are still on the card

  constexpr void fields(auto&& list) { list(rays, left); }
};
inline constexpr std::size_t kTakenHeaderBytes = bytes_of<TakenHeader>();

enum class RaysOf : std::uint8_t { kPicture = 0, kTrace = 1, kLight = 2 };

struct GiveRaysHeader {
  std::uint32_t rays = 0;   // ForwardedRays that follow
  std::uint32_t ended = 0;  // EndedRays behind them
  RaysOf of = RaysOf::kPicture;
  TraceHeader trace{};  // without its count; of kLight: type kDeposit and the rules; of kPicture nobody reads it

  constexpr void fields(auto&& list) { list(Opcode::kGiveRays, rays, ended, of, Reserved<3>{}, trace); }
};
inline constexpr std::size_t kGiveRaysHeaderBytes = bytes_of<GiveRaysHeader>();

}  // namespace gicube::wire
