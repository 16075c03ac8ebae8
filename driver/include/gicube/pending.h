// The handle to a call that continues while the application does something else.
//
//   gicube::Pending<gicube::Image> picture = board.renderer().start(view);
//   while (!picture.wait(std::chrono::milliseconds(16))) draw(picture.progress());
//   show(picture.get());
//
// A picture that may take ten seconds of wall-clock time:
//
//   if (!picture.wait(std::chrono::seconds(10))) picture.cancel();  // get() then throws gicube::Cancelled
//
// A call that was started does what the blocking call does, with the same bits and simulated times, on a thread of the
// driver and in its place in the order of the calls: later calls to the Board, now() included, wait until it has ended.
// Only ray batches continue beside other calls, in simulated time too: RayTracer::start() returns once the rays are
// sent, and get() is RayTracer::receive().
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "gicube/export.h"
#include "gicube/image.h"
#include "gicube/pair.h"
#include "gicube/ray.h"
#include "gicube/time.h"

namespace gicube {

class Operation;  // the driver's state of the call

// Parts done and parts in all of a long call: blocks of a volume that is loaded, pairs, otherwise parts that the board
// chooses, so only done / all has a meaning. Called on the calling thread, for a board's parts at most every 100 ms of
// wall-clock time, and at the end with all of them.
using Progress = std::function<void(std::uint32_t done, std::uint32_t all)>;

// The last report of Progress; 0 of 0 before the call has reported any, and always for a batch of rays.
struct PendingProgress {
  std::uint32_t done = 0;
  std::uint32_t all = 0;
};

// The calls of all handles. They may come from any thread. A handle may outlive its Board: the call ends with
// DeviceLost (Loss::kClosed) then. If a handle is destroyed, its call continues and the result is dropped.
class GICUBE_API PendingCall {
 public:
  PendingCall(PendingCall&&) noexcept;
  PendingCall& operator=(PendingCall&&) noexcept;
  ~PendingCall();

  // True if get() would not have to wait for the board's work.
  bool ready() const { return wait(std::chrono::milliseconds(0)); }
  // Waits for that, but not longer than `timeout` of wall-clock time; returns ready(). No simulated time passes by it.
  bool wait(std::chrono::milliseconds timeout) const;
  // Asks the call to end. True if it does, or will: get() throws Cancelled, a batch of rays comes back with
  // `cancelled`. A call that has begun ends within some 100 ms of wall-clock time, as by an exception of
  // OpenOptions::while_waiting. False: it had ended, or its rays are in work.
  bool cancel();
  PendingProgress progress() const;
  // A file descriptor for poll(), epoll or an event loop, readable once ready() is true. The caller closes it and must
  // not read from it. Throws Error if the process has none left.
  int descriptor() const;

 protected:
  explicit PendingCall(std::shared_ptr<Operation> operation);
  std::shared_ptr<Operation> operation_;
};

template <class T>
class GICUBE_API Pending : public PendingCall {
 public:
  // Waits for the end of the call. Returns its result, once, or throws what the blocking call would. Throws
  // DeadlinePassed if the result did not come by the simulated time `deadline`: call get() again for it. Throws
  // Cancelled after cancel(), BadArgument if the result was taken before.
  T get(Picoseconds deadline = kNoDeadline);

 private:
  friend struct BoardState;
  using PendingCall::PendingCall;
};

extern template class GICUBE_API Pending<void>;
extern template class GICUBE_API Pending<Image>;
extern template class GICUBE_API Pending<LightingReport>;
extern template class GICUBE_API Pending<std::vector<PairFactor>>;
extern template class GICUBE_API Pending<RayBatch>;

}  // namespace gicube
