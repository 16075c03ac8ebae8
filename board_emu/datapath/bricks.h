// Rays in volumes with non-resident blocks. A ray that reaches such a block waits with its complete state, so that it
// continues as if it had not waited. Energy for blocks whose irradiance is at the host is sent to the host, which adds
// it to its words: a deposit is split among its voxels, and those of other blocks get their shares, with all copies, on
// the card.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "datapath/frame.h"
#include "datapath/host_deposits.h"
#include "datapath/ray_step.h"
#include "datapath/waiting_rays.h"
#include "words/block_grid.h"

namespace gicube::emu {

// Whether a ray that reaches the block must wait.
inline bool is_non_resident(std::size_t block, const Frame& frame) {
  if (frame.non_resident.empty() || frame.non_resident[block] == 0) return false;
  return !frame.skip_empty || frame.empty[block] == 0;
}

// Whether a trapped ray must wait for the block: its routine needs the sample there, even if rays skip the block.
inline bool is_non_resident_for_routine(std::size_t block, const Frame& frame) {
  return !frame.non_resident.empty() && frame.non_resident[block] != 0;
}

// The state in which ray `index` of the run's source, made as `ray`, starts or continues.
inline RayState begin_or_go_on(const wire::Ray& ray, std::uint64_t index, const Frame& frame) {
  const WaitingRay* const waited = frame.in_bricks() ? frame.waiting->find(index) : nullptr;
  return waited != nullptr ? waited->ray_state : unpack(ray, frame);
}

// The block that owns a voxel of the volume.
inline std::size_t owner_of(const std::array<std::int32_t, 3>& voxel, const IrradianceMemory& words) {
  const int n = words.block_voxels();
  const auto& blocks = words.blocks();
  return static_cast<std::size_t>(voxel[0] / n + blocks[0] * (voxel[1] / n + blocks[1] * (voxel[2] / n)));
}

// Calls use(index of the share, owner, voxel) for each nonzero share of the deposit.
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

// The deposit without the shares for the host.
inline Deposit on_card(const Deposit& deposit, const Frame& frame) {
  Deposit out = deposit;
  if (frame.irradiance_at_host.empty()) return out;
  for_each_share(deposit, *frame.irradiance, [&](std::size_t i, std::size_t owner, const auto&) {
    if (frame.irradiance_at_host[owner] != 0) out.shares[i] = 0;
  });
  return out;
}

// Passes the host its shares; only those of `block`, if one is given.
inline void give_host(const Deposit& deposit, const Frame& frame, std::size_t block = ~std::size_t{0}) {
  if (frame.irradiance_at_host.empty()) return;
  for_each_share(deposit, *frame.irradiance, [&](std::size_t i, std::size_t owner, const auto& voxel) {
    if (frame.irradiance_at_host[owner] == 0 || (block != ~std::size_t{0} && owner != block)) return;
    const auto n = static_cast<std::uint64_t>(frame.irradiance->block_voxels());
    const auto along = [&](std::size_t axis) { return static_cast<std::uint64_t>(voxel[axis]) % n; };
    frame.host_deposits->add(owner * n * n * n + along(0) + n * (along(1) + n * along(2)), deposit.shares[i]);
  });
}

}  // namespace gicube::emu
