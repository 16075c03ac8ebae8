// Takes rays off a card by the command kTakeRays.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "board/device.h"
#include "gicube/wire/forwarded_ray.h"

namespace gicube {

// Calls use(record) for each ray. The counts of `header` are set here. There may be at most blocks_of_take_command()
// blocks.
template <typename Ray, typename Use>
void take_rays(Device& device, wire::TakeRaysHeader header, std::span<const std::uint32_t> blocks, const Use& use) {
  constexpr std::size_t kMost = 65536, kBytes = wire::bytes_of<Ray>();
  header.blocks = static_cast<std::uint32_t>(blocks.size());
  header.max_rays = static_cast<std::uint32_t>(
      std::min(kMost, (device.agreed().max_payload_bytes - wire::kTakenHeaderBytes) / kBytes));
  std::vector<std::uint8_t> command = wire::encoded(header);
  command.resize(command.size() + 4 * blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    wire::store(std::span(command), wire::kTakeRaysHeaderBytes + 4 * i, blocks[i]);
  }
  for (std::uint32_t left = 1; left > 0;) {
    const CommandResult result = device.run(command, {});
    const std::span<const std::uint8_t> payload = result.payload;
    wire::TakenHeader taken;
    if (payload.size() >= wire::kTakenHeaderBytes) taken = wire::decode<wire::TakenHeader>(payload);
    if (payload.size() != wire::kTakenHeaderBytes + taken.rays * kBytes || (taken.rays == 0 && taken.left > 0)) {
      device.give_up("a list of rays of wrong size");
    }
    for (std::size_t i = 0; i < taken.rays; ++i) {
      use(wire::decode<Ray>(payload.subspan(wire::kTakenHeaderBytes + i * kBytes)));
    }
    left = taken.left;
  }
}

inline std::size_t blocks_of_take_command(const Device& device) {
  return (device.agreed().max_payload_bytes - wire::kTakeRaysHeaderBytes) / 4;
}

}  // namespace gicube
