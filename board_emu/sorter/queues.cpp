#include "sorter/queues.h"

namespace gicube::emu {

Queues::Queues(std::uint32_t queues, std::uint32_t capacity, QueuePolicy policy)
    : capacity_(capacity), policy_(policy), states_(queues) {}

void Queues::write(std::uint32_t queue, const RayToken& token) {
  State& state = states_[queue];
  if (!token.keeps_slot) {
    assert(has_slot(queue));
    ++state.slots;
  }
  assert(state.slots > state.waiting);
  std::uint32_t at = free_;
  if (at == kNone) {
    at = static_cast<std::uint32_t>(records_.size());
    records_.push_back({token, kNone});
  } else {
    free_ = records_[at].next;
    records_[at] = {token, kNone};
  }
  (state.waiting == 0 ? state.head : records_[state.tail].next) = at;
  state.tail = at;
  ++state.waiting;
  state.contribution += weight(token);
  ++waiting_;
}

RayToken Queues::read(std::uint32_t queue) {
  State& state = states_[queue];
  assert(state.waiting > 0);
  const std::uint32_t at = state.head;
  const RayToken token = records_[at].token;
  state.head = records_[at].next;
  records_[at].next = free_;
  free_ = at;
  --state.waiting;
  state.contribution -= weight(token);
  --waiting_;
  return token;
}

}  // namespace gicube::emu
