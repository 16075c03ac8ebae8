// The PCI function that gicube-pci gives a guest (docs/guide/pci.md): registers in BAR 0, two rings in the guest's
// memory.
//
// They carry the bytes of a data plane's stream (frame.h) and take no simulated time: the modelled bus of the board is
// simulated by the board process, whoever carries its frames.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

namespace gicube::wire::function {

// BAR 0: dwords, to be read and written by aligned accesses of four bytes. Others set Error::kBadAccess, and read as
// all ones.
inline constexpr std::uint32_t kIdentity = 0x00;   // r: kIdentityValue
inline constexpr std::uint32_t kVersion = 0x04;    // r: kVersionValue
inline constexpr std::uint32_t kState = 0x08;      // r: State
inline constexpr std::uint32_t kError = 0x0C;      // r: Error, the first one since the function was opened or reset
inline constexpr std::uint32_t kRingLow = 0x10;    // rw: guest-physical address of the rings, aligned
inline constexpr std::uint32_t kRingHigh = 0x14;   // rw: its upper half
inline constexpr std::uint32_t kRingBytes = 0x18;  // rw: bytes of each of the two rings
inline constexpr std::uint32_t kControl = 0x1C;    // w: kOpenSession, kCloseSession
inline constexpr std::uint32_t kBell = 0x20;       // w: indices in memory have changed
inline constexpr std::uint32_t kInterruptStatus = 0x24;  // rw: kMoved, kEnded; a 1 that is written clears the bit
inline constexpr std::uint32_t kInterruptMask = 0x28;    // rw: 1 = the bit of the status raises INTx

inline constexpr std::uint32_t kIdentityValue = 0x4650'4947;  // "GIPF"
inline constexpr std::uint32_t kVersionValue = 2;
inline constexpr std::uint32_t kGone = 0xFFFF'FFFF;  // any register of a function that was removed

inline constexpr std::uint32_t kCloseSession = 0;
inline constexpr std::uint32_t kOpenSession = 1;
inline constexpr std::uint32_t kMoved = 1u << 0;  // bytes have come, or were taken
inline constexpr std::uint32_t kEnded = 1u << 1;  // no more bytes will come

enum class State : std::uint32_t {
  kClosed = 0,
  kOpen = 1,   // bytes move
  kFailed = 2  // ended by an error; kError says which
};

enum class Error : std::uint32_t {
  kNone = 0,
  kBadAccess = 1,    // of another size than four bytes, not aligned, or no register
  kNoBusMaster = 2,  // the command register does not let the function use memory
  kBadRing = 3,      // the rings are not aligned, have no valid size, or are not within the guest's memory
  kBadIndex = 4,     // more bytes in a ring than fit into it
  kNoBoard = 5,      // the board can't be connected
  kBoardGone = 6     // the board has closed the connection
};

inline constexpr const char* text_of(Error error) {
  constexpr const char* kTexts[] = {"no error",
                                    "a register was accessed by another width than four bytes",
                                    "it may not master the bus",
                                    "its rings are not in the guest's memory",
                                    "a ring holds more bytes than fit into it",
                                    "its board cannot be connected",
                                    "its board has closed the connection"};
  return static_cast<std::uint32_t>(error) < std::size(kTexts) ? kTexts[static_cast<std::uint32_t>(error)]
                                                               : "an unknown error";
}

// The memory at kRingLow: a page of indices, the ring of bytes to the board ("down"), the ring of bytes from it ("up").
// An index counts bytes modulo 2^32; each has one writer. A writer stores its index after the bytes.
inline constexpr std::uint32_t kRingAlignment = 4096;
inline constexpr std::uint32_t kIndexBytes = 4096;
inline constexpr std::uint32_t kMinRingBytes = 4096;      // powers of two from here
inline constexpr std::uint32_t kMaxRingBytes = 16 << 20;  // chosen: 30 times what a huge page of 2 MiB holds
inline constexpr std::uint32_t kDownPut = 0;              // by the guest
inline constexpr std::uint32_t kDownTaken = 64;           // by the function
inline constexpr std::uint32_t kUpPut = 128;              // by the function
inline constexpr std::uint32_t kUpTaken = 192;            // by the guest
inline constexpr std::uint32_t kUpWaits = 256;      // by the function: 1 = full; a bell is wanted when bytes are taken
inline constexpr std::uint32_t kStreamEnded = 320;  // by the function: 1 = kUpPut is final

inline std::atomic_ref<std::uint32_t> index_at(std::byte* rings, std::uint32_t offset) {
  return std::atomic_ref(*reinterpret_cast<std::uint32_t*>(rings + offset));
}

// The contiguous bytes from an index on, at most `count`.
inline std::span<std::byte> piece_of(std::span<std::byte> ring, std::uint32_t index, std::uint32_t count) {
  const std::size_t at = index & (ring.size() - 1);
  return ring.subspan(at, std::min<std::size_t>(count, ring.size() - at));
}

}  // namespace gicube::wire::function
