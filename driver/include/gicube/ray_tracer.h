// Rays that the application makes itself (Board::rays()). gicube/ray.h has their records.
#pragma once

#include <span>
#include <vector>

#include "gicube/export.h"
#include "gicube/pending.h"
#include "gicube/ray.h"
#include "gicube/time.h"

namespace gicube {

struct BoardState;

class GICUBE_API RayTracer {
 public:
  explicit RayTracer(BoardState& of) : state_(&of) {}

  // Sends rays, in as many DSP commands as they need. The application's scattering routine is not used. Returns at once
  // unless too many are under way (OpenOptions::back_pressure); the simulated host continues while the board works. Any
  // number of batches may be under way; the caller may reuse its memory on return. If the card does not store the
  // volume whole, the simulated host waits for the rays, and the batch is complete on return; what the board refuses is
  // thrown at once. Throws BadArgument (a ray's index and field, the request's fields), Rejected (no volume; kDeposit
  // and Sampling::irradiance before the irradiance was cleared or lit, kBackproject before its words were cleared),
  // WouldBlock: nothing was sent.
  Ticket submit(std::span<const HostRay> rays, const RayRequest& request = {});
  // Sends rays that lie in several places, as one batch in that order.
  Ticket submit(std::span<const std::span<const HostRay>> rays, const RayRequest& request = {});
  // submit() with a handle in place of a ticket; get() is receive(), and takes its deadline. If the handle is destroyed
  // before, poll() returns its batch. Throws as submit(), and Error if the process has no descriptor left.
  Pending<RayBatch> start(std::span<const HostRay> rays, const RayRequest& request = {});

  // Blocks until that batch has returned, and moves the simulated host's clock to its arrival. Throws BadArgument if
  // the ticket is unknown or its rays were received already; Rejected, Unsupported if the board refused it: the batch
  // is gone; DeadlinePassed if it has not arrived by the simulated time `deadline`: the clock is there, the batch still
  // under way.
  RayBatch receive(Ticket ticket, Picoseconds deadline = kNoDeadline);
  // Receives the rays directly into the caller's memory: as many as were submitted. None are written for a cancelled
  // batch, nor for kDeposit and kBackproject, for which any size is accepted. Throws BadArgument if the size differs:
  // the batch is still there.
  BatchReport receive(Ticket ticket, std::span<TracedRay> rays, Picoseconds deadline = kNoDeadline);
  // The batches that have arrived by now() and were not received yet, in the order of their simulated arrival. If the
  // board refused one, that is thrown first (Rejected, Unsupported): it is gone, the others are still there.
  std::vector<RayBatch> poll();
  // Takes back the part of a batch that the DSP has not begun by now(). Its rays are lost, and receive() or poll()
  // return it as cancelled. False: it is too late, and the batch comes back whole. The simulated host waits for the
  // answer. Throws BadArgument if the ticket is unknown; Unsupported for kDeposit and kBackproject, which can't be
  // taken back.
  bool cancel(Ticket ticket);
  // A file descriptor that poll(), epoll or an event loop can wait for: it becomes readable, and stays so, when
  // receive() would no longer have to wait for the board's work, or if the board is lost or the Board is destroyed.
  // The caller closes it, at any time, and must not read from it. It does not advance simulated time; receive() does.
  // The board answers once it has computed everything that was sent before, so call this right after submit(). With
  // `pace: realtime` receive() may still wait until the wall clock has come to the batch's arrival. After reopen() on a
  // new board ask again. Throws BadArgument as receive(), Error if the process has no descriptor left.
  int descriptor(Ticket ticket);

 private:
  BoardState* state_;
};

}  // namespace gicube
