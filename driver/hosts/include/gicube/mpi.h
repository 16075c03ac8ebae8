// The ranks of an MPI job as hosts that share a volume: libgicube-mpi, CMake's gicube::mpi. docs/guide/mpi.md.
//
//   auto ranks = gicube::MpiExchange::open();                 // mpirun -n 4 program
//   board.share_blocks(std::move(ranks));
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "gicube/ray_exchange.h"

namespace gicube {

// exchange() is NBX [Hoefler, Siebert, Lumsdaine, "Scalable Communication Protocols for Dynamic Sparse Data Exchange",
// PPoPP 2010]: synchronous sends, and a barrier that each rank enters when its own have arrived; a rank that is through
// it has all that was sent to it. So its time grows with the ranks that have something for each other and with the
// logarithm of all of them. While a rank waits it sleeps for 50 us at a time, since boards of other ranks may need its
// processor.
//
// Errors of MPI are Error, with MPI's own text. One thread at a time. All of open(), the calls and the destructor are
// collective.
class GICUBE_API MpiExchange : public RayExchange {
 public:
  static constexpr std::size_t kMaxMessage = std::size_t{1} << 30;  // bytes; MPI counts with 31 bits

  // All ranks of the job. MPI is initialised, and finalised by the destructor, unless the program has done that. Larger
  // messages than `max_message`, up to kMaxMessage, are sent in parts. Throws Error, BadArgument (max_message).
  static std::unique_ptr<MpiExchange> open(std::size_t max_message = kMaxMessage);
  // The ranks of a communicator, as its Fortran handle: MPI_Comm_c2f(). It is duplicated, so that messages of the
  // program's own don't get in between.
  static std::unique_ptr<MpiExchange> of(int communicator, std::size_t max_message = kMaxMessage);

  // Unless an exception is on its way: then the ranks would wait for each other, and the job's launcher ends it
  // instead.
  ~MpiExchange() override = default;

  // To other ranks, by exchange().
  virtual std::uint64_t bytes_sent() const = 0;
  // Ends the processes of all ranks, with this exit code, whatever they do (MPI_Abort). Print messages
  // before.
  [[noreturn]] virtual void abort(int code) = 0;
};

}  // namespace gicube

// Like open(), for programs that load the library when they need it. The caller deletes the result.
extern "C" GICUBE_API gicube::MpiExchange* gicube_mpi_open();
