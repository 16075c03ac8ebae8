#include "sorter/queues.h"

namespace gicube::emu {

Queues::Queues(std::uint32_t queues, std::uint32_t capacity, QueuePolicy policy)
    : capacity_(capacity), policy_(policy), states_(queues) {}

}  // namespace gicube::emu
