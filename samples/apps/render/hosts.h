// Several hosts that make one picture, as ranks of an MPI job: --mpi. The program does not link MPI, but loads
// libgicube-mpi.
#pragma once

#include <functional>
#include <memory>

#include "gicube/mpi.h"
#include "render/options.h"
#include "render/statistics.h"

namespace gicube::samples {

// Whether the command line has --mpi. Asked before it is read, so that its errors come once.
bool asks_for_hosts(int argc, const char* const* argv);

// Throws Error: there is no such library, or MPI's own errors.
std::unique_ptr<MpiExchange> open_hosts();

// A rank's part of the program; returns its exit code. What together() throws in it rank 0 prints; what a rank throws
// alone that rank prints, and ends the job.
int run_rank(MpiExchange& ranks, const std::function<int()>& body);

// A step that the ranks make at the same time. If it throws on one, all throw what it was, with that rank's number
// unless all threw the same. `ranks`: null if there is one host.
void together(RayExchange* ranks, const std::function<void()>& step);

// Takes this rank's board of --board, if that was given once for each, and keeps other ranks than the first from
// printing. Throws UsageError: what one host knows or writes.
void choose_part(const RayExchange& ranks, RenderOptions& options);

// Collective: tells rank 0 what each rank did for a frame.
void share_statistics(RayExchange& ranks, FrameStatistics& statistics);

}  // namespace gicube::samples
