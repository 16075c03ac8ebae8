// What rays do where blocks of the volume are not on the card. They wait, with all their bits, so that they go on as if they had not
// waited. What they leave in blocks whose irradiance the host has goes to the host, which adds it to its words: a deposit is divided
// among its voxels, and those of other blocks get their shares on the card, with all copies.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "datapath/frame.h"
#include "datapath/ray_step.h"
#include "words/block_grid.h"

namespace gicube::emu {

struct WaitingRay {
  RayState ray_state{};
  std::uint64_t number = 0;  // among the rays of its commands, which go on in this order
  std::uint32_t block = 0;
  std::uint16_t home = 0;  // 0: this card made it; else by wire::ForwardedRay
  bool trapped = false;    // it waits for a routine's answer besides, which the sample at its place is asked for

  void state(Archive::Record& record) { record(ray_state, number, block, home, trapped); }
};

class WaitingRayQueue {
 public:
  virtual ~WaitingRayQueue() = default;
  // Takes ray `index` of the run's source. From several threads. Throws RoutineFault if there are too many.
  virtual void add(const WaitingRay& ray, std::uint64_t index) = 0;
  // Ray `index` of the run's source as it waited; null: it sets out.
  virtual const WaitingRay* find(std::uint64_t index) const = 0;
};

// Whether a ray that comes to the block must wait.
inline bool is_absent(std::size_t block, const Frame& frame) {
  if (frame.absent.empty() || frame.absent[block] == 0) return false;
  return !frame.leap || frame.empty[block] == 0;
}

// Whether a trapped ray must wait for the block: its routine is told of the sample there, also if rays leap over the block.
inline bool is_absent_for_routine(std::size_t block, const Frame& frame) {
  return !frame.absent.empty() && frame.absent[block] != 0;
}

// The state in which ray `index` of the run's source, made as `ray`, begins or goes on.
inline RayState begin_or_go_on(const wire::Ray& ray, std::uint64_t index, const Frame& frame) {
  const WaitingRay* const waited = frame.in_bricks() ? frame.waiting->find(index) : nullptr;
  return waited != nullptr ? waited->ray_state : unpack(ray, frame);
}

class HostDepositList {
 public:
  virtual ~HostDepositList() = default;
  // `word`: block * n^3 + voxel of the block. From several threads. Throws RoutineFault if there are too many.
  virtual void add(std::uint64_t word, std::uint32_t units) = 0;
};

// The block that owns a voxel of the volume.
inline std::size_t owner_of(const std::array<std::int32_t, 3>& voxel, const IrradianceMemory& words) {
  const int n = words.block_voxels();
  const auto& blocks = words.blocks();
  return static_cast<std::size_t>(voxel[0] / n + blocks[0] * (voxel[1] / n + blocks[1] * (voxel[2] / n)));
}

// Calls use(share's number, owner, voxel) for each share of the deposit that is not 0.
template <typename Use>
void for_each_share(const Deposit& deposit, const IrradianceMemory& words, const Use& use) {
  for (std::size_t i = 0; i < deposit.shares.size(); ++i) {
    if (deposit.shares[i] == 0) continue;
    std::array<std::int32_t, 3> voxel{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      voxel[axis] = deposit.voxel[axis] + static_cast<std::int32_t>(i >> axis & 1);
    }
    use(i, owner_of(voxel, words), voxel);
  }
}

// The deposit without what goes to the host.
inline Deposit on_card(const Deposit& deposit, const Frame& frame) {
  Deposit out = deposit;
  if (frame.dark.empty()) return out;
  for_each_share(deposit, *frame.irradiance, [&](std::size_t i, std::size_t owner, const auto&) {
    if (frame.dark[owner] != 0) out.shares[i] = 0;
  });
  return out;
}

// Gives the host its shares; of `block` alone, if that is a block.
inline void give_host(const Deposit& deposit, const Frame& frame, std::size_t block = ~std::size_t{0}) {
  if (frame.dark.empty()) return;
  for_each_share(deposit, *frame.irradiance, [&](std::size_t i, std::size_t owner, const auto& voxel) {
    if (frame.dark[owner] == 0 || (block != ~std::size_t{0} && owner != block)) return;
    const auto n = static_cast<std::uint64_t>(frame.irradiance->block_voxels());
    const auto along = [&](std::size_t axis) { return static_cast<std::uint64_t>(voxel[axis]) % n; };
    frame.host_deposits->add(owner * n * n * n + along(0) + n * (along(1) + n * along(2)), deposit.shares[i]);
  });
}

}  // namespace gicube::emu
