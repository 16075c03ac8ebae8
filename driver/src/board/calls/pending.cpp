#include "gicube/pending.h"

#include <poll.h>

#include <utility>

#include "operation.h"

namespace gicube {

PendingCall::PendingCall(std::shared_ptr<Operation> operation) : operation_(std::move(operation)) {}
PendingCall::PendingCall(PendingCall&&) noexcept = default;
PendingCall& PendingCall::operator=(PendingCall&&) noexcept = default;
PendingCall::~PendingCall() = default;

bool PendingCall::wait(std::chrono::milliseconds timeout) const { return operation_->wait(timeout); }
bool PendingCall::cancel() { return operation_->cancel(); }
PendingProgress PendingCall::progress() const { return operation_->progress(); }
int PendingCall::descriptor() const { return operation_->descriptor().release(); }

template <class T>
T Pending<T>::get(Picoseconds deadline) {
  return static_cast<OperationOf<T>&>(*operation_).take(deadline);
}

template class Pending<void>;
template class Pending<Image>;
template class Pending<LightingReport>;
template class Pending<std::vector<PairFactor>>;
template class Pending<RayBatch>;

}  // namespace gicube
