// The bytes of a frame, shared by those that may have to send it again.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace gicube {

using Payload = std::shared_ptr<const std::vector<std::uint8_t>>;

}  // namespace gicube
