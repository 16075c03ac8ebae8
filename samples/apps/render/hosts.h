// --mpi: several hosts make one picture, as ranks of an MPI job. The program does not link MPI, but loads
// libgicube-mpi.
#pragma once

#include <functional>
#include <memory>

#include "gicube/mpi.h"
#include "render/options.h"
#include "render/statistics.h"

namespace gicube::samples {

// Whether the command line has --mpi. It is checked before parsing, so that errors are printed only once.
bool asks_for_hosts(int argc, const char* const* argv);

// Throws Error: there is no such library, or MPI's own errors.
std::unique_ptr<MpiExchange> open_hosts();

// Runs a rank's part of the program and returns its exit code. Rank 0 prints an error of together(); a rank prints its
// own other errors, and they end the job.
int run_rank(MpiExchange& ranks, const std::function<int()>& body);

// A collective step. If it throws on one rank, all throw that error, with the rank's number unless all threw the same.
// `ranks`: null if there is one host.
void together(RayExchange* ranks, const std::function<void()>& step);

// Selects this rank's board if --board was given for each rank, and silences all ranks except the first. Throws
// UsageError for options that work on one host only.
void choose_part(const RayExchange& ranks, RenderOptions& options);

// Collective: sends the statistics of a frame from each rank to rank 0.
void share_statistics(RayExchange& ranks, FrameStatistics& statistics);

}  // namespace gicube::samples
