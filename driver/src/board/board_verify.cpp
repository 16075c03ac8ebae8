// Comparing what the board's memory holds with what was written there.
#include <algorithm>

#include "gicube/wire/command.h"
#include "state.h"

namespace gicube {
std::vector<std::size_t> Board::verify_volume() {
  const auto lock = state_->begin();
  state_->loaded("verify_volume()");
  Device& device = state_->device;
  const std::vector<std::uint32_t>& sums = state_->block_sums;
  const std::size_t max_blocks = std::min<std::size_t>(wire::kMaxVerifyBlocks, device.agreed().max_payload_bytes / 4);
  std::vector<std::size_t> damaged;
  for (std::size_t first = 0; first < sums.size(); first += max_blocks) {
    const std::size_t count = std::min(max_blocks, sums.size() - first);
    const wire::VerifyCommand command{static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(count)};
    const CommandResult result = device.run(wire::encoded(command), {});
    if (result.payload.size() != 4 * count) {
      device.give_up("the board summed up " + std::to_string(count) + " blocks in " +
                     std::to_string(result.payload.size()) + " bytes");
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (wire::load<std::uint32_t>(result.payload, 4 * i) != sums[first + i]) damaged.push_back(first + i);
    }
  }
  return damaged;
}

}  // namespace gicube
