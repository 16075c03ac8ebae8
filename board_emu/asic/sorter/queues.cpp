#include "asic/sorter/queues.h"

namespace gicube::emu {

Queues::Queues(std::uint32_t queues, std::uint32_t capacity, v1::QueuePolicy policy)
    : capacity_(capacity), importance_of_(emu::importance_of(policy)), states_(queues) {}

std::uint32_t Queues::grow() {
  records_.emplace_back();
  return static_cast<std::uint32_t>(records_.size() - 1);
}

}  // namespace gicube::emu
