// Events of traced rays. A traced ray's token is marked `watched`, so that all other rays cost one comparison.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "words/clock.h"

namespace gicube::emu {

struct RaySample;
struct RayState;

enum class RayStep : std::uint8_t {
  kMade,        // by the DSP; an irradiance carrier by a processor
  kSent,        // to the ray bus; `count`: 1 if it was sent before
  kQueued,      // into `queue` of `processor`
  kOverflowed,  // that queue has no slot: it goes back to the DSP
  kIssued,      // from `queue` to the pipeline
  kSampled,     // the tags of a sample were checked; `count`: packets that are missing
  kLeapt,       // over an empty block
  kFilled,      // the missing packets have come; `count`: cycles in which the pipeline took no sample for that
  kDeposited,   // its deposit waits to be written; `count`: carriers that it sends to other blocks
  kLinked,      // on the links, from `processor` to processor `count`
  kArrived,     // from the links at `processor`
  kGone,        // a carrier's deposit was written
  kKept,        // an overflowed ray, in the DSP's memory
  kScattered,   // by a routine of the DSP; `count`: DSP cycles that the routine took
  kWaits,       // the DSP keeps it for the host: a routine of the host's, or a non-resident block
  kTaken,       // its source has its result: a viewing ray is in the image
};
inline constexpr std::array<std::string_view, 16> kRayStepNames{
    "made",      "sent",   "queued",  "overflowed", "issued", "sampled",   "leapt", "filled",
    "deposited", "linked", "arrived", "gone",       "kept",   "scattered", "waits", "taken"};

struct RayEvent {
  static constexpr int kDsp = -1;

  RayStep step = RayStep::kMade;
  Cycle cycle = 0;
  std::uint32_t handle = 0;
  int processor = kDsp;
  std::uint32_t queue = 0;  // of that processor
  std::uint64_t count = 0;  // its meaning depends on the step

  // Filled in by the machine.
  std::uint64_t ray = 0;    // number in its source: host rays in their order, viewing rays in that of the DSP
  bool is_carrier = false;  // the event is that of a carrier of the ray's deposit
  std::uint32_t block = 0;  // of the volume, x fastest: that of the sample or skip, else that of the ray's position
  const RayState* state = nullptr;    // state of the ray after the step
  const RaySample* sample = nullptr;  // kSampled of rays only, not of carriers
};

class RayListener {
 public:
  virtual void report(const RayEvent& event) = 0;

 protected:
  ~RayListener() = default;
};

}  // namespace gicube::emu
