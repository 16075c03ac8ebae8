// What parts tell of a ray that is watched: its token has the mark `watched`, so that all other rays cost one comparison.
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
  kGone,        // of a carrier: its deposit was written
  kKept,        // an overflowed ray, in the DSP's memory
  kScattered,   // by a routine of the DSP; `count`: DSP cycles that the routine took
  kWaits,       // the DSP keeps it for the host: a routine of the host's, or a block that is absent
  kTaken,       // its source has what it gathered: a viewing ray is in the image
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
  std::uint64_t count = 0;  // as the step says

  // What the machine adds.
  std::uint64_t ray = 0;    // of its source: a host's rays in their order, viewing rays as the DSP makes them
  bool is_carrier = false;  // of the deposit of that ray
  std::uint32_t block =
      0;  // of the volume, x fastest: of a sample or leap that in which it was, else where the ray is now
  const RayState* state = nullptr;    // its words after the step
  const RaySample* sample = nullptr;  // of kSampled, unless a carrier's
};

class RayListener {
 public:
  virtual void tell(const RayEvent& event) = 0;

 protected:
  ~RayListener() = default;
};

}  // namespace gicube::emu
