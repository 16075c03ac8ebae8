// Rays that wait on one card and continue on another, sent by their hosts: the commands kTakeRays and kGiveRays.
// README.md defines their bytes.
//
// kTakeRays removes rays from the card that wait for the listed blocks, at most `max_rays`, in the order of their homes
// and numbers. If `ended` is 1, it instead removes rays that other cards made and that have ended here. The completion
// is a TakenHeader and the records. Without blocks and with `ended` 0 both counts are 0.
//
// kGiveRays adds ForwardedRays to a card, which then wait as if they had begun to wait here. It also adds EndedRays
// that this card made itself (their home is 0); they have ended. The completion is a WaitingHeader, as after kContinue
// (command.h), without a ledger. All rays belong to one kRender, which this card has begun; or to a kTrace or
// kIlluminate, for which this card may have made no ray: then the header identifies it. Registers and tables must be
// the same as on the card that made the rays.
#pragma once

#include <array>
#include <cstdint>

#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/record.h"

namespace gicube::wire {

// A waiting ray, with the bits that a ray packet lacks; four times the size of a packet. The fields are those of the
// board's RayState.
struct ForwardedRay {
  std::uint64_t number = 0;  // number on the card that made it: for an image (v, u)
  std::uint32_t block = 0;   // block that it waits for
  std::uint16_t home = 0;    // 0: this card made it; otherwise the number that the hosts use for the card that did
  std::uint8_t trapped = 0;  // 1: it also waits for a routine's answer
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
  std::uint64_t number = 0;  // as in ForwardedRay
  std::uint16_t home = 0;
  Ray ray;

  constexpr void fields(auto&& list) { list(number, home, Reserved<6>{}, ray, Reserved<16>{}); }
  friend constexpr bool operator==(const EndedRay&, const EndedRay&) = default;
};
inline constexpr std::size_t kEndedRayBytes = 2 * kRayBytes;

struct TakeRaysHeader {
  std::uint32_t max_rays = 0;  // maximum number of records in the completion
  std::uint32_t blocks = 0;    // number of block numbers that follow, 4 bytes each, ascending
  std::uint8_t ended = 0;      // 1: take rays that have ended; no blocks follow

  constexpr void fields(auto&& list) { list(Opcode::kTakeRays, max_rays, blocks, ended, Reserved<3>{}); }
};
inline constexpr std::size_t kTakeRaysHeaderBytes = bytes_of<TakeRaysHeader>();

struct TakenHeader {
  std::uint32_t rays = 0;  // records that follow
  std::uint32_t left = 0;  // matching rays that are still on the card

  constexpr void fields(auto&& list) { list(rays, left); }
};
inline constexpr std::size_t kTakenHeaderBytes = bytes_of<TakenHeader>();

enum class RaysOf : std::uint8_t { kPicture = 0, kTrace = 1, kLight = 2 };

struct GiveRaysHeader {
  std::uint32_t rays = 0;   // ForwardedRays that follow
  std::uint32_t ended = 0;  // EndedRays after them
  RaysOf of = RaysOf::kPicture;
  TraceHeader trace{};  // `count` is unused. kLight: type kDeposit and the rules; kPicture: ignored

  constexpr void fields(auto&& list) { list(Opcode::kGiveRays, rays, ended, of, Reserved<3>{}, trace); }
};
inline constexpr std::size_t kGiveRaysHeaderBytes = bytes_of<GiveRaysHeader>();

}  // namespace gicube::wire
